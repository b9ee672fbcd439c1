//! `bdpm`: bidirectional photon mapping. The photon map is queried at every vertex of a camera path, with a radius that stays,
//! and each pair of photon and path is weighted against the other vertices where the same path could have been joined. So
//! glossy surfaces are followed and matte ones gathered at without any rule that says which is which.
//!
//! References: \[Vo11\] Vorba 2011, "Bidirectional photon mapping", chapter 3; \[G+12\] Georgiev, Křivánek, Davidovič & Slusallek 2012,
//! "Light transport simulation with vertex connection and merging".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | T | `Vertex::throughput` of the camera subpath [Vo11, eq. 1.11] | – |
//! | α_p | flux of a photon, un-normalised | W |
//! | w | `Weighting::merged` [Vo11, eq. 3.15; G+12, eq. 13] | – |
//!
//! `weights: paper` are those of \[Vo11\], products of directional densities, which do not see that merging needs a photon nearby;
//! `weights: consistent` count that as a factor π r² n in the density.
//!
//! Limits: the radius stays, so a bias stays: `pbdpm` shrinks it.

use std::sync::Arc;

use super::bidirectional_settings::{MergeSettings, PassSettings, Paths, photon_techniques};
use super::bounded_numbers::bounded;
use super::parameter_values::{
    All, Auto, Depth, Emission, Passes, PathLength, PhotonCount, Radius, RouletteDepth, Subpaths, Switch, Weights,
};
use super::parameters::{ParameterSet, parameter, parameters, read_method};
use super::shared_parameters::{
    CAMERA_HITS, HEURISTIC, LENGTH, LIGHT_HITS, LIGHT_SUBPATHS, MAX_DEPTH, MERGING_RADIUS, OCCLUSION, PASSES, SHOW,
    STRATEGY, SUBPATH_EMISSION, SUBPATH_RR_DEPTH, WEIGHTS,
};
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, Strategy};
use crate::scene::Scene;
use crate::transport::bidirectional::{Heuristic, Show};
use crate::transport::kernel::Kernel;
use crate::transport::occlusion::Occlusion;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "bdpm",
    also_called: &["bidirectional_photon_mapping"],
    summary: "bidirectional photon mapping: photons at every camera vertex, weighted in pairs",
    cannot_sample: "light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Vorba 2011",
    bias: Bias::Stays,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

bounded! {
    /// A number of nearest photons, 0 for all.
    struct Nearest(u32), [0, 2 to 65536]
}

parameters! {
    /// Parameters of `bdpm`.
    struct Parameters {
        photons_per_pass: Auto<PhotonCount> = LIGHT_SUBPATHS,
        initial_radius: Auto<Radius> = MERGING_RADIUS,
        occlusion: Occlusion = OCCLUSION,
        kernel: Kernel = parameter("how photons count by their distance", Kernel::Disc, "disc"),
        neighbors: Nearest = parameter(
            "only the nearest photons, within the radius; 0 for all",
            Nearest::new(0).expect("in range"),
            "0",
        ),
        weights: Weights = WEIGHTS,
        light_hits: Switch = LIGHT_HITS,
        camera_hits: Switch = CAMERA_HITS,
        heuristic: Heuristic = HEURISTIC,
        strategy: All<Subpaths> = STRATEGY,
        show: Show = SHOW,
        emission: Emission = SUBPATH_EMISSION,
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = SUBPATH_RR_DEPTH,
        length: All<PathLength> = LENGTH,
        passes: Passes = PASSES,
    }
}

impl Parameters {
    /// What passes do.
    fn settings(&self) -> PassSettings {
        let (techniques, measure) = (photon_techniques(self.light_hits, self.camera_hits), self.weights.measure());
        let Self { max_depth, rr_depth, length, strategy, show, .. } = *self;
        let paths = Paths { max_depth, rr_depth, length, strategy, show };
        let (first_radius, kernel, neighbors) = (self.initial_radius.meters(), self.kernel, self.neighbors.get());
        let merging = MergeSettings { first_radius, kernel, neighbors, occlusion: self.occlusion };
        PassSettings {
            heuristic: self.heuristic,
            measure,
            merging,
            emission: self.emission,
            ..PassSettings::new(techniques, &paths)
        }
    }
}

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        self.photons_per_pass.settle(pixels)
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        Gathering::FixedDiscs
    }

    fn strategies(&self, longest: u32) -> Option<Vec<Strategy>> {
        Some(self.settings().strategies(longest))
    }

    fn may_guide_photons(&self) -> bool {
        self.emission != Emission::Power
    }

    fn contradiction(&self) -> Option<Contradiction> {
        self.settings().contradiction()
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        self.settings().prepare(scene, photons_per_pass, seed)
    }
}
