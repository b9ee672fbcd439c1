//! Parameters of the methods that make paths from two ends. Each method takes some of them.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::parameters::{self, Auto, ParameterHelp, ParameterSet, first_bad, help, is_depth, photon_count, radius};
use super::{CheckedMethod, MethodChoice, MethodError};
use crate::estimate::RadiusRule;
use crate::transport::Limits;
use crate::transport::bidirectional::{Heuristic, Measure, Selection, Show, Techniques, Weighting};
use crate::transport::kernel::Kernel;

/// A part of a method that can be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Switch {
    /// It takes part.
    #[default]
    On,
    /// It does not.
    Off,
}

impl Switch {
    /// Whether it is on.
    pub fn is_on(self) -> bool {
        self == Self::On
    }
}

/// How photon-path pairs are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weights {
    /// By the densities with which paths are found, merging included [Georgiev et al. 2012].
    #[default]
    Consistent,
    /// By products of directional densities [Vorba 2011].
    Paper,
}

/// All parameters; the helps say what they mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(missing_docs, reason = "the helps say what each means")]
pub struct BidirectionalParameters {
    pub alpha: f64,
    pub radius_rule: RadiusRule,
    pub photons_per_pass: Value,
    pub initial_radius: Value,
    pub light_sampling: Switch,
    pub material_sampling: Switch,
    pub connect: Switch,
    pub merge: Switch,
    pub light_hits: Switch,
    pub camera_hits: Switch,
    pub weights: Weights,
    pub kernel: Kernel,
    pub neighbors: u32,
    pub heuristic: Heuristic,
    pub max_depth: i64,
    pub rr_depth: i64,
    pub length: Value,
    pub strategy: Value,
    pub show: Show,
    pub passes: u32,
}

impl Default for BidirectionalParameters {
    fn default() -> Self {
        Self {
            alpha: 2.0 / 3.0,
            radius_rule: RadiusRule::Statistics,
            photons_per_pass: "auto".into(),
            initial_radius: "auto".into(),
            light_sampling: Switch::On,
            material_sampling: Switch::On,
            connect: Switch::On,
            merge: Switch::On,
            light_hits: Switch::On,
            camera_hits: Switch::On,
            weights: Weights::Consistent,
            kernel: Kernel::Disc,
            neighbors: 0,
            heuristic: Heuristic::Balance,
            max_depth: -1,
            rr_depth: 3,
            length: "all".into(),
            strategy: "all".into(),
            show: Show::Radiance,
            passes: 256,
        }
    }
}

/// `max_depth`, `rr_depth`, `length` and `passes`, which all of the methods take.
pub const MAX_DEPTH: ParameterHelp =
    help("max_depth", "longest path in segments (2 is direct light)", "1 to 2147483648, -1 for unlimited", "-1");
/// See [`MAX_DEPTH`].
pub const RR_DEPTH: ParameterHelp =
    help("rr_depth", "segments from which Russian roulette may end a subpath", "1 or more", "3");
/// See [`MAX_DEPTH`].
pub const LENGTH: ParameterHelp = help("length", "only paths of so many segments", "1 to 65535, all", "all");
/// See [`MAX_DEPTH`].
pub const PASSES: ParameterHelp = help("passes", "passes when no stop rule is given", "1 to 2147483648", "256");
/// For methods with more than one technique.
pub const HEURISTIC: ParameterHelp =
    help("heuristic", "how densities of techniques become weights", "balance, power", "balance");
/// For methods with light subpaths.
pub const STRATEGY: ParameterHelp = help(
    "strategy",
    "only paths of s light and t camera vertices (segments where they are merged), weighted as always",
    "s,t, all",
    "all",
);
/// For methods with light subpaths.
pub const SHOW: ParameterHelp = help(
    "show",
    "radiance; unweighted, as if each strategy stood alone; or weights: red over green is the mean weight of the light that \
     a pixel's strategies found",
    "radiance, unweighted, weights",
    "radiance",
);
/// For methods that merge.
pub const PHOTONS: ParameterHelp = help(
    "photons_per_pass",
    "light subpaths per pass",
    "1 to 67108864, auto",
    "auto: one per pixel, 65536 to 1048576; always one per pixel where nothing is merged",
);
/// For methods that merge.
pub const INITIAL_RADIUS: ParameterHelp =
    help("initial_radius", "first merging radius, m", "above 0, auto", "auto: per pixel by a pilot pass");
/// For `bdpm` and `pbdpm`.
pub const WEIGHTS: ParameterHelp =
    help("weights", "how pairs of photon and path are weighted", "consistent, paper", "consistent");
