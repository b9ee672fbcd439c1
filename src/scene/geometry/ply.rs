//! Stanford PLY meshes: ASCII, and binary of either byte order.
//!
//! Of the vertices x, y, z, nx, ny, nz, u, v (or s, t) and the tangents of this program's own files are read, of the faces
//! their vertex indices, of both their [attributes]; all other elements and properties are passed over. Normals, texture coordinates and tangents count when
//! all of their components are there.

mod attributes;
mod body;
mod header;
mod writer;

use std::ops::Range;

use super::super::error::{Location, SceneError};
use super::triangle_mesh::TriangleMesh;
use attributes::Group;
use body::Body;
use header::{Element, Property};

pub use writer::write;

/// Reads the mesh of a PLY file. `location` names the mesh file and the shape that it belongs to.
///
/// # Errors
/// With the line or byte: on a header that cannot be read, a file that ends before its header's counts are met, indices
/// out of range, and coordinates that are not finite. Also when there is no face.
pub fn read(bytes: &[u8], location: &Location) -> Result<TriangleMesh, SceneError> {
    let header = header::read(bytes, location)?;
    let mut body = Body::new(bytes, &header, location);
    let mut mesh = TriangleMesh::default();
    // Faces may stand before the vertices, which then are counted by the header; the body is held to it.
    let vertices = header.elements.iter().find(|element| element.name == "vertex").map_or(0, |element| element.count);
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(&mut body, element, &mut mesh)?,
            "face" => read_faces(&mut body, element, vertices, &mut mesh)?,
            _ => skip(&mut body, element)?,
        }
    }
    if mesh.triangles.is_empty() {
        return Err(SceneError::new(location, "the mesh has no faces", "export it with its faces"));
    }
    Ok(mesh)
}

/// What scalar properties of a vertex are read.
const COMPONENTS: [&str; 12] =
    ["x", "y", "z", "nx", "ny", "nz", "u", "v", "tangent_x", "tangent_y", "tangent_z", "tangent_sign"];
const POSITION: Range<usize> = 0..3;
const NORMAL: Range<usize> = 3..6;
const TEXTURE: Range<usize> = 6..8;
const TANGENT: Range<usize> = 8..12;

/// The index of a property among [`COMPONENTS`], or their number for one that is not read.
fn component(name: &str) -> usize {
    let name = match name {
        "s" | "texture_u" => "u",
        "t" | "texture_v" => "v",
        other => other,
    };
    COMPONENTS.iter().position(|known| *known == name).unwrap_or(COMPONENTS.len())
}

fn read_vertices(body: &mut Body<'_>, element: &Element, mesh: &mut TriangleMesh) -> Result<(), SceneError> {
    let slots: Vec<usize> = element.properties.iter().map(|property| component(property.name())).collect();
    let has = |mut range: Range<usize>| range.all(|wanted| slots.contains(&wanted));
    let (normals, coordinates, tangents) = (has(NORMAL), has(TEXTURE), has(TANGENT));
    if !has(POSITION) {
        return Err(body.error("the vertices lack x, y or z", "export the mesh again"));
    }
    let count = body.checked_count(element)?;
    let mut attributes = attributes::find(element, "vertex_");
    let mut numbers = vec![0.0; element.properties.len()];
    mesh.positions.reserve_exact(count);
    mesh.normals.reserve_exact(if normals { count } else { 0 });
    mesh.texture_coordinates.reserve_exact(if coordinates { count } else { 0 });
    mesh.tangents.reserve_exact(if tangents { count } else { 0 });
    for index in 0..count {
        let mut values = [0.0_f32; COMPONENTS.len() + 1];
        for ((property, slot), number) in element.properties.iter().zip(&slots).zip(&mut numbers) {
            match property {
                Property::Scalar { kind, .. } => {
                    *number = body.scalar(*kind)?;
                    values[*slot] = *number as f32;
                }
                Property::List { count, item, .. } => body.skip_list(*count, *item)?,
            }
        }
        if let Some(component) = (0..COMPONENTS.len()).find(|component| !values[*component].is_finite()) {
            let problem = format!("{} of vertex {index} is not finite", COMPONENTS[component]);
            return Err(body.error(&problem, "repair the mesh"));
        }
        let [x, y, z, nx, ny, nz, u, v, tangent @ .., _] = values;
        mesh.positions.push([x, y, z]);
        mesh.normals.extend(normals.then_some([nx, ny, nz]));
        mesh.texture_coordinates.extend(coordinates.then_some([u, v]));
        mesh.tangents.extend(tangents.then_some(tangent));
        push_attributes(body, &mut attributes, &numbers, 1, &format_args!("vertex {index}"))?;
    }
    mesh.attributes.extend(attributes.into_iter().map(Group::into_values));
    Ok(())
}

/// Takes the attributes of a vertex or face among the numbers of its properties, `times` over.
fn push_attributes(
    body: &Body<'_>,
    attributes: &mut [Group],
    numbers: &[f64],
    times: usize,
    owner: &std::fmt::Arguments<'_>,
) -> Result<(), SceneError> {
    for group in attributes {
        let pushed = group.push(numbers, times);
        pushed.map_err(|name| body.error(&format!("{name} of {owner} is not finite"), "repair the mesh"))?;
    }
    Ok(())
}

fn read_faces(
    body: &mut Body<'_>,
    element: &Element,
    vertices: u64,
    mesh: &mut TriangleMesh,
) -> Result<(), SceneError> {
    let is_indices = |property: &Property| {
        matches!(property, Property::List { .. }) && ["vertex_indices", "vertex_index"].contains(&property.name())
    };
    let Some(indices) = element.properties.iter().position(is_indices) else {
        return Err(body.error("the faces have no list \"vertex_indices\"", "export the mesh again"));
    };
    let count = body.checked_count(element)?;
    let mut attributes = attributes::find(element, "face_");
    let mut numbers = vec![0.0; element.properties.len()];
    mesh.triangles.reserve(count);
    let mut corners = Vec::new();
    for face in 0..count {
        for (position, property) in element.properties.iter().enumerate() {
            match property {
                Property::Scalar { kind, .. } => numbers[position] = body.scalar(*kind)?,
                Property::List { count, item, .. } if position == indices => {
                    body.indices(*count, *item, &mut corners)?;
                }
                Property::List { count, item, .. } => body.skip_list(*count, *item)?,
            }
        }
        if corners.len() < 3 {
            let problem = format!("face {face} has {} corners", corners.len());
            return Err(body.error(&problem, "a face needs at least three"));
        }
        if let Some(index) = corners.iter().find(|index| u64::from(**index) >= vertices) {
            let problem = format!("face {face} refers to vertex {index}, but there are {vertices}, counted from 0");
            return Err(body.error(&problem, "repair the mesh"));
        }
        mesh.push_polygon(&corners);
        push_attributes(body, &mut attributes, &numbers, corners.len() - 2, &format_args!("face {face}"))?;
    }
    mesh.attributes.extend(attributes.into_iter().map(Group::into_values));
    Ok(())
}

fn skip(body: &mut Body<'_>, element: &Element) -> Result<(), SceneError> {
    for _ in 0..body.checked_count(element)? {
        for property in &element.properties {
            match property {
                Property::Scalar { kind, .. } => drop(body.scalar(*kind)?),
                Property::List { count, item, .. } => body.skip_list(*count, *item)?,
            }
        }
    }
    Ok(())
}
