//! What stands on a surface near a point, and may come between the point and others on the surface close by.

use glam::Vec3;

use super::primitive::Primitive;
use super::ray::{Ray, Shear};
use super::surface::Geometry;
use crate::math::lanes::larger;

/// So many are told apart; where there are more, rays look for themselves.
const MOST: usize = 8;

/// A flat disc with a thickness, over a surface.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Centre of its volume, m.
    pub(super) center: Vec3,
    /// Unit normal of the surface.
    pub(super) normal: Vec3,
    radius: f32,
    /// Half its thickness, m.
    pub(super) half: f32,
    /// Half the sides of the box around it, m.
    extent: Vec3,
}

impl Layer {
    /// The part of the cylinder of `radius` around the `normal` at `position` that lies between two `heights`, m.
    #[inline]
    pub fn new(position: Vec3, normal: Vec3, radius: f32, heights: [f32; 2]) -> Self {
        let half = 0.5 * (heights[1] - heights[0]);
        let across = (Vec3::ONE - normal * normal).max(Vec3::ZERO);
        let extent = Vec3::new(across.x.sqrt(), across.y.sqrt(), across.z.sqrt()) * radius + normal.abs() * half;
        Self { center: position + normal * (0.5 * (heights[0] + heights[1])), normal, radius, half, extent }
    }

    /// Smallest and largest coordinates, m.
    #[inline]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.center - self.extent, self.center + self.extent)
    }

    /// Whether a primitive may reach into it; false only where it does not.
    #[inline]
    pub fn may_hold(&self, primitive: &Primitive) -> bool {
        let (low, high) = primitive.bounds();
        let offset = (low + high) * 0.5 - self.center;
        let size = (high - low) * 0.5;
        if offset.abs().cmpgt(size + self.extent).any() {
            return false;
        }
        if offset.dot(self.normal).abs() > size.dot(self.normal.abs()) + self.half {
            return false;
        }
        let Some((point, normal)) = primitive.plane() else { return true };
        let distance = (point - self.center).dot(normal).abs();
        // A triangle without area has no normal; it is never hit, and kept.
        distance.is_nan() || distance <= self.reach(normal.dot(self.normal))
    }

    /// How far it reaches from its centre along a normal, by the cosine to its own, m.
    #[inline(always)]
    pub(super) fn reach(&self, cosine: f32) -> f32 {
        self.radius * larger(1.0 - cosine * cosine, 0.0).sqrt() + self.half * cosine.abs()
    }
}

/// Primitives that may reach into a layer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Obstacles {
    primitives: [u32; MOST],
    count: usize,
    /// Whether there are more, or some of instances.
    more: bool,
}

impl Obstacles {
    /// Whether nothing is in the way.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0 && !self.more
    }

    /// Whether rays look for themselves.
    #[inline]
    pub fn needs_tree(&self) -> bool {
        self.more
    }

    /// Adds a primitive by its index in tree order; whether others are still of interest.
    #[inline]
    pub(super) fn add(&mut self, index: usize) -> bool {
        match self.primitives.get_mut(self.count) {
            Some(place) => {
                *place = index as u32;
                self.count += 1;
            }
            None => self.more = true,
        }
        !self.more
    }
}

impl Geometry {
    /// What may reach into `layer`.
    #[inline]
    pub fn obstacles(&self, layer: &Layer) -> Obstacles {
        let mut obstacles = Obstacles::default();
        self.accelerator.collect(layer, &mut obstacles);
        if let Some(instances) = &self.instances {
            obstacles.more |= instances.may_reach(layer);
        }
        obstacles
    }

    /// [`is_blocked`](Self::is_blocked) for a ray that does not leave the layer whose obstacles are given.
    #[inline]
    pub fn is_blocked_within(&self, ray: &Ray, obstacles: &Obstacles) -> bool {
        if obstacles.more {
            return self.is_blocked(ray);
        }
        let shear = Shear::new(ray.direction);
        let mut primitives = obstacles.primitives[..obstacles.count].iter();
        primitives.any(|index| self.primitive(*index).intersect(ray, &shear, ray.length).is_some())
    }
}
