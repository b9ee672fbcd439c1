//! Comparisons that become one vector instruction in loops over lanes. `f32::min` and `f32::max` mind NaN, which takes several.

/// The smaller of two numbers; `b` where they cannot be compared.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers; `b` where they cannot be compared.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
