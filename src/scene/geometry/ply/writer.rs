//! A mesh as a binary PLY file.

use std::io::Write;

use super::super::triangle_mesh::TriangleMesh;
use super::{COMPONENTS, NORMAL, POSITION, TANGENT, TEXTURE};

/// The bytes of a little-endian PLY file that [`read`](super::read) reads to the same mesh, but for `face_normals`.
pub fn write(mesh: &TriangleMesh) -> Vec<u8> {
    let optional = [
        (NORMAL, !mesh.normals.is_empty()),
        (TEXTURE, !mesh.texture_coordinates.is_empty()),
        (TANGENT, !mesh.tangents.is_empty()),
    ];
    let given = optional.into_iter().filter(|(_, given)| *given).map(|(range, _)| range);
    let names = [POSITION].into_iter().chain(given).flat_map(|range| &COMPONENTS[range]);
    let properties: String = names.map(|name| format!("property float {name}\n")).collect();
    let mut bytes = Vec::with_capacity(500 + mesh.size() + mesh.triangles.len());
    // Writing to memory cannot fail.
    let _ = write!(
        bytes,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    );
    for (index, position) in mesh.positions.iter().enumerate() {
        let normal = mesh.normals.get(index).into_iter().flatten();
        let coordinates = mesh.texture_coordinates.get(index).into_iter().flatten();
        let tangent = mesh.tangents.get(index).into_iter().flatten();
        let numbers = position.iter().chain(normal).chain(coordinates).chain(tangent);
        bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}
