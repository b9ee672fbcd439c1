//! Triangles that rays meet from their outside only: the walls of tubes that are open at their ends.

use glam::{Vec2, Vec3};

use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint};
use super::triangle::Triangle;

/// A triangle whose back lets every ray through.
#[derive(Clone, Copy, Debug)]
pub struct OneSidedTriangle(pub Triangle);

impl OneSidedTriangle {
    /// Nearest hit from outside before `length`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, shear: &Shear, length: f32) -> Option<PrimitiveHit> {
        self.0.intersect_sides::<false>(ray, shear, length)
    }

    /// As of a [`Triangle`].
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        self.0.surface(ray, hit)
    }

    /// As of a [`Triangle`].
    pub fn uv(&self, position: Vec3, barycentric: [f32; 2]) -> Vec2 {
        self.0.uv(position, barycentric)
    }

    /// As of a [`Triangle`], m.
    pub fn partials(&self, position: Vec3) -> [Vec3; 2] {
        self.0.partials(position)
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        self.0.area()
    }

    /// Smallest and largest coordinates, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.0.bounds()
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        self.0.sample(u)
    }
}
