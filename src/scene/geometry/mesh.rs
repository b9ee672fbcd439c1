//! Shapes made of triangles: `cube`, `ply`, `obj`.
//!
//! `cube` is [-1, 1]³ under any affine `to_world`, outside outwards. `ply` and `obj` read `filename` (relative to the scene);
//! `face_normals` (boolean, false) shades every triangle flat; otherwise the
//! file's normals count, or smooth ones are made as in Mitsuba; `flip_normals` (boolean, false); `flip_tex_coords` is read and
//! changes nothing while there are no textures.

use glam::{DVec3, Vec3};

use super::Primitive;
use super::transform::{ToWorld, to_single};
use super::triangle::Triangle;
use super::triangle_mesh::TriangleMesh;
use super::{obj, ply};
use crate::scene::bundle::Bundle;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// What a shape plugin becomes.
#[derive(Clone, Debug, Default)]
pub struct ShapeGeometry {
    /// Its primitives.
    pub primitives: Vec<Primitive>,
    /// Unit shading normals of the three vertices, per primitive; empty when the shape has none.
    pub shading_normals: Vec<[Vec3; 3]>,
    /// Triangles without area that were left out.
    pub degenerate: usize,
}

impl ShapeGeometry {
    /// A shape whose shading normals are its true ones.
    pub fn from_primitives(primitives: Vec<Primitive>) -> Self {
        Self { primitives, ..Self::default() }
    }
}

/// Reads a `cube`.
pub fn read_cube(fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let to_world = ToWorld::read(fields)?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let mut corners = [Vec3::ZERO; 8];
    for (index, corner) in corners.iter_mut().enumerate() {
        let sign = |bit: usize| if index >> bit & 1 == 1 { 1.0 } else { -1.0 };
        *corner = to_single(to_world.point(DVec3::new(sign(0), sign(1), sign(2))), fields)?;
    }
    // Each face counter-clockwise from outside; bit 0 is x, bit 1 is y, bit 2 is z.
    const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis));
    let mirrored = axes[0].cross(axes[1]).dot(axes[2]) < 0.0;
    let triangles = FACES.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).map(|[a, b, c]| {
        let vertices = if mirrored != flip { [a, c, b] } else { [a, b, c] };
        Primitive::Triangle(Triangle { vertices: vertices.map(|index| corners[index]) })
    });
    Ok(ShapeGeometry::from_primitives(triangles.collect()))
}

/// Reads a `ply` shape.
pub fn read_ply(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    let (bytes, location) = mesh_file(fields, bundle)?;
    from_mesh(ply::read(&bytes, &location)?, fields)
}

/// Reads an `obj` shape.
pub fn read_obj(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    let (bytes, location) = mesh_file(fields, bundle)?;
    from_mesh(obj::read(&bytes, &location)?, fields)
}

fn mesh_file(
    fields: &mut Fields<'_>,
    bundle: &Bundle,
) -> Result<(std::sync::Arc<[u8]>, crate::scene::error::Location), SceneError> {
    let Some(name) = fields.string("filename")? else {
        let problem = format!("shape \"{}\" has no \"filename\"", fields.node().plugin);
        return Err(SceneError::new(fields.location(), problem, "name the mesh file, relative to the scene"));
    };
    let bytes = bundle.read(name, fields.location_of("filename"))?;
    let location = crate::scene::error::Location { file: name.to_owned(), ..Default::default() };
    Ok((bytes, location))
}

fn from_mesh(mesh: TriangleMesh, fields: &mut Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let to_world = ToWorld::read(fields)?;
    let face_normals = fields.boolean("face_normals")?.unwrap_or(false);
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    fields.ignore(&["flip_tex_coords"]);
    let points = mesh
        .positions
        .iter()
        .map(|point| to_single(to_world.point(Vec3::from_array(*point).as_dvec3()), fields))
        .collect::<Result<Vec<Vec3>, SceneError>>()?;
    let sign = if flip { -1.0 } else { 1.0 };
    let normals: Vec<Vec3> = match (face_normals, mesh.normals.is_empty()) {
        (true, _) => Vec::new(),
        (false, true) => smooth_normals(&mesh.triangles, &points).into_iter().map(|normal| normal * sign).collect(),
        (false, false) => mesh
            .normals
            .iter()
            .map(|normal| to_world.normal(Vec3::from_array(*normal).as_dvec3()).as_vec3() * sign)
            .collect(),
    };
    Ok(triangles_of(&mesh.triangles, &points, &normals, flip))
}

/// Vertex normals as means of the triangles around, weighted by their angle at the vertex [Thürmer & Wüthrich 1998].
fn smooth_normals(triangles: &[[u32; 3]], points: &[Vec3]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; points.len()];
    for indices in triangles {
        let corners = indices.map(|index| points[index as usize]);
        let Some(face) = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize() else { continue };
        for corner in 0..3 {
            let [a, b, c] = [corner, (corner + 1) % 3, (corner + 2) % 3].map(|index| corners[index]);
            let cosine = (b - a).normalize_or_zero().dot((c - a).normalize_or_zero()).clamp(-1.0, 1.0);
            normals[indices[corner] as usize] += face * libm::acosf(cosine);
        }
    }
    normals.into_iter().map(Vec3::normalize_or_zero).map(usable_or_nan).collect()
}

/// Vertices without triangles have no normal; [`triangles_of`] replaces what is not finite.
fn usable_or_nan(normal: Vec3) -> Vec3 {
    if normal == Vec3::ZERO { Vec3::NAN } else { normal }
}

fn triangles_of(triangles: &[[u32; 3]], points: &[Vec3], normals: &[Vec3], flip: bool) -> ShapeGeometry {
    let mut shape = ShapeGeometry::default();
    for indices in triangles {
        let [a, b, c] = indices.map(|index| index as usize);
        let order = if flip { [a, c, b] } else { [a, b, c] };
        let triangle = Triangle { vertices: order.map(|index| points[index]) };
        if triangle.area() == 0.0 {
            shape.degenerate += 1;
            continue;
        }
        if !normals.is_empty() {
            let face = triangle.sample([0.5, 0.5]).normal;
            // A vertex without a usable normal takes the triangle's.
            let usable = |normal: Vec3| if normal.is_finite() { normal } else { face };
            shape.shading_normals.push(order.map(|index| usable(normals[index])));
        }
        shape.primitives.push(Primitive::Triangle(triangle));
    }
    shape
}
