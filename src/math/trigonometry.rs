//! Sine and cosine whose bits do not depend on the system's library.

use std::f32::consts::PI;

/// `(sin φ, cos φ)` for `φ = π/4·x` with |x| ≤ 1: Taylor polynomials, error below 2⁻²³.
#[inline]
fn sin_cos_octant(x: f32) -> (f32, f32) {
    let phi = x * (PI / 4.0);
    let square = phi * phi;
    let sin =
        phi * (1.0 + square * (-1.0 / 6.0 + square * (1.0 / 120.0 + square * (-1.0 / 5040.0 + square / 362_880.0))));
    let cos = 1.0 + square * (-0.5 + square * (1.0 / 24.0 + square * (-1.0 / 720.0 + square / 40_320.0)));
    (sin, cos)
}

/// `(sin 2πu, cos 2πu)` for `u` in [0, 1].
#[inline]
pub(crate) fn sin_cos_turn(u: f32) -> (f32, f32) {
    let eighths = u * 8.0;
    // The nearest multiple of a quarter turn, so that the rest is within an octant on either side.
    let quarter = ((eighths + 1.0) * 0.5) as u32;
    let (sin, cos) = sin_cos_octant(eighths - 2.0 * quarter as f32);
    match quarter % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::sin_cos_turn;

    #[test]
    fn agreement_with_double_precision() {
        for step in 0..=100_000u32 {
            let u = step as f32 / 100_000.0;
            let angle = f64::from(u) * std::f64::consts::TAU;
            let (sin, cos) = sin_cos_turn(u);
            assert!((f64::from(sin) - libm::sin(angle)).abs() < 3e-7, "sine at {u}");
            assert!((f64::from(cos) - libm::cos(angle)).abs() < 3e-7, "cosine at {u}");
        }
    }
}
