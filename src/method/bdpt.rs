//! `bdpt`: bidirectional path tracing. Every pass traces a light and a camera subpath per pixel and joins each vertex of one with
//! each of the other; camera subpaths also hit lights and sample them, light subpaths also are seen by the camera. All ways
//! of finding a path share it by multiple importance sampling. Every pass is unbiased.
//!
//! References: Lafortune & Willems 1993, "Bi-directional path tracing"; \[V97\] Veach 1997, chapter 10; \[G12\] Georgiev 2012,
//! "Implementing vertex connection and merging", whose recursion computes the weights.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | s, t | vertices of the light and of the camera subpath [V97, 10.2] | – |
//! | α | `Vertex::throughput` | W; – |
//! | d | `Sums` [G12, eqs. 31–36] | – |
//!
//! Limits: paths on which a specular surface follows wherever they could be joined (a caustic seen in a mirror) are found only when
//! they hit a lamp by chance.

use std::sync::Arc;

use super::bidirectional_settings::{PassSettings, Paths, blind_without_merging};
use super::parameter_values::{
    All, Depth, Emission, LightPicks, Passes, PathLength, RouletteDepth, Subpaths, one_per_pixel,
};
use super::parameters::{ParameterSet, parameters, read_method};
use super::shared_parameters::{
    HEURISTIC, LENGTH, LIGHT_PICKS, MAX_DEPTH, PASSES, SHOW, STRATEGY, SUBPATH_EMISSION, SUBPATH_RR_DEPTH,
};
use super::visibility_pilot::LightSampling;
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, SceneTraits, Strategy};
use crate::scene::Scene;
use crate::transport::bidirectional::{Heuristic, Show, Techniques};

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "bdpt",
    also_called: &["bidir", "bidirectional", "bpt"],
    summary: "bidirectional path tracing: every light and camera vertex connected",
    cannot_sample: "light of point, spot and directional lights through glass onto what glass or mirrors show",
    reference: "Lafortune & Willems 1993; Veach 1997, chapter 10",
    bias: Bias::None,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `bdpt`.
    struct Parameters {
        heuristic: Heuristic = HEURISTIC,
        strategy: All<Subpaths> = STRATEGY,
        show: Show = SHOW,
        light_picks: LightPicks = LIGHT_PICKS,
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
        let Self { max_depth, rr_depth, length, strategy, show, .. } = *self;
        let paths = Paths { max_depth, rr_depth, length, strategy, show };
        PassSettings {
            heuristic: self.heuristic,
            emission: self.emission,
            ..PassSettings::new(Techniques::ALL_CONNECTIONS, &paths)
        }
    }
}

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        one_per_pixel(pixels)
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        Gathering::Nothing
    }

    fn blind_to(&self, traits: SceneTraits) -> Option<&'static str> {
        blind_without_merging(traits)
    }

    fn strategies(&self, longest: u32) -> Option<Vec<Strategy>> {
        Some(self.settings().strategies(longest))
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(self.settings().light_sampling(self.light_picks))
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
