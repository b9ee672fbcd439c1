//! `pbdpm`: progressive bidirectional photon mapping: `bdpm` with new photons and camera paths every pass and a radius that shrinks. All
//! vertices of a pixel's path share its statistics.
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
//! `weights: paper` and `consistent` are those of `bdpm`.
//!
//! Limits: direct light comes from photons too, so it is blurred at first.

use std::sync::Arc;

use super::bidirectional_settings::{MergeSettings, PassSettings, Paths, photon_techniques};
use super::parameter_values::{
    All, Auto, Depth, Emission, MergingRadiusRule, OpenUnit, Passes, PathLength, PhotonCount, Radius, RouletteDepth,
    Subpaths, Switch, Weights,
};
use super::parameters::{ParameterSet, parameters, read_method};
use super::shared_parameters::{
    ALPHA, CAMERA_HITS, HEURISTIC, LENGTH, LIGHT_HITS, LIGHT_SUBPATHS, MAX_DEPTH, MERGING_RADIUS, MERGING_RADIUS_RULE,
    OCCLUSION, PASSES, SHOW, STRATEGY, SUBPATH_EMISSION, SUBPATH_RR_DEPTH, WEIGHTS,
};
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, Strategy};
use crate::scene::Scene;
use crate::transport::bidirectional::{Heuristic, Show};
use crate::transport::occlusion::Occlusion;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "pbdpm",
    also_called: &[],
    summary: "progressive bidirectional photon mapping: bdpm with a shrinking radius",
    cannot_sample: "light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Vorba 2011, section 3.4",
    bias: Bias::Shrinks,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `pbdpm`.
    struct Parameters {
        alpha: OpenUnit = ALPHA,
        radius_rule: MergingRadiusRule = MERGING_RADIUS_RULE,
        photons_per_pass: Auto<PhotonCount> = LIGHT_SUBPATHS,
        initial_radius: Auto<Radius> = MERGING_RADIUS,
        occlusion: Occlusion = OCCLUSION,
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
        let merging = MergeSettings::discs(self.initial_radius.meters(), self.occlusion);
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
        Gathering::ShrinkingDiscs { rule: self.radius_rule.into(), alpha: self.alpha.get() }
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
