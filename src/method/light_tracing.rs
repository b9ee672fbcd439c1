//! `light_tracing`: light subpaths whose every vertex is connected with the camera; nothing else but lamps that the camera sees
//! directly. It finds caustics on matte surfaces better than any other unbiased method.
//!
//! References: Arvo 1986, "Backward ray tracing"; [V97] Veach 1997, 10.3 (the techniques with one camera vertex).
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | α | `Vertex::throughput` | W |
//! | We | `Camera::pdf_solid_angle` times the pixels of the film | sr⁻¹ |
//!
//! Limits: whatever the camera sees in mirrors or through glass stays black.

use super::bidirectional_parameters::{BidirectionalParameters, LENGTH, MAX_DEPTH, PASSES, RR_DEPTH};
use super::bidirectional_pass::Recipe;
use super::{Bias, CheckedMethod, MethodEntry, ParameterHelp, SceneTraits};
use crate::transport::bidirectional::Techniques;

const PARAMETERS: &[ParameterHelp] = &[MAX_DEPTH, RR_DEPTH, LENGTH, PASSES];

const RECIPE: Recipe = Recipe { name: "light_tracing", parameters: PARAMETERS, techniques };

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: RECIPE.name,
    summary: "light subpaths connected with the camera, for what only they can sample",
    cannot_sample: "anything that the camera sees in mirrors or through glass",
    reference: "Arvo 1986; Veach 1997, chapter 10",
    bias: Bias::None,
    parameters: RECIPE.parameters,
    negative_lobes: true,
    media: false,
    strategies: None,
    blind_to,
    check: |choice, pixels| RECIPE.check(choice, pixels),
    declare: |method| RECIPE.declare(method),
    prepare: |scene, method, seed| RECIPE.prepare(scene, method, seed),
};

fn techniques(_parameters: &BidirectionalParameters) -> Techniques {
    Techniques::CAMERA
}

fn blind_to(_: &CheckedMethod, traits: SceneTraits) -> Option<&'static str> {
    traits.specular.then_some("what is seen in mirrors or through glass, which stays black; sppm, vcm and bdpt do")
}
