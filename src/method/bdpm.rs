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

use std::sync::Arc;

use super::bidirectional_parameters::{
    BidirectionalParameters, HEURISTIC, INITIAL_RADIUS, LENGTH, MAX_DEPTH, PASSES, PHOTONS, RR_DEPTH, SHOW, STRATEGY,
};
use super::bidirectional_pass::BidirectionalPasses;
use super::parameters::help;
use super::{CheckedMethod, MethodChoice, MethodEntry, MethodError, ParameterHelp, PreparedMethod, blind_to_nothing};
use crate::scene::Scene;
use crate::transport::bidirectional::Techniques;

const NAME: &str = "bdpm";
const PARAMETERS: &[ParameterHelp] = &[
    PHOTONS,
    INITIAL_RADIUS,
    help("kernel", "how photons count by their distance", "disc, cone, epanechnikov", "disc"),
    help("neighbors", "only the nearest photons, within the radius; 0 for all", "0, 2 to 65536", "0"),
    help("weights", "how pairs of photon and path are weighted", "consistent, paper", "consistent"),
    help("light_hits", "whether camera paths that hit lights count", "on, off", "on"),
    help("camera_hits", "whether photons are connected with the camera", "on, off", "on"),
    HEURISTIC,
    STRATEGY,
    SHOW,
    MAX_DEPTH,
    RR_DEPTH,
    LENGTH,
    PASSES,
];

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: NAME,
    summary: "bidirectional photon mapping: photons at every camera vertex, weighted in pairs",
    cannot_sample: "light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Vorba 2011",
    parameters: PARAMETERS,
    blind_to: blind_to_nothing,
    check,
    prepare,
};

fn techniques(parameters: &BidirectionalParameters) -> Techniques {
    Techniques::MERGE
        .with(Techniques::HIT, parameters.light_hits.is_on())
        .with(Techniques::CAMERA, parameters.camera_hits.is_on())
}

fn check(choice: &MethodChoice, pixels: u64) -> Result<CheckedMethod, MethodError> {
    let parameters = BidirectionalParameters::read(NAME, choice, PARAMETERS)?;
    let techniques = techniques(&parameters);
    Ok(parameters.checked(NAME, PARAMETERS, techniques, pixels))
}

fn prepare(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Box<dyn PreparedMethod>, MethodError> {
    let parameters = BidirectionalParameters::read(NAME, &method.choice, PARAMETERS)?;
    let techniques = techniques(&parameters);
    Ok(Box::new(BidirectionalPasses::new(scene, method, &parameters, techniques, seed)))
}
