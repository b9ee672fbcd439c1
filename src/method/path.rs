//! `path`: path tracing. One camera path per pixel and pass goes on by the materials' own sampling until roulette ends it. At
//! every surface a point of a light is sampled too, and lights that the path hits by chance count as well; each way can be
//! switched off, and both together share light by multiple importance sampling. Every pass is unbiased.
//!
//! References: Kajiya 1986, "The rendering equation"; \[V97\] Veach 1997, "Robust Monte Carlo methods for light transport
//! simulation", chapter 9; \[Vo11\] Vorba 2011, "Bidirectional photon mapping", eqs. 1.9–1.11.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | T | `Vertex::throughput` of [Vo11, eq. 1.11] | – |
//! | w | `Weighting::direct` and `Weighting::hit`, the heuristics of [V97, 9.2.2] | – |
//!
//! Limits: light that only mirrors or glass send to a surface is found when paths hit the lamp by chance: noisy from small lamps,
//! never from point lights.

use std::sync::Arc;

use super::bidirectional_settings::{PassSettings, Paths};
use super::parameter_values::{All, Depth, LightPicks, Passes, PathLength, RouletteDepth, Switch, one_per_pixel};
use super::parameters::{ParameterSet, parameter, parameters, read_method};
use super::shared_parameters::{HEURISTIC, LENGTH, LIGHT_PICKS, MAX_DEPTH, PASSES, SUBPATH_RR_DEPTH};
use super::visibility_pilot::LightSampling;
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, SceneTraits};
use crate::scene::Scene;
use crate::transport::bidirectional::{Heuristic, Show, Techniques};

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "path",
    also_called: &["pt", "pathtracer", "path_tracing", "pathtracing", "unidirectional"],
    summary: "path tracing: light and material sampling combined",
    cannot_sample: "caustics of point, spot and directional lights; small lamps behind glass are very noisy",
    reference: "Kajiya 1986; Veach 1997, chapter 9",
    bias: Bias::None,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: true,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `path`.
    struct Parameters {
        light_sampling: Switch =
            parameter("whether points of lights are sampled at every surface", Switch::On, "on"),
        material_sampling: Switch =
            parameter("whether lights that the path hits by chance count", Switch::On, "on"),
        heuristic: Heuristic = HEURISTIC,
        light_picks: LightPicks = LIGHT_PICKS,
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = SUBPATH_RR_DEPTH,
        length: All<PathLength> = LENGTH,
        passes: Passes = PASSES,
    }
}

impl Parameters {
    /// What passes do.
    fn settings(&self) -> PassSettings {
        let techniques = Techniques::HIT
            .with(Techniques::HIT, self.material_sampling.is_on())
            .with(Techniques::DIRECT, self.light_sampling.is_on());
        let Self { max_depth, rr_depth, length, .. } = *self;
        let paths = Paths { max_depth, rr_depth, length, strategy: All::All, show: Show::Radiance };
        PassSettings { heuristic: self.heuristic, ..PassSettings::new(techniques, &paths) }
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
        match (traits.point_lights, traits.specular) {
            (true, _) if !self.light_sampling.is_on() => {
                Some("point, spot and directional lights without light_sampling")
            }
            (true, true) => Some(
                "light that mirrors and glass throw from point, spot and directional lights; sppm, vcm and bdpt do",
            ),
            _ => None,
        }
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        self.light_sampling.is_on().then(|| self.settings().light_sampling(self.light_picks))
    }

    fn contradiction(&self) -> Option<Contradiction> {
        self.settings().contradiction()
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        self.settings().prepare(scene, photons_per_pass, seed)
    }
}
