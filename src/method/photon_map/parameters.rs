//! Parameters of `photon_map`.

use crate::method::bounded_numbers::bounded;
use crate::method::parameter_values::{Auto, Depth, Emission, LightPicks, Passes, PhotonCount, Radius, RouletteDepth};
use crate::method::parameters::{ParameterValue, parameter, parameters};
use crate::method::shared_parameters::{EMISSION, LIGHT_PICKS, MAX_DEPTH, OCCLUSION, PASSES, PHOTONS, RR_DEPTH};
use crate::transport::kernel::Kernel;
use crate::transport::occlusion::Occlusion;

bounded! {
    /// k, photons in a look-up.
    pub(super) struct Neighbors(u32), [2 to 65536]
}

bounded! {
    /// Gather rays of a camera path.
    pub(super) struct GatherRays(u32), [0 to 1024]
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

parameters! {
    /// Parameters of `photon_map`.
    pub(super) struct Parameters {
        photons_per_pass: Auto<PhotonCount> = PHOTONS,
        neighbors: Neighbors = parameter(
            "nearest photons in a look-up of the global map",
            Neighbors::new(20).expect("in range"),
            "20",
        ),
        caustic_neighbors: Neighbors = parameter(
            "nearest photons in a look-up of the caustic map",
            Neighbors::new(10).expect("in range"),
            "10",
        ),
        largest_radius: Auto<Radius> = parameter(
            "largest radius of a look-up, m; gather rays shorter than it go on",
            Auto::Auto,
            "auto: half the area that k photons take on average",
        ),
        kernel: Kernel = parameter("how photons count by their distance", Kernel::Epanechnikov, "epanechnikov"),
        light_picks: LightPicks = LIGHT_PICKS,
        emission: Emission = EMISSION,
        occlusion: Occlusion = OCCLUSION,
        final_gather: GatherRays = parameter(
            "gather rays per camera path; 0 looks at the global map directly",
            GatherRays::new(4).expect("in range"),
            "4",
        ),
        structure: Structure =
            parameter("what photons are looked up in: cells or a balanced tree", Structure::Grid, "grid"),
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = RR_DEPTH,
        passes: Passes = PASSES,
    }
}
