//! Texture coordinates and tangents: uv and its partial derivatives at a point of a surface, in Mitsuba's conventions. Meshes
//! may bring tangents of their own, with the sign of the bitangent, as glTF's do: the shading frame then follows those.
//!
//! | primitive | u | v |
//! |---|---|---|
//! | rectangle | (x + 1)/2 | (y + 1)/2 |
//! | disk | distance from the centre | φ/2π |
//! | sphere | φ/2π | θ/π, from +z |
//! | cylinder | φ/2π | height from `p0` over the whole |
//! | triangle | from its vertices, else the barycentric coordinate of the second vertex | …, of the third |
//!
//! x, y, z, φ and θ are in the shape's own space.

use glam::{Vec2, Vec3, Vec4};

use super::ray::SurfacePoint;
use super::surface::{Geometry, Interaction, NO_INSTANCE, Shape};
use super::texture_point::{Detail, TexturePoint};
use crate::math::{Frame, warp};

/// Marks a primitive without a value.
const NONE: u32 = u32::MAX;

/// Something that meshes bring along for each vertex, such as texture coordinates.
#[derive(Default)]
pub(super) struct AtVertices<T> {
    /// Of the three vertices.
    triangles: Vec<[T; 3]>,
    /// By primitive, an index into `triangles` or [`NONE`]; empty when there are none at all.
    of_primitive: Vec<u32>,
}

impl<T: Copy> AtVertices<T> {
    /// Adds a shape of `primitives` primitives with its values, which may be none.
    pub(super) fn push_shape(&mut self, primitives: usize, values: &[[T; 3]]) {
        let first = self.triangles.len();
        let index = |primitive| if values.is_empty() { NONE } else { (first + primitive) as u32 };
        self.of_primitive.extend((0..primitives).map(index));
        self.triangles.extend_from_slice(values);
    }

    /// Brings the primitives into the order of the tree.
    pub(super) fn reorder(&mut self, order: &[u32]) {
        self.of_primitive = match self.triangles.is_empty() {
            true => Vec::new(),
            false => order.iter().map(|index| self.of_primitive[*index as usize]).collect(),
        };
    }

    pub(super) fn get(&self, primitive: u32) -> Option<&[T; 3]> {
        self.triangles.get(*self.of_primitive.get(primitive as usize)? as usize)
    }
}

/// What a hit has where its material looks at texture coordinates.
pub(super) struct Parameterized {
    /// Texture coordinates.
    pub(super) uv: Vec2,
    /// The shading frame, with its tangent along ∂p/∂u.
    pub(super) frame: Frame,
    /// What else the material needs.
    pub(super) detail: Detail,
}

impl Parameterized {
    /// Of a shape that needs none of it.
    #[inline(always)]
    pub(super) fn around(normal: Vec3) -> Self {
        Self { uv: Vec2::ZERO, frame: Frame::from_normal(normal), detail: Detail::default() }
    }
}

impl Geometry {
    /// ∂p/∂u and ∂p/∂v at a hit, m, in world space. Both are zero where texture coordinates do not tell points apart.
    ///
    /// Means something where `hit.shape.needs_uv` is set; texture coordinates of other meshes are not kept.
    pub fn partials(&self, hit: &Interaction) -> [Vec3; 2] {
        match &self.instances {
            Some(instances) if hit.instance != NO_INSTANCE => instances.partials(hit),
            _ => self.partials_at(hit.primitive, hit.position),
        }
    }

    /// A point uniform by area on the primitive at a tree index, and where textures are looked up there.
    pub fn sample_for_texture(&self, primitive: u32, u: [f32; 2]) -> (SurfacePoint, TexturePoint) {
        let point = self.sample(primitive, u);
        (point, self.texture_point_at(primitive, point.position, warp::triangle(u).to_array()))
    }

    /// Where textures are looked up at a point of the primitive at a tree index; only triangles look at `barycentric`.
    pub(in crate::scene) fn texture_point_at(
        &self,
        primitive: u32,
        position: Vec3,
        barycentric: [f32; 2],
    ) -> TexturePoint {
        let detail = self.own_indices.get(primitive as usize).map(|own| Detail::on_mesh(*own, barycentric));
        TexturePoint { uv: self.uv_at(primitive, position, barycentric), detail: detail.unwrap_or(Detail::NOWHERE) }
    }

