//! `light_tracing`: light subpaths whose every vertex is connected with the camera; nothing else but lamps that the camera sees
//! directly. It finds caustics on matte surfaces better than any other unbiased method.
//!
//! References: Arvo 1986, "Backward ray tracing"; \[V97\] Veach 1997, 10.3 (the techniques with one camera vertex).
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | α | `Vertex::throughput` | W |
//! | We | `Camera::pdf_solid_angle` times the pixels of the film | sr⁻¹ |
//!
//! Limits: whatever the camera sees in mirrors or through glass stays black.

use std::sync::Arc;

use super::bidirectional_settings::{PassSettings, Paths};
use super::parameter_values::{All, Depth, Emission, Passes, PathLength, RouletteDepth, one_per_pixel};
use super::parameters::{ParameterSet, parameters, read_method};
use super::shared_parameters::{LENGTH, MAX_DEPTH, PASSES, SUBPATH_EMISSION, SUBPATH_RR_DEPTH};
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, SceneTraits};
use crate::scene::Scene;
use crate::transport::bidirectional::{Show, Techniques};

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "light_tracing",
    also_called: &["lt", "lighttracer", "light_tracer", "ptracer", "particle_tracing"],
    summary: "light subpaths connected with the camera, for what only they can sample",
    cannot_sample: "anything that the camera sees in mirrors or through glass",
    reference: "Arvo 1986; Veach 1997, chapter 10",
    bias: Bias::None,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `light_tracing`.
    struct Parameters {
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
        let Self { max_depth, rr_depth, length, .. } = *self;
        let paths = Paths { max_depth, rr_depth, length, strategy: All::All, show: Show::Radiance };
        PassSettings { emission: self.emission, ..PassSettings::new(Techniques::CAMERA, &paths) }
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
        traits.specular.then_some("what is seen in mirrors or through glass, which stays black; sppm, vcm and bdpt do")
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
