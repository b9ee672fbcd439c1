//! `disk`: the unit disc in the xy plane, outside towards +z, then `to_world` (a similarity). `flip_normals` (boolean, false).

use glam::{DVec3, Vec3};

use super::Primitive;
use super::mesh::ShapeGeometry;
use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint, largest, position_error};
use super::transform::{ToWorld, to_single};
use crate::math::{Frame, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// A flat disc.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    center: Vec3,
    radius: f32,
    normal: Vec3,
}

/// Reads the shape.
pub fn read(fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let to_world = ToWorld::read(fields)?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let disk = Disk {
        center: to_single(to_world.point(DVec3::ZERO), fields)?,
        radius: to_single(DVec3::splat(to_world.uniform_scale(fields)?), fields)?.x,
        normal: to_world.normal(DVec3::Z).as_vec3() * if flip { -1.0 } else { 1.0 },
    };
    Ok(ShapeGeometry::from_primitives(vec![Primitive::Disk(disk)]))
}

impl Disk {
    /// Nearest hit before `length`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, _shear: &Shear, length: f32) -> Option<PrimitiveHit> {
        let to_center = self.center - ray.origin;
        let distance = to_center.dot(self.normal) / ray.direction.dot(self.normal);
        if !(distance > 0.0 && distance < length) {
            return None;
        }
        let local = ray.direction * distance - to_center;
        (local.length_squared() <= self.radius * self.radius).then(|| PrimitiveHit::at(distance))
    }

    /// The point of a hit, moved back into the plane.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        let point = ray.at(hit.distance);
        self.point(point - self.normal * (point - self.center).dot(self.normal))
    }

    fn point(&self, position: Vec3) -> SurfacePoint {
        let error = position_error(largest(self.center) + self.radius);
        SurfacePoint { position, normal: self.normal, error }
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        std::f32::consts::PI * self.radius * self.radius
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        // A disc reaches r·√(1 - nᵢ²) along axis i.
        let reach = (Vec3::ONE - self.normal * self.normal).max(Vec3::ZERO).map(f32::sqrt) * self.radius;
        (self.center - reach, self.center + reach)
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        let frame = Frame::from_normal(self.normal);
        let point = warp::disc(u) * self.radius;
        self.point(self.center + frame.tangent * point.x + frame.bitangent * point.y)
    }
}