/// For `bdpm` and `pbdpm`.
pub const LIGHT_HITS: ParameterHelp = help("light_hits", "whether camera paths that hit lights count", "on, off", "on");
/// For `bdpm` and `pbdpm`.
pub const CAMERA_HITS: ParameterHelp =
    help("camera_hits", "whether photons are connected with the camera", "on, off", "on");
/// For methods that merge progressively.
pub const ALPHA: ParameterHelp =
    help("alpha", "share of each pass's photons that is kept as the radius shrinks", "above 0, below 1", "0.6667");
/// For methods that merge progressively.
pub const RADIUS_RULE: ParameterHelp = help("radius_rule", "how radii shrink", "statistics, schedule", "statistics");

/// `[s, t]` from "s,t"; `None` inside for "all".
fn strategy(value: &Value) -> Option<Option<[u32; 2]>> {
    let text = value.as_str()?;
    if text == "all" {
        return Some(None);
    }
    let (light, camera) = text.split_once(',')?;
    Some(Some([light.trim().parse().ok()?, camera.trim().parse().ok()?]))
}

fn length(value: &Value) -> Option<Option<u32>> {
    match value {
        Value::String(word) if word == "all" => Some(None),
        value => Some(Some(value.as_u64().filter(|length| (1..=65_535).contains(length))? as u32)),
    }
}

impl ParameterSet for BidirectionalParameters {
    fn check_ranges(&self) -> Result<(), &'static str> {
        first_bad(&[
            ("alpha", self.alpha > 0.0 && self.alpha < 1.0),
            ("photons_per_pass", photon_count(&self.photons_per_pass).is_some()),
            ("initial_radius", radius(&self.initial_radius).is_some()),
            ("max_depth", is_depth(self.max_depth)),
            ("rr_depth", self.rr_depth >= 1),
            ("neighbors", self.neighbors == 0 || (2..=65_536).contains(&self.neighbors)),
            ("length", length(&self.length).is_some()),
            ("strategy", strategy(&self.strategy).is_some()),
            ("passes", (1..=1 << 31).contains(&self.passes)),
        ])
    }
}

impl BidirectionalParameters {
    /// Reads what a user gave for `method`, which knows `known`.
    pub fn read(method: &'static str, choice: &MethodChoice, known: &[ParameterHelp]) -> Result<Self, MethodError> {
        parameters::read(method, &choice.parameters, known)
    }

    /// The checked choice of a method with `techniques` for a picture of `pixels`.
    pub fn checked(
        mut self,
        name: &str,
        known: &[ParameterHelp],
        techniques: Techniques,
        pixels: u64,
    ) -> CheckedMethod {
        let merges = techniques.any(Techniques::MERGE);
        let photons_per_pass =
            if merges { parameters::photons_for(&self.photons_per_pass, pixels) } else { pixels as u32 };
        self.photons_per_pass = photons_per_pass.into();
        let progressive = known.iter().any(|parameter| parameter.name == ALPHA.name);
        let (radius_rule, alpha) = match merges {
            true if progressive => (self.radius_rule, self.alpha),
            // A schedule that keeps every photon keeps the radius.
            _ => (RadiusRule::Schedule, 1.0),
        };
        let passes = self.passes;
        let choice = parameters::written_out(name, self, known);
        CheckedMethod { choice, radius_rule, alpha, photons_per_pass, passes }
    }

    /// Merging, and what [`LIGHT_HITS`] and [`CAMERA_HITS`] add to it.
    pub fn photon_techniques(&self) -> Techniques {
        Techniques::MERGE
            .with(Techniques::HIT, self.light_hits.is_on())
            .with(Techniques::CAMERA, self.camera_hits.is_on())
    }

    /// Limits on path length.
    pub fn limits(&self) -> Limits {
        // Longer paths than those that are looked at need not be traced.
        let limits = parameters::limits(self.max_depth, self.rr_depth);
        let longest = length(&self.length).flatten();
        Limits { max_depth: limits.max_depth.into_iter().chain(longest).min(), ..limits }
    }

    /// First merging radius, m.
    pub fn first_radius(&self) -> Auto<f32> {
        radius(&self.initial_radius).unwrap_or_default()
    }

    /// Which paths are counted.
    pub fn selection(&self) -> Selection {
        let (length, strategy) = (length(&self.length).flatten(), strategy(&self.strategy).flatten());
        Selection { length, strategy, show: self.show }
    }

    /// How `techniques` share paths when there are `light_paths` a pass.
    pub fn weighting(&self, techniques: Techniques, light_paths: u32) -> Weighting {
        let measure = match self.weights {
            Weights::Consistent => Measure::Area,
            Weights::Paper => Measure::SolidAngle,
        };
        Weighting { techniques, heuristic: self.heuristic, measure, light_paths: light_paths as f32 }
    }
}
