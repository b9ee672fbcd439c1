//! Which photons may meet a mirror or glass first: those whose rays meet a box around some of it.
//!
//! A projection map [Jensen & Christensen 1995] marks the cells of directions in which a light sees specular surfaces, and photons for
//! caustics start in marked cells alone. Here every ray is projected by itself, as if cells were infinitely small: lights of all kinds take
//! part, area lights and light from outside too, and no cell can miss a surface at its rim. Drawing where photons start is not saved.

use crate::math::Vec3;
use crate::scene::Scene;
use crate::scene::light::EmittedPhoton;
use crate::scene::material::Lobes;

/// So many boxes at most: testing them all must cost less than a ray.
const MOST_BOXES: usize = 32;
/// Boxes are wider than what they hold by this share of the scene's radius, for rounding.
const ROOM: f32 = 1e-4;
/// Stands for smaller components of directions, whose inverse would be infinite.
const SMALLEST_COMPONENT: f32 = 1e-20;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
struct Box3 {
    low: Vec3,
    high: Vec3,
}

/// Boxes around all surfaces with a specular lobe.
#[derive(Clone, Debug)]
pub(crate) struct SpecularBoxes(Vec<Box3>);

impl SpecularBoxes {
    /// Those of a scene.
    pub(crate) fn new(scene: &Scene) -> Self {
        let is_specular = |shape| scene.lobes_at(shape).any(Lobes::SPECULAR);
        let all = scene.geometry.boxes_of(&is_specular);
        let room = ROOM * scene.geometry.bounding_sphere().1;
        let around = |run: &[(Vec3, Vec3)]| {
            let low = run.iter().map(|(low, _)| *low).reduce(Vec3::min)?;
            let high = run.iter().map(|(_, high)| *high).reduce(Vec3::max)?;
            Some(Box3 { low: low - room, high: high + room })
        };
        let in_one = all.len().div_ceil(MOST_BOXES).max(1);
        Self(all.chunks(in_one).filter_map(around).collect())
    }

    /// Whether a photon may meet a specular surface first; false only where it does not.
    #[inline]
    pub(crate) fn may_be_met(&self, photon: &EmittedPhoton) -> bool {
        let inverse = photon.direction.to_array().map(|component| match component.abs() < SMALLEST_COMPONENT {
            true => 1.0 / SMALLEST_COMPONENT.copysign(component),
            false => 1.0 / component,
        });
        let inverse = Vec3::from_array(inverse);
        self.0.iter().any(|each| {
            let (a, b) = ((each.low - photon.origin) * inverse, (each.high - photon.origin) * inverse);
            let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
            far >= near.max(0.0)
        })
    }
}
