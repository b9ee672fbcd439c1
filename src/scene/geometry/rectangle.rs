//! `rectangle`: the square [-1, 1]² in the xy plane, outside towards +z, under any affine `to_world`.
//!
//! Parameters: `to_world` (transform, identity), `flip_normals` (boolean, false).

use glam::{DVec3, Vec2, Vec3};

use super::Primitive;
use super::block::FlatFrame;
use super::mesh::ShapeGeometry;
use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint, largest, position_error};
use super::transform::{ToWorld, to_single};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// A parallelogram.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    center: Vec3,
    /// Half sides.
    half: [Vec3; 2],
    /// Dual to `half` within the plane: `dual[i]·half[j] = δij`.
    dual: [Vec3; 2],
    normal: Vec3,
}

/// Reads the shape.
pub(crate) fn read(fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let to_world = ToWorld::read(fields)?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    // It is flat without being told so.
    fields.ignore(&["face_normals"]);
    let (x, y) = (to_world.vector(DVec3::X), to_world.vector(DVec3::Y));
    let normal = to_world.normal(DVec3::Z) * if flip { -1.0 } else { 1.0 };
    let rectangle = Rectangle {
        center: to_single(to_world.point(DVec3::ZERO), fields)?,
        half: [to_single(x, fields)?, to_single(y, fields)?],
        dual: dual_vectors(x, y),
        normal: normal.as_vec3(),
    };
    Ok(ShapeGeometry::from_primitives(vec![Primitive::Rectangle(rectangle)]))
}

/// The vectors in the plane of `x` and `y` with `dual[0]·x = dual[1]·y = 1` and `dual[0]·y = dual[1]·x = 0`.
pub(crate) fn dual_vectors(x: DVec3, y: DVec3) -> [Vec3; 2] {
    let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
    let determinant = xx * yy - xy * xy;
    [((x * yy - y * xy) / determinant).as_vec3(), ((y * xx - x * xy) / determinant).as_vec3()]
}

impl Rectangle {
    /// Nearest hit before `length`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, _shear: &Shear, length: f32) -> Option<PrimitiveHit> {
        let to_center = self.center - ray.origin;
        let distance = to_center.dot(self.normal) / ray.direction.dot(self.normal);
        if !(distance > 0.0 && distance < length) {
            return None;
        }
        let local = ray.direction * distance - to_center;
        let inside = local.dot(self.dual[0]).abs() <= 1.0 && local.dot(self.dual[1]).abs() <= 1.0;
        inside.then(|| PrimitiveHit::at(distance))
    }

    /// The point of a hit, moved back into the plane.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        let point = ray.at(hit.distance);
        self.point(point - self.normal * (point - self.center).dot(self.normal))
    }

    #[inline]
    fn point(&self, position: Vec3) -> SurfacePoint {
        let size = largest(self.center) + largest(self.half[0]) + largest(self.half[1]);
        SurfacePoint { position, normal: self.normal, error: position_error(size) }
    }

    /// What a block of the accelerator keeps of it.
    pub fn frame(&self) -> FlatFrame {
        FlatFrame { center: self.center, normal: self.normal, dual: self.dual }
    }

    /// From 0 to 1 along each side.
    pub fn uv(&self, position: Vec3, _barycentric: [f32; 2]) -> Vec2 {
        let local = position - self.center;
        Vec2::new(local.dot(self.dual[0]) + 1.0, local.dot(self.dual[1]) + 1.0) * 0.5
    }

    /// ∂p/∂u and ∂p/∂v, m.
    pub fn partials(&self, _position: Vec3) -> [Vec3; 2] {
        self.half.map(|half| half * 2.0)
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        4.0 * self.half[0].cross(self.half[1]).length()
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let reach = self.half[0].abs() + self.half[1].abs();
        (self.center - reach, self.center + reach)
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        self.point(self.center + self.half[0] * (2.0 * u[0] - 1.0) + self.half[1] * (2.0 * u[1] - 1.0))
    }
}
