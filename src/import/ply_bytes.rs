//! PLY files that importers make in memory.

use std::io::Write;

use glam::Vec3;

/// The bytes of a binary little-endian PLY file. `normals` are as many as `positions`, or none.
pub(super) fn ply(positions: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(400 + 24 * positions.len() + 13 * triangles.len());
    let names: &[&str] = if normals.is_empty() { &["x", "y", "z"] } else { &["x", "y", "z", "nx", "ny", "nz"] };
    let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
    // Writing to memory cannot fail.
    let _ = write!(
        bytes,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        positions.len(),
        triangles.len()
    );
    for (index, position) in positions.iter().enumerate() {
        let normal = normals.get(index).map(|normal| normal.to_array());
        let numbers = position.to_array().into_iter().chain(normal.into_iter().flatten());
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
    }
    for triangle in triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}
