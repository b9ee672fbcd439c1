//! Weights that combine several ways of sampling one path.

/// The power heuristic with exponent 2 for a sample with density `pdf` where another way of sampling has density `other`
/// [Veach 1997, eq. 9.13].
#[inline]
pub(crate) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
