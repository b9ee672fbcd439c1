//! `bdpt`: bidirectional path tracing. Every pass traces a light and a camera subpath per pixel and joins each vertex of one with
//! each of the other; camera subpaths also hit lights and sample them, light subpaths also are seen by the camera. All ways
//! of finding a path share it by multiple importance sampling. Every pass is unbiased.
//!
//! References: Lafortune & Willems 1993, "Bi-directional path tracing"; [V97] Veach 1997, chapter 10; [G12] Georgiev 2012,
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

use super::bidirectional_parameters::{
    BidirectionalParameters, HEURISTIC, LENGTH, MAX_DEPTH, PASSES, RR_DEPTH, SHOW, STRATEGY,
};
use super::bidirectional_pass::Recipe;
use super::{Bias, CheckedMethod, MethodEntry, ParameterHelp, SceneTraits};
use crate::transport::bidirectional::Techniques;

const PARAMETERS: &[ParameterHelp] = &[HEURISTIC, STRATEGY, SHOW, MAX_DEPTH, RR_DEPTH, LENGTH, PASSES];

const RECIPE: Recipe = Recipe { name: "bdpt", parameters: PARAMETERS, techniques };

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: RECIPE.name,
    summary: "bidirectional path tracing: every light and camera vertex connected",
    cannot_sample: "light of point, spot and directional lights through glass onto what glass or mirrors show",
    reference: "Lafortune & Willems 1993; Veach 1997, chapter 10",
    bias: Bias::None,
    parameters: RECIPE.parameters,
    negative_lobes: true,
    media: false,
    strategies: Some(|choice, longest| RECIPE.strategies(choice, longest)),
    blind_to,
    check: |choice, pixels| RECIPE.check(choice, pixels),
    declare: |method| RECIPE.declare(method),
    prepare: |scene, method, seed| RECIPE.prepare(scene, method, seed),
};

fn techniques(_parameters: &BidirectionalParameters) -> Techniques {
    Techniques::ALL_CONNECTIONS
}

fn blind_to(_: &CheckedMethod, traits: SceneTraits) -> Option<&'static str> {
    (traits.point_lights && traits.specular)
        .then_some("light that mirrors and glass throw from point, spot and directional lights, where it is seen in mirrors or through \
                    glass; sppm and vcm do")
}