    /// Texture coordinates, frame and detail at a point of the primitive at a tree index of `shape`, which needs them. `normal` is the shading normal.
    #[inline(never)]
    pub(super) fn parameterized(
        &self,
        shape: Shape,
        primitive: u32,
        position: Vec3,
        normal: Vec3,
        barycentric: [f32; 2],
    ) -> Parameterized {
        let uv = self.uv_at(primitive, position, barycentric);
        let given = self.tangents.get(primitive).and_then(|triangle| between(triangle, barycentric));
        let frame = match given {
            Some(given) => tangent_frame(normal, given.truncate(), given.w < 0.0),
            // Right-handed even where coordinates are mirrored: so are the frames of Mitsuba (3.9.1), and its normal maps with them.
            None => tangent_frame(normal, self.partials_at(primitive, position)[0], false),
        };
        let detail = match self.own_indices.get(primitive as usize) {
            _ if shape.needs_partials => Detail::in_frame(&frame, self.partials_at(primitive, position)),
            Some(own) => Detail::on_mesh(*own, barycentric),
            None => Detail::default(),
        };
        Parameterized { uv, frame, detail }
    }

    /// Texture coordinates at a point of the primitive at a tree index; only triangles look at `barycentric`.
    pub(in crate::scene) fn uv_at(&self, primitive: u32, position: Vec3, barycentric: [f32; 2]) -> Vec2 {
        match self.coordinates.get(primitive) {
            Some([a, b, c]) => *a + (*b - *a) * barycentric[0] + (*c - *a) * barycentric[1],
            None => self.primitive(primitive).uv(position, barycentric),
        }
    }

    pub(super) fn partials_at(&self, primitive: u32, position: Vec3) -> [Vec3; 2] {
        let [first, second] = self.primitive(primitive).partials(position);
        let Some(triangle) = self.coordinates.get(primitive) else { return [first, second] };
        let ([one, other], determinant) = (edges(triangle), determinant(triangle));
        if determinant == 0.0 {
            return [Vec3::ZERO; 2];
        }
        let along_u = (first * other.y - second * one.y) / determinant;
        let along_v = (second * one.x - first * other.x) / determinant;
        if along_u.is_finite() && along_v.is_finite() { [along_u, along_v] } else { [Vec3::ZERO; 2] }
    }
}

/// The tangent at a point of a triangle, and the sign of its bitangent; none where those of the vertices cancel out.
fn between([a, b, c]: &[Vec4; 3], [v, w]: [f32; 2]) -> Option<Vec4> {
    let tangent = *a * (1.0 - v - w) + *b * v + *c * w;
    (tangent.truncate().length_squared() > 0.0 && tangent.is_finite()).then_some(tangent)
}

fn edges([a, b, c]: &[Vec2; 3]) -> [Vec2; 2] {
    [*b - *a, *c - *a]
}

fn determinant(triangle: &[Vec2; 3]) -> f32 {
    let [one, other] = edges(triangle);
    one.perp_dot(other)
}

/// The frame round `normal` whose tangent is as near to `tangent` as it can be; its bitangent is on the other side when
/// `mirrored`.
pub(super) fn tangent_frame(normal: Vec3, tangent: Vec3, mirrored: bool) -> Frame {
    // Normalized first: the partial derivatives of tiny shapes have no square.
    let tangent = tangent.normalize_or_zero();
    match (tangent - normal * normal.dot(tangent)).try_normalize() {
        Some(tangent) => {
            let bitangent = normal.cross(tangent);
            Frame { tangent, bitangent: if mirrored { -bitangent } else { bitangent }, normal }
        }
        None => Frame::from_normal(normal),
    }
}

/// The angle of (x, y) from +x, in turns: [0, 1].
pub(super) fn turns(x: f32, y: f32) -> f32 {
    let turns = libm::atan2f(y, x) * (0.5 * std::f32::consts::FRAC_1_PI);
    if turns < 0.0 { turns + 1.0 } else { turns }
}

/// Cosine and sine of the angle of (x, y) from +x; those of 0 for the origin.
pub(super) fn cosine_and_sine(x: f32, y: f32) -> [f32; 2] {
    Vec2::new(x, y).try_normalize().unwrap_or(Vec2::X).to_array()
}
