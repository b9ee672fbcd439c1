//! `pbdpm`: progressive bidirectional photon mapping: `bdpm` with new photons and camera paths every pass and a radius that shrinks. All
//! vertices of a pixel's path share its statistics.
//!
//! References: [Vo11] Vorba 2011, "Bidirectional photon mapping", chapter 3; [G+12] Georgiev, Křivánek, Davidovič & Slusallek 2012,
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

use super::bidirectional_parameters::{
    ALPHA, BidirectionalParameters, CAMERA_HITS, HEURISTIC, INITIAL_RADIUS, LENGTH, LIGHT_HITS, MAX_DEPTH, PASSES,
    PHOTONS, RADIUS_RULE, RR_DEPTH, SHOW, STRATEGY, WEIGHTS,
};
use super::bidirectional_pass::Recipe;
use super::{Bias, MethodEntry, ParameterHelp, blind_to_nothing};

const PARAMETERS: &[ParameterHelp] = &[
    ALPHA,
    RADIUS_RULE,
    PHOTONS,
    INITIAL_RADIUS,
    WEIGHTS,
    LIGHT_HITS,
    CAMERA_HITS,
    HEURISTIC,
    STRATEGY,
    SHOW,
    MAX_DEPTH,
    RR_DEPTH,
    LENGTH,
    PASSES,
];

const RECIPE: Recipe =
    Recipe { name: "pbdpm", parameters: PARAMETERS, techniques: BidirectionalParameters::photon_techniques };

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: RECIPE.name,
    summary: "progressive bidirectional photon mapping: bdpm with a shrinking radius",
    cannot_sample: "light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Vorba 2011, section 3.4",
    bias: Bias::Shrinks,
    parameters: RECIPE.parameters,
    negative_lobes: true,
    media: false,
    strategies: Some(|choice, longest| RECIPE.strategies(choice, longest)),
    blind_to: blind_to_nothing,
    check: |choice, pixels| RECIPE.check(choice, pixels),
    declare: |method| RECIPE.declare(method),
    prepare: |scene, method, seed| RECIPE.prepare(scene, method, seed),
};
