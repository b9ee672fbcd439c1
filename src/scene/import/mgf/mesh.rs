//! A triangle mesh that grows, and its binary PLY file.

use std::io::Write;

use glam::{DVec3, Vec3};

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
        let mut bytes = Vec::with_capacity(400 + 24 * self.positions.len() + 13 * self.triangles.len());
        let properties: String =
            ["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property float {name}\n")).concat();
        // Writing to memory cannot fail.
        let _ = write!(
            bytes,
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len()
        );
        for (position, normal) in self.positions.iter().zip(&self.normals) {
            let numbers = position.to_array().into_iter().chain(normal.to_array());
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
        }
        for triangle in &self.triangles {
            bytes.push(3);
            bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
        }
        bytes
    }
}
