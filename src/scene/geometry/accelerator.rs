//! The bounding volume hierarchy over a scene's primitives. The only file that names obvhs.
//!
//! obvhs clamps the near distance to 10⁻⁴ of its own units, so coordinates are scaled by a power of two (which is exact) to
//! sizes where that is below the spacing of `f32`.

use std::time::Duration;

use glam::Vec3;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb, ray::RayHit};

use super::primitive::Primitive;
use super::ray::{PrimitiveHit, Ray, Shear, largest};

/// A hierarchy over boxes, whatever is in them.
pub struct BoxTree {
    tree: CwBvh,
    /// World units to tree units.
    scale: f32,
}

struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl BoxTree {
    /// Builds over boxes, each of a smallest and a largest corner; also gives the tree's order as indices into them.
    pub fn build(boxes: impl Iterator<Item = (Vec3, Vec3)> + Clone) -> (Self, Vec<u32>) {
        let size = boxes.clone().map(|(low, high)| largest(low).max(largest(high))).fold(0.0, f32::max);
        let scale = scale_for(size);
        let bounds: Vec<Bounds> = boxes.map(|(low, high)| Bounds(padded(low * scale, high * scale))).collect();
        if bounds.is_empty() {
            return (Self { tree: CwBvh::default(), scale }, Vec::new());
        }
        let mut tree = build_cwbvh(&bounds, parameters(bounds.len()), &mut Duration::default());
        let order = std::mem::take(&mut tree.primitive_indices);
        tree.nodes.shrink_to_fit();
        (Self { tree, scale }, order)
    }

    /// Shows `visit` the boxes along `ray`, by their place in the tree's order. It gives the distance of a hit nearer than
    /// all before, and from then on boxes farther away are left out.
    #[inline]
    pub fn visit_nearest(&self, ray: &Ray, mut visit: impl FnMut(usize) -> Option<f32>) {
        self.tree.ray_traverse(self.tree_ray(ray), &mut RayHit::none(), |_, index| match visit(index) {
            Some(distance) => distance * self.scale,
            None => f32::INFINITY,
        });
    }

    /// Shows `visit` the boxes along `ray` until it says yes; whether it did.
    #[inline]
    pub fn visit_any(&self, ray: &Ray, mut visit: impl FnMut(usize) -> bool) -> bool {
        let mut found = false;
        self.tree.ray_traverse_miss(self.tree_ray(ray), |_, index| {
            found = visit(index);
            if found { 0.0 } else { f32::INFINITY }
        });
        found
    }

    #[inline]
    fn tree_ray(&self, ray: &Ray) -> obvhs::ray::Ray {
        let length = ray.length * self.scale;
        // obvhs misses everything along directions with a component of -0.0; adding zero makes it +0.0.
        let direction = ray.direction + Vec3::ZERO;
        obvhs::ray::Ray::new((ray.origin * self.scale).into(), direction.into(), 0.0, length)
    }
}

/// How much work goes into a tree over `count` boxes. On a bumpy ball of 10⁶ triangles the slow one takes 4.9 s and the medium
/// one 3.3 s, and rays are as fast in either; below 10⁵ the slow one takes a tenth of a second or two, and finds the
/// better trees where triangles are of uneven size.
fn parameters(count: usize) -> BvhBuildParams {
    match count {
        0..100_000 => BvhBuildParams::slow_build(),
        _ => BvhBuildParams::medium_build(),
    }
}

/// A hierarchy over primitives that it owns in its own order.
pub struct Accelerator {
    tree: BoxTree,
    primitives: Vec<Primitive>,
    /// Whether rays need their shear.
    has_triangles: bool,
}

impl Accelerator {
    /// Builds over `primitives`; also gives the new order as indices into them.
    pub fn build(primitives: Vec<Primitive>) -> (Self, Vec<u32>) {
        let (tree, order) = BoxTree::build(primitives.iter().map(Primitive::bounds));
        let has_triangles = primitives.iter().any(|primitive| matches!(primitive, Primitive::Triangle(_)));
        let primitives = order.iter().map(|index| primitives[*index as usize]).collect();
        (Self { tree, primitives, has_triangles }, order)
    }

    /// The primitives in tree order.
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The nearest hit and the index of its primitive.
    #[inline]
    pub fn nearest(&self, ray: &Ray) -> Option<(usize, PrimitiveHit)> {
        let shear = self.shear(ray);
        let mut nearest = PrimitiveHit::at(ray.length);
        let mut found = usize::MAX;
        self.tree.visit_nearest(ray, |index| {
            let hit = self.primitives[index].intersect(ray, &shear, nearest.distance)?;
            (nearest, found) = (hit, index);
            Some(hit.distance)
        });
        (found != usize::MAX).then_some((found, nearest))
    }

    /// Whether anything is hit before the ray's length.
    #[inline]
    pub fn is_blocked(&self, ray: &Ray) -> bool {
        let shear = self.shear(ray);
        self.tree.visit_any(ray, |index| self.primitives[index].intersect(ray, &shear, ray.length).is_some())
    }

    #[inline]
    fn shear(&self, ray: &Ray) -> Shear {
        if self.has_triangles { Shear::new(ray.direction) } else { Shear::UNUSED }
    }
}

/// The power of two that brings coordinates of `size` to about 4096.
fn scale_for(size: f32) -> f32 {
    let exponent = if size > 0.0 { libm::frexpf(size).1 } else { 0 };
    libm::ldexpf(1.0, (12 - exponent).clamp(-126, 127))
}

/// Room for rounding, so that flat boxes keep every ray that meets what they hold.
fn padded(low: Vec3, high: Vec3) -> Aabb {
    let padding = largest(low).max(largest(high)) * (4.0 * f32::EPSILON);
    Aabb { min: (low - padding).into(), max: (high + padding).into() }
}
