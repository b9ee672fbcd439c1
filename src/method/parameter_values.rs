//! Types of parameters. Each knows its range and holds nothing that lies outside.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::SceneTraits;
use super::bounded_numbers::bounded;
use super::parameters::ParameterValue;
use crate::estimate::RadiusRule;
use crate::transport::Limits;
use crate::transport::bidirectional::{Heuristic, Measure, Show};
use crate::transport::counters::Step;
use crate::transport::kernel::Kernel;
use crate::transport::occlusion::Occlusion;

/// A number, or the word `auto`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Auto<T> {
    /// Chosen by the program.
    #[default]
    Auto,
    /// Chosen by the user.
    #[serde(untagged)]
    Value(T),
}

/// One of many, or the word `all`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum All<T> {
    /// All of them.
    #[default]
    All,
    /// No other.
    #[serde(untagged)]
    Only(T),
}

impl<T> All<T> {
    /// The only one that counts, if not all do.
    pub(crate) fn only(self) -> Option<T> {
        match self {
            Self::All => None,
            Self::Only(value) => Some(value),
        }
    }
}

/// A number, or the word `off`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Switchable<T> {
    /// Without it.
    #[default]
    Off,
    /// With this number.
    #[serde(untagged)]
    On(T),
}

impl<T> Switchable<T> {
    /// The number, unless it is off.
    pub(crate) fn on(self) -> Option<T> {
        match self {
            Self::Off => None,
            Self::On(value) => Some(value),
        }
    }
}

bounded! {
    /// A share that is neither nothing nor all.
    pub(crate) struct OpenUnit(f64), [above 0, below 1]
}
bounded! {
    /// Passes of a job.
    pub(crate) struct Passes(u32), [1 to 2147483648]
}
bounded! {
    /// Photons, or light subpaths, of a pass.
    pub(crate) struct PhotonCount(u32) or Auto, [1 to 67108864]
}
bounded! {
    /// A radius, m, whose square single precision holds.
    pub(crate) struct Radius(f64) or Auto, [1e-18 to 1e18]
}
bounded! {
    /// The longest path in segments, or −1.
    pub(crate) struct Depth(i64), [1 to 2147483648, -1 for unlimited]
}
bounded! {
    /// Segments from which Russian roulette may end a path.
    pub(crate) struct RouletteDepth(u32), [1 to 2147483648]
}
bounded! {
    /// The segments of a path.
    pub(crate) struct PathLength(u32) or All, [1 to 65535]
}

impl Auto<PhotonCount> {
    /// Becomes a number where it is `auto`: one per pixel, 65536 to 1048576.
    pub(crate) fn settle(&mut self, pixels: u64) -> u32 {
        let count = match *self {
            Self::Value(count) => count,
            Self::Auto => PhotonCount(pixels.clamp(1 << 16, 1 << 20) as u32),
        };
        *self = Self::Value(count);
        count.get()
    }

    /// Becomes the number of pixels, which is returned; more than a user may give are not written out.
    pub(crate) fn settle_to_pixels(&mut self, pixels: u64) -> u32 {
        let pixels = one_per_pixel(pixels);
        *self = PhotonCount::new(pixels).map_or(*self, Self::Value);
        pixels
    }
}

/// The light subpaths of a pass where nothing is merged. No picture has 2³² pixels.
pub(crate) fn one_per_pixel(pixels: u64) -> u32 {
    u32::try_from(pixels).unwrap_or(u32::MAX)
}

impl Auto<Radius> {
    /// The radius in single precision, m.
    pub(crate) fn meters(self) -> Auto<f32> {
        match self {
            Self::Auto => Auto::Auto,
            Self::Value(radius) => Auto::Value(radius.get() as f32),
        }
    }
}

/// Limits on path length.
pub(crate) fn limits(max_depth: Depth, rr_depth: RouletteDepth) -> Limits {
    Limits { max_depth: u32::try_from(max_depth.get()).ok(), rr_depth: rr_depth.get() }
}

/// A way of finding paths, "s,t" to users: vertices of the light and of the camera subpath.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Subpaths {
    /// s.
    pub light: u32,
    /// t.
    pub camera: u32,
}

impl Serialize for Subpaths {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{},{}", self.light, self.camera))
    }
}

impl<'de> Deserialize<'de> for Subpaths {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let number = |text: &str| text.trim().parse().map_err(de::Error::custom);
        let (light, camera) = text.split_once(',').ok_or_else(|| de::Error::custom("allowed: s,t"))?;
        Ok(Self { light: number(light)?, camera: number(camera)? })
    }
}

