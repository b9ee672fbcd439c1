//! Phase functions: where media scatter light to.
//!
//! Reference: [PH] Pharr, Jakob & Humphreys 2016, "Physically based rendering", chapters 11 and 15.

use std::f32::consts::FRAC_1_PI;

use crate::math::{Frame, Vec3, warp};
use crate::scene::description::Node;
use crate::scene::error::{SceneError, nearest_name, shown_number};
use crate::scene::fields::Fields;

/// A distribution of scattered directions; cosines are those between the directions in which light comes and goes.
#[derive(Clone, Copy, Debug)]
pub enum Phase {
    /// The same everywhere.
    Isotropic,
    /// Henyey and Greenstein's, with the mean cosine.
    HenyeyGreenstein(f32),
    /// That of particles much smaller than the wavelength.
    Rayleigh,
}

/// Reads a phase function.
///
/// # Errors
/// Unknown ones, and parameters out of range.
pub(super) fn read(node: &Node) -> Result<Phase, SceneError> {
    let mut fields = Fields::new(node);
    let phase = match node.plugin.as_str() {
        "isotropic" => Phase::Isotropic,
        "rayleigh" => Phase::Rayleigh,
        "hg" => {
            let mean = fields.float("g")?.unwrap_or(0.8);
            if !(mean > -1.0 && mean < 1.0) {
                return Err(fields.error(
                    "g",
                    format!("\"g\" is {}", shown_number(mean)),
                    "give a number above -1 and below 1",
                ));
            }
            Phase::HenyeyGreenstein(mean as f32)
        }
        other => {
            let problem = format!("phase function \"{other}\" is not supported");
            let remedy = nearest_name(other, &["isotropic", "hg", "rayleigh"]);
            return Err(SceneError::new(&node.location, problem, remedy));
        }
    };
    fields.finish()?;
    Ok(phase)
}

impl Phase {
    /// The value, sr⁻¹, which is the density of [`Phase::sample`], for the unit directions in which light goes before and after.
    #[inline]
    pub fn value(self, before: Vec3, after: Vec3) -> f32 {
        let cosine = before.dot(after);
        match self {
            Self::Isotropic => warp::SPHERE_PDF,
            Self::HenyeyGreenstein(mean) => {
                let below = (1.0 + mean * mean - 2.0 * mean * cosine).max(f32::MIN_POSITIVE);
                warp::SPHERE_PDF * (1.0 - mean * mean) / (below * below.sqrt())
            }
            Self::Rayleigh => 3.0 / 16.0 * FRAC_1_PI * (1.0 + cosine * cosine),
        }
    }

    /// A direction after scattering, and its density by solid angle [PH, 15.2.3].
    #[inline]
    pub fn sample(self, before: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        let after = match self {
            Self::Isotropic => warp::sphere(u),
            Self::HenyeyGreenstein(mean) if mean.abs() < 1e-3 => warp::sphere(u),
            Self::HenyeyGreenstein(mean) => {
                let ratio = (1.0 - mean * mean) / (1.0 - mean + 2.0 * mean * u[0]);
                around(before, (1.0 + mean * mean - ratio * ratio) / (2.0 * mean), u[1])
            }
            Self::Rayleigh => {
                // The root of z³ + 3z = 8u - 4.
                let half = 4.0 * u[0] - 2.0;
                let root = libm::cbrtf(half + (1.0 + half * half).sqrt());
                around(before, root - 1.0 / root, u[1])
            }
        };
        (after, self.value(before, after))
    }
}

/// The direction at a cosine against `axis`.
fn around(axis: Vec3, cosine: f32, u: f32) -> Vec3 {
    let cosine = cosine.clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt();
    let (sin, cos) = crate::math::trigonometry::sin_cos_turn(u);
    Frame::from_normal(axis).to_world(Vec3::new(sine * cos, sine * sin, cosine)).normalize()
}
