//! Where on a surface a texture is looked up.

use glam::{Vec2, Vec3};

use crate::math::Frame;

/// What few materials need of a hit beyond its texture coordinates: the partial derivatives of places, or a place on a mesh.
/// A shape needs one of them at most, so that they share three words and every other scene pays for no more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Detail([u32; 3]);

impl Detail {
    /// On no mesh: what meshes bring along has its mean there.
    pub const NOWHERE: Self = Self([u32::MAX, 0, 0]);

    /// (a, b, c), where ∂p/∂u and ∂p/∂v are (a, 0) and (b, c) along the frame's tangent and bitangent, m.
    pub fn of_partials(partials: [f32; 3]) -> Self {
        Self(partials.map(f32::to_bits))
    }

    /// Of these ∂p/∂u and ∂p/∂v, m.
    pub fn in_frame(frame: &Frame, partials: [Vec3; 2]) -> Self {
        let [along_u, along_v] = partials.map(|partial| frame.to_local(partial));
        Self::of_partials([along_u.x, along_v.x, along_v.y])
    }

    /// See [`Detail::of_partials`]; 0 where nothing asked for them.
    #[inline]
    pub fn partials(self) -> [f32; 3] {
        self.0.map(f32::from_bits)
    }

    /// A place on triangle `triangle` of a shape, counted among those with area, by the barycentric coordinates of its second
    /// and third vertex.
    pub fn on_mesh(triangle: u32, [v, w]: [f32; 2]) -> Self {
        Self([triangle, v.to_bits(), w.to_bits()])
    }

    /// See [`Detail::on_mesh`].
    #[inline]
    pub fn place_on_mesh(self) -> (usize, [f32; 2]) {
        let [triangle, v, w] = self.0;
        (triangle as usize, [f32::from_bits(v), f32::from_bits(w)])
    }
}

/// What textures are functions of.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint {
    /// Texture coordinates.
    pub uv: Vec2,
    /// What else the shape's material needs.
    pub detail: Detail,
}

impl From<Vec2> for TexturePoint {
    /// A point of an image, not of a surface.
    fn from(uv: Vec2) -> Self {
        Self { uv, detail: Detail::NOWHERE }
    }
}

impl Default for TexturePoint {
    fn default() -> Self {
        Vec2::ZERO.into()
    }
}
