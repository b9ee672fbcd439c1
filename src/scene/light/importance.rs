//! Light importance: an estimate of each light's unshadowed contribution at a place, by which a light is picked there.
//!
//! The importance of a light is its peak intensity over the square of the distance, W·m⁻², where the place lies in the light's cone
//! and the light over the place's horizon, times approximate cosines at both ends. Occlusion is ignored.

use crate::math::Vec3;
use crate::scene::geometry::Interaction;
use crate::scene::material::Lobes;

/// What the importance of a light is computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightImportance {
    /// Inside the scene.
    Near(Lamp),
    /// Outside: the same everywhere.
    Far {
        /// W·m⁻² on a surface that faces it.
        irradiance: f32,
    },
}

/// The bounds of a light in the scene: place, extent, intensity and direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The middle, m.
    pub center: Vec3,
    /// Everything that shines is so near to the middle, m.
    pub radius: f32,
    /// Radiant intensity where it is brightest, or thereabouts, W·sr⁻¹.
    pub intensity: f32,
    /// Where it shines to.
    pub aim: Aim,
}

/// Where a lamp shines to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// Anywhere.
    Everywhere,
    /// From a plane to one side, falling with the cosine against the unit vector.
    Side(Vec3),
    /// Along a unit vector, with at least this cosine against it.
    Cone(Vec3, f32),
}

/// A place that light may arrive at.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where, m.
    pub position: Vec3,
    /// Normal on the lit side; zero in the middle of nothing.
    pub(super) normal: Vec3,
    /// 1 where light may come from behind too, else 0.
    pub(super) both_sides: f32,
    /// The share of picks that goes by power alone.
    by_power: f32,
}

impl From<Vec3> for Place {
    /// In the middle of nothing: all directions count the same.
    fn from(position: Vec3) -> Self {
        Self { position, normal: Vec3::ZERO, both_sides: 1.0, by_power: 0.0 }
    }
}

impl Place {
    /// On a surface with some `lobes`, on the side of the path that came there.
    #[inline]
    pub fn on(hit: &Interaction, lobes: Lobes) -> Self {
        let normal = hit.geometric_normal;
        let facing = if hit.outgoing.dot(normal) < 0.0 { -normal } else { normal };
        let both_sides = f32::from(u8::from(lobes.any(Lobes::TRANSMISSIVE)));
        let by_power = if lobes.any(Lobes::NARROW) { BY_POWER_IN_GLOSS } else { BY_POWER };
        Self { position: hit.offset_towards(hit.outgoing), normal: facing, both_sides, by_power }
    }

    /// The share of picks that goes by power alone, 0 to below 1.
    #[inline]
    pub fn by_power(&self) -> f32 {
        self.by_power
    }
}

/// So many picks go by power, for places whose bright lamps are hidden by walls.
pub const BY_POWER: f32 = 0.1;
/// And so many where a surface is glossy: in a highlight the lamp that it shows is all that matters, however far it is.
const BY_POWER_IN_GLOSS: f32 = 0.5;

impl LightImportance {
    /// Intensity or irradiance.
    pub(super) fn brightness(&self) -> f32 {
        match self {
            Self::Near(lamp) => lamp.intensity,
            Self::Far { irradiance } => *irradiance,
        }
    }
}
