//! A mesh as a binary PLY file.

use std::io::Write;

use super::super::triangle_mesh::{MeshValues, TriangleMesh};
use super::attributes::WRITTEN_ENDINGS;
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
    let (of_faces, of_vertices): (Vec<&MeshValues>, Vec<&MeshValues>) =
        mesh.attributes.iter().partition(|values| values.of_faces());
    let properties = properties + &attribute_properties(&of_vertices, "vertex_");
    let mut bytes = Vec::with_capacity(500 + mesh.size() + mesh.triangles.len());
    // Writing to memory cannot fail.
    let _ = write!(
        bytes,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
         property list uchar uint vertex_indices\n{}end_header\n",
        mesh.positions.len(),
        mesh.triangles.len(),
        attribute_properties(&of_faces, "face_")
    );
    for (index, position) in mesh.positions.iter().enumerate() {
        let normal = mesh.normals.get(index).into_iter().flatten();
        let coordinates = mesh.texture_coordinates.get(index).into_iter().flatten();
        let tangent = mesh.tangents.get(index).into_iter().flatten();
        let attributes = of_vertices.iter().flat_map(|values| values.of(index));
        let numbers = position.iter().chain(normal).chain(coordinates).chain(tangent).chain(attributes);
        bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
    }
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
        bytes.extend(of_faces.iter().flat_map(|values| values.of(index)).flat_map(|number| number.to_le_bytes()));
    }
    bytes
}

fn attribute_properties(attributes: &[&MeshValues], kind: &str) -> String {
    let named = |values: &&MeshValues| {
        let name = values.name.strip_prefix(kind).unwrap_or(&values.name).to_owned();
        let endings = WRITTEN_ENDINGS.iter().take(values.channels);
        endings.map(move |ending| format!("property float {name}_{ending}\n"))
    };
    attributes.iter().flat_map(named).collect()
}
