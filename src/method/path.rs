//! `path`: path tracing. One camera path per pixel and pass goes on by the materials' own sampling until roulette ends it. At
//! every surface a point of a light is sampled too, and lights that the path hits by chance count as well; each way can be
//! switched off, and both together share light by multiple importance sampling. Every pass is unbiased.
//!
//! References: Kajiya 1986, "The rendering equation"; [V97] Veach 1997, "Robust Monte Carlo methods for light transport
//! simulation", chapter 9; [Vo11] Vorba 2011, "Bidirectional photon mapping", eqs. 1.9–1.11.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | T | `Vertex::throughput` of [Vo11, eq. 1.11] | – |
//! | w | `Weighting::direct` and `Weighting::hit`, the heuristics of [V97, 9.2.2] | – |
//!
//! Limits: light that only mirrors or glass send to a surface is found when paths hit the lamp by chance: noisy from small lamps,
//! never from point lights.

use super::bidirectional_parameters::{BidirectionalParameters, HEURISTIC, LENGTH, MAX_DEPTH, PASSES, RR_DEPTH};
use super::bidirectional_pass::Recipe;
use super::parameters::help;
use super::{Bias, CheckedMethod, MethodEntry, ParameterHelp, SceneTraits};
use crate::transport::bidirectional::Techniques;

const PARAMETERS: &[ParameterHelp] = &[
    help("light_sampling", "whether points of lights are sampled at every surface", "on, off", "on"),
    help("material_sampling", "whether lights that the path hits by chance count", "on, off", "on"),
    HEURISTIC,
    MAX_DEPTH,
    RR_DEPTH,
    LENGTH,
    PASSES,
];

const RECIPE: Recipe = Recipe { name: "path", parameters: PARAMETERS, techniques };

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: RECIPE.name,
    summary: "path tracing: light and material sampling combined",
    cannot_sample: "caustics of point, spot and directional lights; small lamps behind glass are very noisy",
    reference: "Kajiya 1986; Veach 1997, chapter 9",
    bias: Bias::None,
    parameters: RECIPE.parameters,
    negative_lobes: true,
    media: true,
    strategies: None,
    blind_to,
    check: |choice, pixels| RECIPE.check(choice, pixels),
    declare: |method| RECIPE.declare(method),
    prepare: |scene, method, seed| RECIPE.prepare(scene, method, seed),
};

fn techniques(parameters: &BidirectionalParameters) -> Techniques {
    Techniques::HIT
        .with(Techniques::HIT, parameters.material_sampling.is_on())
        .with(Techniques::DIRECT, parameters.light_sampling.is_on())
}

fn blind_to(method: &CheckedMethod, traits: SceneTraits) -> Option<&'static str> {
    let samples_lights = method.choice.parameters.get("light_sampling").is_none_or(|value| value == "on");
    match (traits.point_lights, traits.specular) {
        (true, _) if !samples_lights => Some("point, spot and directional lights without light_sampling"),
        (true, true) => {
            Some("light that mirrors and glass throw from point, spot and directional lights; sppm, vcm and bdpt do")
        }
        _ => None,
    }
}
