//! Parameters of `photon_map`.

use super::storage::Storage;
use crate::math::trigonometry::sin_cos_turn;
use crate::method::bounded_numbers::bounded;
use crate::method::parameter_values::{
    Auto, Depth, LightPicks, Passes, PhotonCount, PhotonEmission, Radius, RouletteDepth, Switch, Switchable,
};
use crate::method::parameters::{Parameter, ParameterValue, parameter, parameters};
use crate::method::shared_parameters::{EMISSION, LIGHT_PICKS, MAX_DEPTH, OCCLUSION, PASSES, PHOTONS, RR_DEPTH};
use crate::transport::caustic_splitting::Splitting;
use crate::transport::kernel::Kernel;
use crate::transport::neighbor_choice::NeighborChoice;
use crate::transport::occlusion::Occlusion;

bounded! {
    /// k, photons in a look-up.
    pub(super) struct Neighbors(u32), [2 to 65536]
}

bounded! {
    /// Maps that every estimate is the mean of.
    pub(super) struct MapCount(u32), [1 to 64]
}

bounded! {
    /// Camera paths of a pixel and pass.
    pub(super) struct CameraPaths(u32), [1 to 64]
}

bounded! {
    /// S: the maps that pixels look at in turn are S².
    pub(super) struct Skipping(u32), [1 to 16]
}

bounded! {
    /// Levels of a scanline's hat basis under its base.
    pub(super) struct Levels(u32), [0 to 16]
}

bounded! {
    /// Samples of a pixel on a level.
    pub(super) struct LevelSamples(u32), [1 to 256]
}

bounded! {
    /// The contrast from which pixels are localized, %; 0 localizes none.
    pub(super) struct Contrast(u32), [0 to 1000]
}

bounded! {
    /// Gather rays of a camera path.
    pub(super) struct GatherRays(u32), [0 to 1024]
}

bounded! {
    /// The largest angle between a photon's direction and the normal, degrees.
    pub(super) struct ArrivalAngle(u32), [1 to 180]
}

impl ArrivalAngle {
    /// Its cosine; `None` where every direction is allowed.
    pub(super) fn least_cosine(self) -> Option<f32> {
        (self.get() < 180).then(|| sin_cos_turn(self.get() as f32 / 360.0).1)
    }
}

bounded! {
    /// A share of k photons, %.
    pub(super) struct ShareOfNeighbors(u32), [0 to 100]
}

bounded! {
    /// S, caustic photons for each that the pass would have.
    pub(super) struct SplittingFactor(u32), [1 to 4096]
}

impl ParameterValue for Splitting {
    const RANGE: &'static str = "brute, metropolis, projection";
}

impl ParameterValue for Storage {
    const RANGE: &'static str = "all, importance";
}

bounded! {
    /// Light samples at a point.
    pub(super) struct LightSamples(u32), [1 to 1024]
}

bounded! {
    /// How far a look-up is used again, in its radii.
    pub(super) struct Reuse(f64), [0.0 to 1.0]
}

/// How direct light is found where a camera path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum DirectMode {
    /// Lights are sampled.
    Sample,
    /// Photons that came straight from lights are looked up.
    Photons,
    /// Lights are sampled, with shadow rays only where photons do not tell what is seen.
    ShadowPhotons,
    /// Lights are sampled by the energy of the photons that came from them.
    PhotonDirect,
}

impl ParameterValue for DirectMode {
    const RANGE: &'static str = "sample, photons, shadow_photons, photon_direct";
}

bounded! {
    /// a, the largest error of interpolated irradiance.
    pub(super) struct CacheError(f64) or Switchable, [0.001 to 1.0]
}

bounded! {
    /// Gather rays of a record.
    pub(super) struct CacheRays(u32) or Auto, [16 to 4096]
}

/// The structure that photons are looked up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Structure {
    /// Cells of equal size.
    Grid,
    /// A balanced tree.
    KdTree,
}

