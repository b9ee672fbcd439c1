//! Triangles with a watertight test.

use glam::{Vec2, Vec3};

use super::ray::{PrimitiveHit, Ray, Shear, SurfacePoint, largest, position_error};
use crate::math::warp;

/// A triangle; its outside is where its vertices turn counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Vertices, m.
    pub vertices: [Vec3; 3],
}

impl Triangle {
    /// Nearest hit before `length`. Rays never slip between triangles that share vertices [Woop et al. 2013].
    #[inline]
    pub fn intersect(&self, ray: &Ray, shear: &Shear, length: f32) -> Option<PrimitiveHit> {
        self.intersect_sides::<true>(ray, shear, length)
    }

    /// The same; without `BACK` of rays from outside only.
    #[inline]
    pub(super) fn intersect_sides<const BACK: bool>(
        &self,
        ray: &Ray,
        shear: &Shear,
        length: f32,
    ) -> Option<PrimitiveHit> {
        let [x, y, z] = shear.axes;
        let [shear_x, shear_y, shear_z] = shear.shear;
        let sheared = |vertex: Vec3| {
            let relative = (vertex - ray.origin).to_array();
            [relative[x] - shear_x * relative[z], relative[y] - shear_y * relative[z], relative[z]]
        };
        // Spelled out: `map` over the array is not inlined.
        let (a, b, c) = (sheared(self.vertices[0]), sheared(self.vertices[1]), sheared(self.vertices[2]));
        let mut edges = [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]];
        if edges.contains(&0.0) {
            edges = edges_in_double_precision(a, b, c);
        }
        let outside = edges.iter().any(|edge| *edge < 0.0) && edges.iter().any(|edge| *edge > 0.0);
        let determinant = edges[0] + edges[1] + edges[2];
        // The determinant is −(direction·normal) over the direction's longest component.
        let from_back = (determinant > 0.0) != (shear_z > 0.0);
        if outside || determinant == 0.0 || (!BACK && from_back) {
            return None;
        }
        let inverse = 1.0 / determinant;
        let distance = shear_z * (edges[0] * a[2] + edges[1] * b[2] + edges[2] * c[2]) * inverse;
        (distance > 0.0 && distance < length)
            .then(|| PrimitiveHit { distance, barycentric: [edges[1] * inverse, edges[2] * inverse] })
    }

    /// The point of a hit, from barycentric coordinates: nearer to the surface than origin + distance·direction.
    #[inline]
    pub fn surface(&self, _ray: &Ray, hit: &PrimitiveHit) -> SurfacePoint {
        self.point(hit.barycentric[0], hit.barycentric[1])
    }

    fn point(&self, v: f32, w: f32) -> SurfacePoint {
        let [a, b, c] = self.vertices;
        let size = largest(a).max(largest(b)).max(largest(c));
        SurfacePoint {
            position: a * (1.0 - v - w) + b * v + c * w,
            normal: (b - a).cross(c - a).normalize(),
            error: position_error(size),
        }
    }

    /// The barycentric coordinates, which stand in where vertices have no texture coordinates.
    pub fn uv(&self, _position: Vec3, barycentric: [f32; 2]) -> Vec2 {
        Vec2::from_array(barycentric)
    }

    /// The derivatives by the barycentric coordinates, m.
    pub fn partials(&self, _position: Vec3) -> [Vec3; 2] {
        let [a, b, c] = self.vertices;
        [b - a, c - a]
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        let [a, b, c] = self.vertices;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let [a, b, c] = self.vertices;
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// A point uniform by area.
    pub fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        let barycentric = warp::triangle(u);
        self.point(barycentric.x, barycentric.y)
    }
}

/// The edge functions where single precision gave zero: products of two `f32` are exact in `f64`.
#[cold]
fn edges_in_double_precision(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let edge =
        |p: [f32; 3], q: [f32; 3]| (f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0])) as f32;
    [edge(c, b), edge(a, c), edge(b, a)]
}
