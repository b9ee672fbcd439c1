//! Triangles that share vertices.

use std::sync::Arc;

use crate::math::Rgb;

/// An indexed triangle mesh as a file gives it: every index is in range, every coordinate is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions in the shape's own space.
    pub positions: Vec<[f32; 3]>,
    /// A normal for each vertex, of any length; empty if the file has none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates for each vertex; empty if the file has none.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// A tangent of any length for each vertex, and the sign of its bitangent: `sign·(normal × tangent)`. Empty if
    /// tangents follow from the texture coordinates.
    pub tangents: Vec<[f32; 4]>,
    /// What else the file says of its vertices and faces.
    pub attributes: Vec<MeshValues>,
    /// Three indices into the vertices for each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the file asks for flat shading.
    pub face_normals: bool,
}

/// Numbers or colors of all vertices, or of all triangles, of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshValues {
    /// `vertex_…` or `face_…`.
    pub name: String,
    /// Numbers of each vertex or triangle: 1 or 3.
    pub channels: usize,
    /// `channels` numbers for each, all finite.
    pub numbers: Vec<f32>,
}

impl MeshValues {
    /// Whether it belongs to faces, not to vertices.
    pub fn of_faces(&self) -> bool {
        self.name.starts_with("face_")
    }

    /// The numbers of a vertex or triangle.
    pub fn of(&self, index: usize) -> &[f32] {
        self.numbers.chunks_exact(self.channels).nth(index).unwrap_or_default()
    }

    /// One color for each; numbers are greys.
    pub(super) fn colors(&self) -> Arc<[Rgb]> {
        let color = |value: &[f32]| Rgb::from_array(std::array::from_fn(|channel| value[channel.min(value.len() - 1)]));
        self.numbers.chunks_exact(self.channels).map(color).collect()
    }
}

impl TriangleMesh {
    /// Adds a polygon as a fan of triangles round its first corner; one with fewer than three corners adds nothing.
    pub(super) fn push_polygon(&mut self, corners: &[u32]) {
        if let [first, rest @ ..] = corners {
            self.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
        }
    }

    /// How many bytes its numbers take.
    pub fn size(&self) -> usize {
        let vertices = 12 * self.positions.len() + 12 * self.normals.len() + 8 * self.texture_coordinates.len();
        let attributes: usize = self.attributes.iter().map(|values| 4 * values.numbers.len()).sum();
        vertices + attributes + 16 * self.tangents.len() + 12 * self.triangles.len()
    }
}