impl ParameterValue for Structure {
    const RANGE: &'static str = "grid, kdtree";
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShownPart {
    /// Radiance.
    Radiance,
    /// White where a pixel is localized, black where it is not.
    Localized,
}

impl ParameterValue for ShownPart {
    const RANGE: &'static str = "radiance, localized";
}

/// `coarsest_samples` where the user named none.
pub(super) const DEFAULT_COARSEST: LevelSamples = LevelSamples::new(38).expect("in range");
/// `finest_samples` where the user named none.
pub(super) const DEFAULT_FINEST: LevelSamples = LevelSamples::new(1).expect("in range");

impl ParameterValue for NeighborChoice {
    const RANGE: &'static str = "fixed, centre_of_gravity, mean_direction";
}

/// How many photons a look-up of the global map takes.
pub(super) const NEIGHBORS: Parameter<Neighbors> =
    parameter("nearest photons in a look-up of the global map", Neighbors::new(20).expect("in range"), "20");

/// The same of the caustic map.
pub(super) const CAUSTIC_NEIGHBORS: Parameter<Neighbors> =
    parameter("nearest photons in a look-up of the caustic map", Neighbors::new(10).expect("in range"), "10");

/// How far look-ups reach.
pub(super) const LARGEST_RADIUS: Parameter<Auto<Radius>> = parameter(
    "largest radius of a look-up, m; gather rays shorter than it go on",
    Auto::Auto,
    "auto: half the area that k photons take on average",
);

/// Whether irradiance is interpolated.
pub(super) const CACHE_ERROR: Parameter<Switchable<CacheError>> = parameter(
    "irradiance cache: error that interpolation on matte surfaces may have, Ward's a",
    Switchable::Off,
    "off",
);

/// From what.
pub(super) const CACHE_RAYS: Parameter<Auto<CacheRays>> =
    parameter("irradiance cache: gather rays of a record", Auto::Auto, "auto: 256");

/// Camera paths of a pixel.
pub(super) const CAMERA_PATHS: Parameter<CameraPaths> = parameter(
    "camera paths per pixel and pass, which all look at the same maps",
    CameraPaths::new(1).expect("in range"),
    "1",
);

parameters! {
    /// Parameters of `photon_map`.
    pub(super) struct Parameters {
        photons_per_pass: Auto<PhotonCount> = PHOTONS,
        neighbors: Neighbors = NEIGHBORS,
        caustic_neighbors: Neighbors = CAUSTIC_NEIGHBORS,
        largest_radius: Auto<Radius> = LARGEST_RADIUS,
        kernel: Kernel = parameter("how photons count by their distance", Kernel::Epanechnikov, "epanechnikov"),
        direct: DirectMode = parameter(
            "how direct light is found at wide lobes: sample, by light samples; photons, by those that came straight from lights; \
             shadow_photons, by light samples with shadow rays only where photons do not tell what is seen; photon_direct, by light \
             samples in proportion to what photons brought from each light",
            DirectMode::Sample,
            "sample",
        ),
        direct_samples: LightSamples = parameter(
            "light samples at a wide lobe; photon_direct takes one more, picked as everywhere",
            LightSamples::new(1).expect("in range"),
            "1",
        ),
        direct_neighbors: Neighbors = parameter(
            "nearest photons in a look-up of direct photons",
            Neighbors::new(50).expect("in range"),
            "50",
        ),
        direct_reuse: Reuse = parameter(
            "how far photon_direct uses a look-up again in the row of pixels, in radii of that look-up; 0 never",
            Reuse::new(0.5).expect("in range"),
            "0.5",
        ),
        light_picks: LightPicks = LIGHT_PICKS,
        emission: PhotonEmission = EMISSION,
        occlusion: Occlusion = OCCLUSION,
        neighbor_choice: NeighborChoice = parameter(
            "by what a look-up takes fewer photons where they lie on one side: fixed, nothing; their centre of gravity; their mean \
             direction, which has no bias where light is even",
            NeighborChoice::Fixed,
            "fixed",
        ),
        arrival_angle: ArrivalAngle = parameter(
            "photons do not count that came from so many degrees or more off the normal",
            ArrivalAngle::new(180).expect("in range"),
            "180: all count",
        ),
        culling_plane: Switch =
            parameter("whether photons behind the plane through a point do not count there", Switch::Off, "off"),
        fewest_photons: ShareOfNeighbors = parameter(
            "look-ups of the caustic map that find less than so many % of their photons within the largest radius are black",
            ShareOfNeighbors::new(0).expect("in range"),
            "0",
        ),
        final_gather: GatherRays = parameter(
    "gather rays per camera path; 0 looks at the global map directly",
    GatherRays::new(4).expect("in range"),
    "4",
),
        cache_error: Switchable<CacheError> = CACHE_ERROR,
        cache_rays: Auto<CacheRays> = CACHE_RAYS,
        structure: Structure =
            parameter("what photons are looked up in: cells or a balanced tree", Structure::Grid, "grid"),
        maps: MapCount = parameter(
            "maps that a pass's photons are divided among; every estimate is the mean of all",
            MapCount::new(1).expect("in range"),
            "1",
        ),
        camera_paths: CameraPaths = CAMERA_PATHS,
        skipping: Skipping = parameter(
            "S: a pass traces S² times as many maps, one after the other, and each pixel looks at one of them at random",
            Skipping::new(1).expect("in range"),
            "1",
        ),
        hierarchy: Levels = parameter(
            "levels of each scanline's hat basis, whose finer levels are sampled with fewer maps; 0: every pixel is sampled alike",
            Levels::new(0).expect("in range"),
            "0",
        ),
        coarsest_samples: LevelSamples = parameter(
            "with hierarchy: samples on the coarsest level, each with a map of its own",
            DEFAULT_COARSEST,
            "38",
        ),
        finest_samples: LevelSamples =
            parameter("with hierarchy: samples on the finest level, at most coarsest_samples", DEFAULT_FINEST, "1"),
        localization: Contrast = parameter(
            "with hierarchy: pixels that differ by so much from what is interpolated are sampled with all maps, %; 0: none",
            Contrast::new(0).expect("in range"),
            "0",
        ),
        show: ShownPart = parameter(
            "radiance; or localized: the share of passes in which a pixel is sampled with all maps",
            ShownPart::Radiance,
            "radiance",
        ),
        caustic_splitting: SplittingFactor = parameter(
            "how many times as many caustic photons as others, each with so much less flux",
            SplittingFactor::new(1).expect("in range"),
            "1",
        ),
        splitting: Splitting = parameter(
            "how more caustic photons are found: brute, by more paths; projection, by those of them that may meet a specular surface \
             first; metropolis, by mutations of those found",
            Splitting::Brute,
            "brute",
        ),
        storage: Storage = parameter(
            "which photons the global map stores: all; importance, mostly those where gather rays end, weighted for it",
            Storage::All,
            "all",
        ),
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = RR_DEPTH,
        passes: Passes = PASSES,
    }
}
