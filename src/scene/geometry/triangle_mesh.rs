//! Triangles that share vertices.

/// An indexed triangle mesh as a file gives it: every index is in range, every coordinate is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions in the shape's own space.
    pub positions: Vec<[f32; 3]>,
    /// A normal for each vertex, of any length; empty if the file has none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates for each vertex; empty if the file has none.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// Three indices into the vertices for each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the file asks for flat shading.
    pub face_normals: bool,
}

impl TriangleMesh {
    /// Adds a polygon as a fan of triangles round its first corner; one with fewer than three corners adds nothing.
    pub(super) fn push_polygon(&mut self, corners: &[u32]) {
        if let [first, rest @ ..] = corners {
            self.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
        }
    }
}
