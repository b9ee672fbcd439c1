//! A triangle mesh that grows.

use glam::{DVec3, Vec3};

use crate::scene::geometry::TriangleMesh;

/// Triangles of one material, each corner with its shading normal.
#[derive(Default)]
pub(super) struct Mesh(TriangleMesh);

impl Mesh {
    /// Adds a corner with its unit shading normal and gives its index.
    pub(super) fn vertex(&mut self, position: DVec3, normal: DVec3) -> u32 {
        self.0.positions.push(position.as_vec3().to_array());
        self.0.normals.push(normal.as_vec3().to_array());
        self.0.positions.len() as u32 - 1
    }

    /// Adds a triangle that is counter-clockwise from outside; one without area is left out.
    pub(super) fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| Vec3::from_array(self.0.positions[corner as usize]));
        if (b - a).cross(c - a) != Vec3::ZERO {
            self.0.triangles.push(corners);
        }
    }

    /// How many vertices and triangles it has.
    pub(super) fn lengths(&self) -> [usize; 2] {
        [self.0.positions.len(), self.0.triangles.len()]
    }

    /// Takes off what was added after it had so many vertices and triangles.
    pub(super) fn split_off(&mut self, [vertices, triangles]: [usize; 2]) -> Self {
        let first = vertices as u32;
        let triangles = self.0.triangles.split_off(triangles);
        Self(TriangleMesh {
            positions: self.0.positions.split_off(vertices),
            normals: self.0.normals.split_off(vertices),
            // Triangles have vertices of their own.
            triangles: triangles.into_iter().map(|corners| corners.map(|corner| corner - first)).collect(),
            ..TriangleMesh::default()
        })
    }

    /// The finished mesh.
    pub(super) fn into_triangles(self) -> TriangleMesh {
        self.0
    }
}
