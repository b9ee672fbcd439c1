//! Parameters that several methods have.

use super::parameter_values::{
    All, Auto, Depth, DirectLight, Emission, LightPicks, MergingRadiusRule, OpenUnit, Passes, PathLength, PhotonCount,
    PhotonEmission, Radius, RouletteDepth, Subpaths, Switch, Weights,
};
use super::parameters::{Parameter, parameter};
use crate::estimate::RadiusRule;
use crate::transport::bidirectional::{Heuristic, Show};
use crate::transport::occlusion::Occlusion;

/// For all methods.
pub(crate) const MAX_DEPTH: Parameter<Depth> =
    parameter("longest path in segments (2 is direct light)", Depth::new(-1).expect("in range"), "-1");
/// For all methods.
pub(crate) const PASSES: Parameter<Passes> =
    parameter("passes when no stop rule is given", Passes::new(256).expect("in range"), "256");

/// For methods whose radii shrink.
pub(crate) const ALPHA: Parameter<OpenUnit> = parameter(
    "share of each pass's photons that is kept as the radius shrinks",
    OpenUnit::new(2.0 / 3.0).expect("in range"),
    "0.6667",
);
/// For `sppm` and `ppm`.
pub(crate) const RADIUS_RULE: Parameter<RadiusRule> = parameter(
    "how radii shrink: by the photons found; by the passes alone; by the photons found, but only where they do not lie evenly",
    RadiusRule::Statistics,
    "statistics",
);
/// For methods that merge subpaths in discs that shrink.
pub(crate) const MERGING_RADIUS_RULE: Parameter<MergingRadiusRule> =
    parameter("how radii shrink", MergingRadiusRule::Statistics, "statistics");

/// For methods that follow photons to where camera paths gather them.
pub(crate) const PHOTONS: Parameter<Auto<PhotonCount>> =
    parameter("photons emitted per pass", Auto::Auto, "auto: one per pixel, 65536 to 1048576");
/// For methods that follow photons to where camera paths gather them.
pub(crate) const RR_DEPTH: Parameter<RouletteDepth> =
    parameter("segments from which Russian roulette may end a path", RouletteDepth::new(1).expect("in range"), "1");

/// For `sppm` and `ppm`.
pub(crate) const GATHER_RADIUS: Parameter<Auto<Radius>> =
    parameter("first gather radius, m", Auto::Auto, "auto: per pixel by a pilot pass");
/// For methods that sample lights.
pub(crate) const LIGHT_PICKS: Parameter<LightPicks> = parameter(
    "how a light is picked where lights are sampled: by importance, an estimate without occlusion; visible, by what a pilot \
     learns of occlusion, too; auto: visible where the pilot finds that it helps",
    LightPicks::Auto,
    "auto",
);
/// For `sppm`, `ppm` and `photon_map`.
pub(crate) const EMISSION: Parameter<PhotonEmission> = parameter(
    "where photons start: by power; guided, mostly where they reach what pixels see, weighted for it; auto: guided where the \
     pilot finds that it helps; metropolis: as auto, in chains of whole paths that stay where the picture looks, weighted for it",
    PhotonEmission::Auto,
    "auto",
);
/// For `sppm` and `ppm`.
pub(crate) const DIRECT: Parameter<DirectLight> = parameter("how direct light is found", DirectLight::Sample, "sample");

/// For methods that gather photons.
pub(crate) const OCCLUSION: Parameter<Occlusion> = parameter(
    "which photons count only where their origin is seen: off, none; unclear, those behind something that stands on the surface; all",
    Occlusion::Unclear,
    "unclear",
);

/// For methods that make paths from two ends and merge them.
pub(crate) const LIGHT_SUBPATHS: Parameter<Auto<PhotonCount>> = parameter(
    "light subpaths per pass",
    Auto::Auto,
    "auto: one per pixel, 65536 to 1048576; always one per pixel where nothing is merged",
);
/// For methods that make paths from two ends and merge them.
pub(crate) const MERGING_RADIUS: Parameter<Auto<Radius>> =
    parameter("first merging radius, m", Auto::Auto, "auto: per pixel by a pilot pass");
/// For methods that make paths from two ends.
pub(crate) const SUBPATH_RR_DEPTH: Parameter<RouletteDepth> =
    parameter("segments from which Russian roulette may end a subpath", RouletteDepth::new(3).expect("in range"), "3");
/// For methods with light subpaths.
pub(crate) const SUBPATH_EMISSION: Parameter<Emission> = parameter(
    "how a light is picked for light subpaths and photons: by power; guided, mostly where they reach what pixels see, weighted for \
     it; auto: guided where the pilot finds that it helps",
    Emission::Auto,
    "auto",
);
/// For methods that make paths from two ends.
pub(crate) const LENGTH: Parameter<All<PathLength>> = parameter("only paths of so many segments", All::All, "all");
/// For methods with more than one technique.
pub(crate) const HEURISTIC: Parameter<Heuristic> =
    parameter("how densities of techniques become weights", Heuristic::Balance, "balance");
/// For methods that tell strategies apart.
pub(crate) const STRATEGY: Parameter<All<Subpaths>> = parameter(
    "only paths of s light and t camera vertices (segments where they are merged), weighted as always",
    All::All,
    "all",
);
/// For methods that tell strategies apart.
pub(crate) const SHOW: Parameter<Show> = parameter(
    "radiance; unweighted, as if each strategy stood alone; or weights: red over green is the mean weight of the light that \
     a pixel's strategies found",
    Show::Radiance,
    "radiance",
);

/// For `bdpm` and `pbdpm`.
pub(crate) const WEIGHTS: Parameter<Weights> =
    parameter("how pairs of photon and path are weighted", Weights::Consistent, "consistent");
/// For `bdpm` and `pbdpm`.
pub(crate) const LIGHT_HITS: Parameter<Switch> =
    parameter("whether camera paths that hit lights count", Switch::On, "on");
/// For `bdpm` and `pbdpm`.
pub(crate) const CAMERA_HITS: Parameter<Switch> =
    parameter("whether photons are connected with the camera", Switch::On, "on");
