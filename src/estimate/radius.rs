//! Gather radii: the rules by which they shrink, and the field that travels to workers.

use serde::{Deserialize, Serialize};

/// How a pixel's gather radius shrinks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RadiusRule {
    /// From the photons each pixel found (Hachisuka, Ogaki & Jensen 2008). A radius field travels every epoch.
    #[default]
    Statistics,
    /// From the pass index alone (Knaus & Zwicker 2011, eq. 20). No radius field travels after the first.
    Schedule,
    /// As by statistics, where the flux that the pixel found is not even; elsewhere not at all [`evenness`](super::evenness).
    Uniformity,
}

impl RadiusRule {
    /// Whether what pixels find decides their radii, so that a radius field travels every epoch.
    pub fn follows_photons(self) -> bool {
        self != Self::Schedule
    }
}

/// `R²` after `passes` passes over `R²` before the first, for a pixel in a uniform photon density.
///
/// Statistics, with N = αM after the first pass: `α·Π_{j=1}^{passes-1} (j+α)/(j+1)`.
/// Schedule \[KZ11\]: `Π_{j=1}^{passes} (j+α)/(j+1)`, so pass index `i` (from 0) gathers with `shrinkage(i)`.
/// Uniformity: 1.
pub fn shrinkage(rule: RadiusRule, alpha: f64, passes: u32) -> f64 {
    let first = match rule {
        RadiusRule::Statistics => 0,
        RadiusRule::Schedule => 1,
        RadiusRule::Uniformity => return 1.0,
    };
    (first..first + passes).map(|j| (f64::from(j) + alpha) / (f64::from(j) + 1.0)).product()
}

/// The radii with which the passes of an epoch are traced.
///
/// Pass `i` gathers in pixel `p` with `radius_squared[p] · shrinkage(i)/shrinkage(base_pass)`: the shrinking that the rule
/// will most likely do in the meantime is foreseen, so that a field may be several epochs old. The merge corrects what
/// was foreseen wrongly.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiusField {
    /// Radius² per pixel of a region, row-major, m². Positive and finite; empty for methods that gather nothing.
    pub radius_squared: Vec<f32>,
    /// Passes that had been merged when the field was taken.
    pub base_pass: u32,
    /// Typical radius² of the **whole** picture, m²; sizes the photon map's cells identically for every region.
    pub typical_radius_squared: f32,
}

impl RadiusField {
    /// The field of methods that gather nothing.
    pub fn none() -> Self {
        Self { radius_squared: Vec::new(), base_pass: 0, typical_radius_squared: 1.0 }
    }

    /// `ρᵢ = R²ᵢ/R²` of pass `pass` relative to this field.
    pub fn scale_of_pass(&self, rule: RadiusRule, alpha: f64, pass: u32) -> f32 {
        (shrinkage(rule, alpha, pass) / shrinkage(rule, alpha, self.base_pass)) as f32
    }
}

/// The median of the radii² of a whole picture; 1 for an empty one.
pub fn typical_radius_squared(radius_squared: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = radius_squared.collect();
    if values.is_empty() {
        return 1.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
