//! Where light from outside starts: on the box around the scene, so that all of it may meet something.
//!
//! Light that travels along d crosses the box through one of the at most three faces that d enters. Seen along d they have
//! the areas |dᵢ|·Aᵢ and do not overlap. So a face picked by that area and a point uniform on it are uniform over the box's
//! silhouette, with the density 1/Σ|dᵢ|·Aᵢ by area across d.

use super::{EmittedPhoton, Origin};
use crate::math::discrete::ONE_MINUS_EPSILON;
use crate::math::{Frame, Rgb, Vec3, warp};

/// The box around the scene; distant lights emit from it.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    low: Vec3,
    size: Vec3,
    /// Areas of the faces across x, y and z, m².
    faces: Vec3,
}

impl Surroundings {
    /// From the scene's smallest and largest coordinates, m. A margin keeps rounded photons from missing what lies on the
    /// border, and gives a flat scene a silhouette from the side.
    pub fn new((low, high): (Vec3, Vec3)) -> Self {
        let margin = 1e-6 * low.abs().max(high.abs()).max_element();
        let (low, size) = (low - margin, high - low + 2.0 * margin);
        Self { low, size, faces: Vec3::new(size.y * size.z, size.z * size.x, size.x * size.y) }
    }

    /// Area of the box as seen along the unit vector `direction`, m².
    #[inline]
    pub fn silhouette(&self, direction: Vec3) -> f32 {
        direction.abs().dot(self.faces)
    }

    /// Area of the box's surface, m²: four times its mean silhouette \[Cauchy\].
    pub fn surface(&self) -> f32 {
        2.0 * self.faces.element_sum()
    }

    /// A photon along `direction` from a place uniform over the silhouette. `flux` is per area, W·m⁻²; `pdf` is the density of
    /// the direction.
    #[inline]
    pub(super) fn photon(&self, direction: Vec3, place: [f32; 2], flux: Rgb, pdf: f32) -> EmittedPhoton {
        let (axis, along) = pick(direction.abs() * self.faces, place[0]);
        let area = self.silhouette(direction);
        let origin = self.face_point(axis, direction[axis] < 0.0, [along, place[1]]);
        self.leaving(origin, direction, flux * area, pdf / area, area)
    }

    /// A photon of the same radiance from everywhere, which meets the box uniformly: in proportion to area and cosine.
    /// `flux` is all that enters the box, W.
    #[inline]
    pub(super) fn uniform_photon(&self, place: [f32; 2], direction: [f32; 2], flux: Rgb) -> EmittedPhoton {
        let (axis, along) = pick(self.faces, place[0]);
        let (is_high, along) = (along >= 0.5, (2.0 * along).fract());
        let inward = Vec3::AXES[axis] * if is_high { -1.0 } else { 1.0 };
        let direction = Frame::from_normal(inward).to_world(warp::cosine_hemisphere(direction));
        let origin = self.face_point(axis, is_high, [along, place[1]]);
        let pdf = std::f32::consts::FRAC_1_PI / self.surface();
        self.leaving(origin, direction, flux, pdf, warp::SPHERE_PDF / pdf)
    }

    fn leaving(&self, face: Vec3, direction: Vec3, flux: Rgb, pdf: f32, sampling_ratio: f32) -> EmittedPhoton {
        // Not from the face itself, which surfaces may touch.
        let origin = face - direction * self.size.length();
        EmittedPhoton { origin, direction, flux, pdf, origin_kind: Origin::Distant { sampling_ratio }, light: 0 }
    }

    fn face_point(&self, axis: usize, is_high: bool, u: [f32; 2]) -> Vec3 {
        let mut share = Vec3::ZERO;
        share[axis] = f32::from(u8::from(is_high));
        share[(axis + 1) % 3] = u[0];
        share[(axis + 2) % 3] = u[1];
        self.low + self.size * share
    }
}

/// Picks an axis by `shares` ≥ 0 with `u` in [0, 1) and gives back `u` rescaled to [0, 1).
#[inline]
fn pick(shares: Vec3, u: f32) -> (usize, f32) {
    let mut at = u * shares.element_sum();
    let mut axis = 0;
    while axis < 2 && at >= shares[axis] {
        at -= shares[axis];
        axis += 1;
    }
    (axis, (at / shares[axis]).min(ONE_MINUS_EPSILON))
}
