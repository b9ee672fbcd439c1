//! Maps from the unit square to discs, spheres and cones, with their densities.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};

use super::trigonometry::sin_cos_turn;

/// Uniform on the unit disc; density 1/π.
#[inline]
pub fn disc(u: [f32; 2]) -> Vec2 {
    let radius = u[0].sqrt();
    let (sin, cos) = sin_cos_turn(u[1]);
    Vec2::new(radius * cos, radius * sin)
}

/// Cosine-weighted on the hemisphere around +z; density `cos θ/π` by solid angle.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let point = disc(u);
    Vec3::new(point.x, point.y, (1.0 - u[0]).max(0.0).sqrt())
}

/// The density of [`cosine_hemisphere`] by solid angle, 0 below the horizon.
#[inline]
pub fn cosine_hemisphere_pdf(cosine: f32) -> f32 {
    cosine.max(0.0) * FRAC_1_PI
}

/// Uniform on the unit sphere; density [`SPHERE_PDF`].
#[inline]
pub fn sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turn(u[1]);
    Vec3::new(radius * cos, radius * sin, z)
}

/// 1/(4π).
pub const SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Uniform in the cone around +z given by `one_minus_cosine` of its half angle (that form keeps narrow cones exact).
#[inline]
pub fn cone(one_minus_cosine: f32, u: [f32; 2]) -> Vec3 {
    let below = u[0] * one_minus_cosine;
    let radius = (below * (2.0 - below)).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turn(u[1]);
    Vec3::new(radius * cos, radius * sin, 1.0 - below)
}

/// The density of [`cone`] by solid angle inside it.
#[inline]
pub fn cone_pdf(one_minus_cosine: f32) -> f32 {
    1.0 / (2.0 * PI * one_minus_cosine)
}

/// Barycentric coordinates (of the second and third vertex) uniform on a triangle.
#[inline]
pub fn triangle(u: [f32; 2]) -> Vec2 {
    let root = u[0].sqrt();
    Vec2::new(root * (1.0 - u[1]), root * u[1])
}
