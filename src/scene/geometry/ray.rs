//! Rays, and what is precomputed per ray for watertight triangle tests.

use glam::Vec3;

/// A half line with an end.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts, m.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Hits at `0 < distance < length` count, m; may be infinite.
    pub length: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, length: f32::INFINITY }
    }

    /// The point at `distance`.
    #[inline]
    pub fn at(&self, distance: f32) -> Vec3 {
        self.origin + self.direction * distance
    }
}

/// The shear that maps a ray's direction to +z [Woop, Benthin & Wald 2013, section 3.1].
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// Axes in the order x, y, z of the sheared space; the direction is longest along the third.
    pub axes: [usize; 3],
    /// Shear along x and y, and the scale along z.
    pub shear: [f32; 3],
}

impl Shear {
    /// Stands where no triangle will be tested.
    pub const UNUSED: Self = Self { axes: [0, 1, 2], shear: [0.0, 0.0, 1.0] };

    /// The shear of a unit direction.
    #[inline]
    pub fn new(direction: Vec3) -> Self {
        let size = direction.abs();
        let z = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let inverse = 1.0 / direction[z];
        Self { axes: [x, y, z], shear: [direction[x] * inverse, direction[y] * inverse, inverse] }
    }
}

/// Where a ray meets a primitive.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveHit {
    /// Distance along the ray, m.
    pub distance: f32,
    /// Barycentric coordinates of a triangle's second and third vertex; unused by other primitives.
    pub barycentric: [f32; 2],
}

impl PrimitiveHit {
    /// A hit of a primitive that needs no coordinates.
    pub fn at(distance: f32) -> Self {
        Self { distance, barycentric: [0.0; 2] }
    }
}

/// A point of a surface with its unit normal and how far rounding may have moved it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position, m.
    pub position: Vec3,
    /// Unit normal of the true surface, on the shape's outside.
    pub normal: Vec3,
    /// Bound on the rounding error of `position`, m.
    pub error: f32,
}

/// Rounding error of a position that was computed from coordinates up to `size`.
#[inline]
pub fn position_error(size: f32) -> f32 {
    // Eight units in the last place: transforms, barycentric sums and projections lose fewer.
    size * (8.0 * f32::EPSILON)
}

/// The largest coordinate of `vector` in size.
#[inline]
pub fn largest(vector: Vec3) -> f32 {
    vector.abs().max_element()
}
