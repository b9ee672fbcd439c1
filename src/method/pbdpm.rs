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

use std::sync::Arc;

use super::bidirectional_parameters::{
    ALPHA, BidirectionalParameters, HEURISTIC, INITIAL_RADIUS, LENGTH, MAX_DEPTH, PASSES, PHOTONS, RADIUS_RULE,
    RR_DEPTH, STRATEGY,
};
use super::bidirectional_pass::BidirectionalPasses;
use super::parameters::help;
use super::{CheckedMethod, MethodChoice, MethodEntry, MethodError, ParameterHelp, PreparedMethod, blind_to_nothing};
use crate::scene::Scene;
use crate::transport::bidirectional::Techniques;

const NAME: &str = "pbdpm";
const PARAMETERS: &[ParameterHelp] = &[
    ALPHA,
    RADIUS_RULE,
    PHOTONS,
    INITIAL_RADIUS,
    help("weights", "how pairs of photon and path are weighted", "consistent, paper", "consistent"),
    help("light_hits", "whether camera paths that hit lights count", "on, off", "on"),
    help("camera_hits", "whether photons are connected with the camera", "on, off", "on"),
    HEURISTIC,
    STRATEGY,
    MAX_DEPTH,
    RR_DEPTH,
    LENGTH,
    PASSES,
];

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: NAME,
    summary: "progressive bidirectional photon mapping: bdpm with a shrinking radius",
    cannot_sample: "light of point, spot and directional lights that only mirrors and glass reflect to the camera",
    reference: "Vorba 2011, section 3.4",
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
