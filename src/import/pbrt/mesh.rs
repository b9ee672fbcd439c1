//! Triangle meshes that stand in the text, or that take the place of curved shapes.

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::scene::geometry::TriangleMesh;

/// A triangle mesh; coordinates are in single precision.
#[derive(Default)]
pub(super) struct Mesh {
    pub positions: Vec<Vec3>,
    /// As many as positions, or none for flat triangles.
    pub normals: Vec<Vec3>,
    /// As many as positions, or none; v as in pbrt, from the bottom of images.
    pub coordinates: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A surface over the unit square: `columns` × `rows` quadrilaterals. Its outside is where ∂p/∂u × ∂p/∂v points.
    pub(super) fn surface([columns, rows]: [u32; 2], point: impl Fn(DVec2) -> (DVec3, DVec3)) -> Self {
        let mut mesh = Self::default();
        for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
            let uv = DVec2::new(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
            let (position, normal) = point(uv);
            mesh.positions.push(position.as_vec3());
            mesh.normals.push(normal.as_vec3());
            mesh.coordinates.push(uv.as_vec2());
        }
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let corner = row * (columns + 1) + column;
            let [a, b, c, d] = [corner, corner + 1, corner + columns + 2, corner + columns + 1];
            for triangle in [[a, b, c], [a, c, d]] {
                // Those at a pole have no area.
                let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
                if (b - a).cross(c - a) != Vec3::ZERO {
                    mesh.triangles.push(triangle);
                }
            }
        }
        mesh
    }

    /// Gives each triangle vertices of its own, with the coordinates that pbrt gives to meshes without any.
    pub(super) fn with_default_coordinates(self) -> Self {
        let order = || self.triangles.iter().flatten().map(|index| *index as usize);
        let count = order().count() as u32;
        Self {
            positions: order().map(|index| self.positions[index]).collect(),
            normals: if self.normals.is_empty() { Vec::new() } else { order().map(|i| self.normals[i]).collect() },
            coordinates: [Vec2::ZERO, Vec2::X, Vec2::ONE].repeat(self.triangles.len()),
            triangles: (0..count / 3).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner)).collect(),
        }
    }

    /// Turns the triangles so that their outside is where the normals point, as in pbrt.
    pub(super) fn face_normals(&mut self) {
        let Self { positions, normals, triangles, .. } = self;
        if normals.is_empty() {
            return;
        }
        for triangle in triangles {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
            let normal: Vec3 = triangle.iter().map(|corner| normals[*corner as usize]).sum();
            if (b - a).cross(c - a).dot(normal) < 0.0 {
                triangle.swap(1, 2);
            }
        }
    }

    /// As shapes have it: v is 1 at the bottom of images.
    pub(super) fn into_triangles(self) -> TriangleMesh {
        TriangleMesh {
            positions: self.positions.iter().map(Vec3::to_array).collect(),
            normals: self.normals.iter().map(Vec3::to_array).collect(),
            texture_coordinates: self.coordinates.iter().map(|uv| [uv.x, 1.0 - uv.y]).collect(),
            triangles: self.triangles,
            ..TriangleMesh::default()
        }
    }
}
