//! `vcm`: vertex connection and merging. Everything that `bdpt` and `pbdpm` do, with weights that know all of it. With `merge: off` it
//! is `bdpt`, with `connect: off` it is `pbdpm` without photons that the camera sees.
//!
//! References: [G+12] Georgiev, Křivánek, Davidovič & Slusallek 2012, "Light transport simulation with vertex connection and
//! merging"; [G12] Georgiev 2012, "Implementing vertex connection and merging".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | s, t | vertices of the light and of the camera subpath | – |
//! | η | `Weighting::acceptance`, π r² n | – |
//! | d | `Sums` [G12, eqs. 31–36] | – |
//!
//! Limits: it does the work of both methods in every pass, which pays where neither alone finds all light well.

use super::bidirectional_parameters::{
    ALPHA, BidirectionalParameters, HEURISTIC, INITIAL_RADIUS, LENGTH, MAX_DEPTH, PASSES, PHOTONS, RADIUS_RULE,
    RR_DEPTH, SHOW, STRATEGY,
};
use super::bidirectional_pass::Recipe;
use super::parameters::help;
use super::{Bias, CheckedMethod, MethodEntry, ParameterHelp, SceneTraits};
use crate::transport::bidirectional::Techniques;

const PARAMETERS: &[ParameterHelp] = &[
    help("connect", "whether vertices are connected", "on, off", "on"),
    help("merge", "whether vertices are merged", "on, off", "on"),
    ALPHA,
    RADIUS_RULE,
    PHOTONS,
    INITIAL_RADIUS,
    HEURISTIC,
    STRATEGY,
    SHOW,
    MAX_DEPTH,
    RR_DEPTH,
    LENGTH,
    PASSES,
];

const RECIPE: Recipe = Recipe { name: "vcm", parameters: PARAMETERS, techniques };

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: RECIPE.name,
    summary: "vertex connection and merging: bdpt and pbdpm in one",
    cannot_sample: "nothing but light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Georgiev et al. 2012",
    bias: Bias::TakenOver,
    parameters: RECIPE.parameters,
    negative_lobes: true,
    media: false,
    strategies: Some(|choice, longest| RECIPE.strategies(choice, longest)),
    blind_to,
    check: |choice, pixels| RECIPE.check(choice, pixels),
    declare: |method| RECIPE.declare(method),
    prepare: |scene, method, seed| RECIPE.prepare(scene, method, seed),
};

fn techniques(parameters: &BidirectionalParameters) -> Techniques {
    match parameters.connect.is_on() {
        true => Techniques::ALL_CONNECTIONS,
        false => Techniques::HIT,
    }
    .with(Techniques::MERGE, parameters.merge.is_on())
}

fn blind_to(method: &CheckedMethod, traits: SceneTraits) -> Option<&'static str> {
    let merges = method.choice.parameters.get("merge").is_none_or(|value| value == "on");
    (!merges && traits.point_lights && traits.specular).then_some(
        "light that mirrors and glass throw from point, spot and directional lights, where it is seen in mirrors or through \
         glass; merge: on does",
    )
}
