//! A triangle mesh that grows, and its binary PLY file.

use glam::{DVec3, Vec3};

use super::super::ply_bytes::ply;

/// Triangles of one material.
#[derive(Default)]
pub(super) struct Mesh {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds a corner with its unit shading normal and gives its index.
    pub(super) fn vertex(&mut self, position: DVec3, normal: DVec3) -> u32 {
        self.positions.push(position.as_vec3());
        self.normals.push(normal.as_vec3());
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle that is counter-clockwise from outside; one without area is left out.
    pub(super) fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        if (b - a).cross(c - a) != Vec3::ZERO {
            self.triangles.push(corners);
        }
    }

    /// How many triangles it has.
    pub(super) fn size(&self) -> usize {
        self.triangles.len()
    }

    /// The bytes of a little-endian PLY file.
    pub(super) fn ply(&self) -> Vec<u8> {
        ply(&self.positions, &self.normals, &self.triangles)
    }
}
