//! What a job measures of itself.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How far a job's picture is from the truth, as its own passes tell it, without a reference. Errors are
/// relMSE = mean((L − truth)²/(Y² + 10⁻³·m²)), with Y the mean of the truth's channels in a pixel and m that of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EstimatedError {
    /// Passes merged when it was estimated.
    pub passes: u32,
    /// The estimate: noise and bias together.
    pub relmse: f64,
    /// Its part by noise.
    pub noise: f64,
    /// Its part by the bias of density estimates; 0 for methods without them, and not known for `photon_map`.
    pub bias: f64,
    /// relMSE is below this with the confidence beside it.
    pub bound: f64,
    /// Share of pictures whose bound holds.
    pub confidence: f64,
}

/// How often the Markov chains of a job accepted proposals of one kind.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Acceptance {
    /// The kind, for example `small_step`.
    pub proposal: String,
    /// Proposals made in merged passes.
    pub proposed: u64,
    /// Those of them that were accepted.
    pub accepted: u64,
}