impl ParameterValue for All<Subpaths> {
    const RANGE: &'static str = "s,t, all";
}

/// A part of a method that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Switch {
    /// It takes part.
    On,
    /// It does not.
    Off,
}

impl Switch {
    /// Whether it is on.
    pub(crate) fn is_on(self) -> bool {
        self == Self::On
    }
}

impl ParameterValue for Switch {
    const RANGE: &'static str = "on, off";
}

/// How light that arrives straight from a source is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum DirectLight {
    /// Light and material sampling; photons count from their second surface on.
    Sample,
    /// By photons alone.
    Photons,
}

impl DirectLight {
    /// What sampling lights is good for where none is seen.
    pub(crate) fn futile_in(self, traits: SceneTraits) -> Option<&'static str> {
        (self == Self::Sample && traits.sealed_lights).then_some(
            "nearly all light meets mirrors or glass first, so direct: sample finds hardly any; direct: photons spares its rays",
        )
    }
}

impl ParameterValue for DirectLight {
    const RANGE: &'static str = "sample, photons";
}

/// How a light is picked where lights are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightPicks {
    /// By visible importance where the pilot finds that it helps.
    Auto,
    /// By importance, whatever is in between.
    Importance,
    /// By importance and what the pilot learns of occlusion.
    Visible,
}

impl ParameterValue for LightPicks {
    const RANGE: &'static str = "auto, importance, visible";
}

/// Where on lights photons start, and in which directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Emission {
    /// Guided where the pilot finds that it helps.
    Auto,
    /// By power.
    Power,
    /// As the pilot learns from what photons are to the picture.
    Guided,
}

impl ParameterValue for Emission {
    const RANGE: &'static str = "auto, power, guided";
}

/// The same for methods whose photons are only gathered: they may be states of chains, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PhotonEmission {
    /// Guided where the pilot finds that it helps.
    Auto,
    /// By power.
    Power,
    /// As the pilot learns from what photons are to the picture.
    Guided,
    /// As `auto`, in Markov chains of whole paths that stay where the picture looks.
    Metropolis,
}

impl ParameterValue for PhotonEmission {
    const RANGE: &'static str = "auto, power, guided, metropolis";
}

impl PhotonEmission {
    /// What chains are proposed, if there are any.
    pub(crate) fn proposals(self) -> &'static [Step] {
        if self == Self::Metropolis { &[Step::Small, Step::Large] } else { &[] }
    }

    /// How paths begin, whether they are in chains or not.
    pub(crate) fn of_paths(self) -> Emission {
        match self {
            Self::Auto | Self::Metropolis => Emission::Auto,
            Self::Power => Emission::Power,
            Self::Guided => Emission::Guided,
        }
    }
}

/// How photon-path pairs are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Weights {
    /// By the densities with which paths are found, merging included [Georgiev et al. 2012].
    Consistent,
    /// By products of directional densities [Vorba 2011].
    Paper,
}

impl Weights {
    /// In which measure densities are compared.
    pub(crate) fn measure(self) -> Measure {
        match self {
            Self::Consistent => Measure::Area,
            Self::Paper => Measure::SolidAngle,
        }
    }
}

impl ParameterValue for Weights {
    const RANGE: &'static str = "consistent, paper";
}

impl ParameterValue for RadiusRule {
    const RANGE: &'static str = "statistics, schedule, uniformity";
}

/// How the radii of merging shrink. It does not measure how evenly light lies in discs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MergingRadiusRule {
    /// From what each pixel found.
    Statistics,
    /// From the pass index alone.
    Schedule,
}

impl From<MergingRadiusRule> for RadiusRule {
    fn from(rule: MergingRadiusRule) -> Self {
        match rule {
            MergingRadiusRule::Statistics => Self::Statistics,
            MergingRadiusRule::Schedule => Self::Schedule,
        }
    }
}

impl ParameterValue for MergingRadiusRule {
    const RANGE: &'static str = "statistics, schedule";
}

impl ParameterValue for Occlusion {
    const RANGE: &'static str = "off, unclear, all";
}

impl ParameterValue for Kernel {
    const RANGE: &'static str = "disc, cone, epanechnikov";
}

impl ParameterValue for Heuristic {
    const RANGE: &'static str = "balance, power";
}

impl ParameterValue for Show {
    const RANGE: &'static str = "radiance, unweighted, weights";
}
