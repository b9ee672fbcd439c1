//! What mesh files say of vertices or faces, for the triangles of a shape.

use std::sync::Arc;

use glam::Vec3;

use super::{corners, with_area};
use crate::scene::geometry::triangle_mesh::MeshValues;
use crate::scene::texture::MeshAttribute;

/// The attributes of a shape: what its mesh says, for those of its triangles that have an area.
pub(super) fn of_triangles(
    given: Vec<MeshValues>,
    triangles: &[[u32; 3]],
    points: &[Vec3],
    reversed: bool,
) -> Vec<MeshAttribute> {
    let corners_of = |wanted: bool, corner: fn(u32, [u32; 3]) -> [u32; 3]| -> Arc<[[u32; 3]]> {
        let kept = (0_u32..).zip(triangles).filter_map(|(index, indices)| {
            let order = corners(*indices, reversed);
            with_area(order.map(|vertex| vertex as usize), points).map(|_| corner(index, order))
        });
        if wanted { kept.collect() } else { Arc::default() }
    };
    let any = |of_faces| given.iter().any(|values| values.of_faces() == of_faces);
    let of_vertices = corners_of(any(false), |_, order| order);
    let of_faces = corners_of(any(true), |face, _| [face; 3]);
    let attribute = |values: MeshValues| {
        let corners = if values.of_faces() { of_faces.clone() } else { of_vertices.clone() };
        MeshAttribute { values: values.colors(), name: values.name, corners }
    };
    given.into_iter().map(attribute).collect()
}
