//! `disk`: the unit disc in the xy plane, outside towards +z, under any affine `to_world` (an ellipse when that is uneven).
//!
//! Parameters: `to_world` (transform, identity), `flip_normals` (boolean, false).

use std::f32::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use super::Primitive;
use super::block::FlatFrame;
use super::mesh::ShapeGeometry;
use super::parameterization::{cosine_and_sine, turns};
use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint, largest, position_error};
use super::rectangle::dual_vectors;
use super::transform::{ToWorld, to_single};
use crate::math::warp;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// A flat ellipse.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    center: Vec3,
    /// Conjugate half axes.
    half: [Vec3; 2],
    /// Dual to `half` within the plane: `dual[i]·half[j] = δij`.
    dual: [Vec3; 2],
    normal: Vec3,
}

/// Reads the shape.
pub(crate) fn read(fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let to_world = ToWorld::read(fields)?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let (x, y) = (to_world.vector(DVec3::X), to_world.vector(DVec3::Y));
    let disk = Disk {
        center: to_single(to_world.point(DVec3::ZERO), fields)?,
        half: [to_single(x, fields)?, to_single(y, fields)?],
        dual: dual_vectors(x, y),
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
        let (u, v) = (local.dot(self.dual[0]), local.dot(self.dual[1]));
        (u * u + v * v <= 1.0).then(|| PrimitiveHit::at(distance))
    }

    /// The point of a hit, moved back into the plane.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        let point = ray.at(hit.distance);
        self.point(point - self.normal * (point - self.center).dot(self.normal))
    }

    fn point(&self, position: Vec3) -> SurfacePoint {
        let error = position_error(largest(self.center) + largest(self.half[0]) + largest(self.half[1]));
        SurfacePoint { position, normal: self.normal, error }
    }

    /// What a block of the accelerator keeps of it.
    pub fn frame(&self) -> FlatFrame {
        FlatFrame { center: self.center, normal: self.normal, dual: self.dual }
    }

    fn local(&self, position: Vec3) -> Vec2 {
        let relative = position - self.center;
        Vec2::new(relative.dot(self.dual[0]), relative.dot(self.dual[1]))
    }

    /// Distance from the centre over the radius, and angle in turns.
    pub fn uv(&self, position: Vec3, _barycentric: [f32; 2]) -> Vec2 {
        let local = self.local(position);
        Vec2::new(local.length(), turns(local.x, local.y))
    }

    /// ∂p/∂u and ∂p/∂v, m.
    pub fn partials(&self, position: Vec3) -> [Vec3; 2] {
        let local = self.local(position);
        let [cosine, sine] = cosine_and_sine(local.x, local.y);
        let [x, y] = self.half;
        [x * cosine + y * sine, (y * cosine - x * sine) * (TAU * local.length())]
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        std::f32::consts::PI * self.half[0].cross(self.half[1]).length()
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        // An ellipse a·cos t + b·sin t reaches √(aᵢ² + bᵢ²) along axis i.
        let [a, b] = self.half;
        let reach = (a * a + b * b).map(f32::sqrt);
        (self.center - reach, self.center + reach)
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        let point = warp::disc(u);
        self.point(self.center + self.half[0] * point.x + self.half[1] * point.y)
    }
}
