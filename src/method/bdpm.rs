//! `bdpm`: bidirectional photon mapping. The photon map is queried at every vertex of a camera path, with a radius that stays,
//! and each pair of photon and path is weighted against the other vertices where the same path could have been joined. So
//! glossy surfaces are followed and matte ones gathered at without any rule that says which is which.
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
//! `weights: paper` are those of [Vo11], products of directional densities, which do not see that merging needs a photon nearby;
//! `weights: consistent` count that as a factor π r² n in the density.
//!
//! Limits: the radius stays, so a bias stays: `pbdpm` shrinks it.

use super::bidirectional_parameters::{
    BidirectionalParameters, CAMERA_HITS, HEURISTIC, INITIAL_RADIUS, LENGTH, LIGHT_HITS, MAX_DEPTH, PASSES, PHOTONS,
    RR_DEPTH, SHOW, STRATEGY, WEIGHTS,
};
use super::bidirectional_pass::Recipe;
use super::parameters::help;
use super::{Bias, MethodEntry, ParameterHelp, blind_to_nothing};

const PARAMETERS: &[ParameterHelp] = &[
    PHOTONS,
    INITIAL_RADIUS,
    help("kernel", "how photons count by their distance", "disc, cone, epanechnikov", "disc"),
    help("neighbors", "only the nearest photons, within the radius; 0 for all", "0, 2 to 65536", "0"),
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
    Recipe { name: "bdpm", parameters: PARAMETERS, techniques: BidirectionalParameters::photon_techniques };

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: RECIPE.name,
    summary: "bidirectional photon mapping: photons at every camera vertex, weighted in pairs",
    cannot_sample: "light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Vorba 2011",
    bias: Bias::Stays,
    parameters: RECIPE.parameters,
    negative_lobes: true,
    media: false,
    strategies: Some(|choice, longest| RECIPE.strategies(choice, longest)),
    blind_to: blind_to_nothing,
    check: |choice, pixels| RECIPE.check(choice, pixels),
    declare: |method| RECIPE.declare(method),
    prepare: |scene, method, seed| RECIPE.prepare(scene, method, seed),
};
