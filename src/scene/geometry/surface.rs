//! All surfaces of a scene, and where a path meets them.

use glam::Vec3;

use super::accelerator::Accelerator;
use super::mesh::ShapeGeometry;
use super::primitive::Primitive;
use super::ray::{PrimitiveHit, Ray};
use crate::math::Frame;

/// Marks a shape without light.
pub const NO_LIGHT: u32 = u32::MAX;
const NO_SHADING: u32 = u32::MAX;

/// What all primitives of a shape share.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Index of its material.
    pub material: u32,
    /// Index of its area light, or [`NO_LIGHT`].
    pub light: u32,
}

#[derive(Clone, Copy)]
struct PrimitiveInfo {
    shape: u32,
    shading: u32,
}

/// All surfaces.
pub struct Geometry {
    accelerator: Accelerator,
    info: Vec<PrimitiveInfo>,
    shading_normals: Vec<[Vec3; 3]>,
    shapes: Vec<Shape>,
    low: Vec3,
    high: Vec3,
}

/// Where a path meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Interaction {
    /// Position, m.
    pub position: Vec3,
    /// Unit normal of the true surface, on the shape's outside.
    pub geometric_normal: Vec3,
    /// Frame around the shading normal.
    pub frame: Frame,
    /// Unit direction back along the path, world space.
    pub outgoing: Vec3,
    /// Distance from the ray's origin, m.
    pub distance: f32,
    /// The shape.
    pub shape: Shape,
    /// The primitive in tree order.
    pub primitive: u32,
    /// Bound on the rounding error of `position`, m.
    pub error: f32,
}

impl Interaction {
    /// A ray that leaves the surface in `direction` and does not meet it again by rounding.
    #[inline]
    pub fn ray_to(&self, direction: Vec3) -> Ray {
        Ray::new(self.offset_towards(direction), direction)
    }

    /// The position, moved off the surface to the side of `direction`.
    #[inline]
    pub fn offset_towards(&self, direction: Vec3) -> Vec3 {
        self.position + self.geometric_normal * self.error.copysign(direction.dot(self.geometric_normal))
    }
}

impl Geometry {
    /// Collects shapes in order and builds the accelerator. Also gives, per shape, the tree indices of its primitives.
    pub fn build(shapes: Vec<(Shape, ShapeGeometry)>) -> (Self, Vec<Vec<u32>>) {
        let mut primitives = Vec::new();
        let mut info = Vec::new();
        let mut shading_normals = Vec::new();
        for (shape, (_, geometry)) in shapes.iter().enumerate() {
            let smooth = !geometry.shading_normals.is_empty();
            for index in 0..geometry.primitives.len() {
                let shading = if smooth { (shading_normals.len() + index) as u32 } else { NO_SHADING };
                info.push(PrimitiveInfo { shape: shape as u32, shading });
            }
            primitives.extend_from_slice(&geometry.primitives);
            shading_normals.extend_from_slice(&geometry.shading_normals);
        }
        let (accelerator, order) = Accelerator::build(&primitives);
        let info: Vec<PrimitiveInfo> = order.iter().map(|index| info[*index as usize]).collect();
        let mut members = vec![Vec::new(); shapes.len()];
        for (index, info) in info.iter().enumerate() {
            members[info.shape as usize].push(index as u32);
        }
        let boxes = primitives.iter().map(Primitive::bounds);
        let (low, high) = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
        let shapes = shapes.into_iter().map(|(shape, _)| shape).collect();
        (Self { accelerator, info, shading_normals, shapes, low, high }, members)
    }

    /// The primitive at a tree index.
    pub fn primitive(&self, index: u32) -> &Primitive {
        &self.accelerator.primitives()[index as usize]
    }

    /// How many primitives there are: triangles, and analytic shapes as one each.
    pub fn primitive_count(&self) -> usize {
        self.info.len()
    }

    /// Smallest and largest coordinates, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.low, self.high)
    }

    /// Centre and radius of a sphere around everything, m.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let center = (self.low + self.high) * 0.5;
        (center, center.distance(self.high).max(f32::MIN_POSITIVE) * 1.0001)
    }

    /// Records that `shape` carries `light`.
    pub fn set_light(&mut self, shape: usize, light: u32) {
        self.shapes[shape].light = light;
    }

    /// The first surface along `ray`.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction> {
        let (index, hit) = self.accelerator.nearest(ray)?;
        Some(self.interaction(ray, index, &hit))
    }

    /// Whether anything is between a ray's origin and its length.
    #[inline]
    pub fn is_blocked(&self, ray: &Ray) -> bool {
        self.accelerator.is_blocked(ray)
    }

    #[inline]
    fn interaction(&self, ray: &Ray, index: usize, hit: &PrimitiveHit) -> Interaction {
        let point = self.accelerator.primitives()[index].surface(ray, hit);
        let info = self.info[index];
        let (shading, geometric) = match info.shading {
            NO_SHADING => (point.normal, point.normal),
            shading => self.shading_normal(shading, hit, point.normal),
        };
        Interaction {
            position: point.position,
            geometric_normal: geometric,
            frame: Frame::from_normal(shading),
            outgoing: -ray.direction,
            distance: hit.distance,
            shape: self.shapes[info.shape as usize],
            primitive: index as u32,
            error: point.error,
        }
    }

    /// The interpolated normal, and the true one turned to its side: the file's normals say what is outside.
    fn shading_normal(&self, shading: u32, hit: &PrimitiveHit, geometric: Vec3) -> (Vec3, Vec3) {
        let [a, b, c] = self.shading_normals[shading as usize];
        let [v, w] = hit.barycentric;
        let Some(normal) = (a * (1.0 - v - w) + b * v + c * w).try_normalize() else {
            return (geometric, geometric);
        };
        (normal, if normal.dot(geometric) < 0.0 { -geometric } else { geometric })
    }
}
