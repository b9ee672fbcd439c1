//! Shapes made of triangles: `cube`, `ply`, `obj`, `serialized`.
//!
//! `cube` is [-1, 1]³ under any affine `to_world`, outside outwards. The others read `filename` (relative to the scene);
//! `face_normals` (boolean, false) shades every triangle flat; otherwise the
//! file's normals count, or smooth ones are made as in Mitsuba; `flip_normals` (boolean, false); `flip_tex_coords` (boolean,
//! true for `obj`, else false) turns v into 1 - v. `obj` with `material` takes the faces after `usemtl` and that name only. `serialized` takes mesh `shape_index` (integer, 0) of its file.

mod attributes;

use std::borrow::Cow;

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::Primitive;
use super::one_sided_triangle::OneSidedTriangle;
use super::transform::{ToWorld, to_single};
use super::triangle::Triangle;
use super::triangle_mesh::TriangleMesh;
use super::{obj, ply, serialized};
use crate::scene::bundle::Bundle;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::MeshAttribute;

/// What a shape plugin becomes.
#[derive(Clone, Debug, Default)]
pub struct ShapeGeometry {
    /// Its primitives.
    pub primitives: Vec<Primitive>,
    /// Unit shading normals of the three vertices, per primitive; empty when the shape has none.
    pub shading_normals: Vec<[Vec3; 3]>,
    /// Texture coordinates of the three vertices, per primitive; empty when the shape has none.
    pub texture_coordinates: Vec<[Vec2; 3]>,
    /// Tangents of the three vertices, per primitive, each with the sign of its bitangent; empty where they follow from the
    /// texture coordinates.
    pub tangents: Vec<[Vec4; 3]>,
    /// What its file says of vertices or faces beyond what surfaces are made of.
    pub attributes: Vec<MeshAttribute>,
    /// Whether textures look up its hits' places on the mesh.
    pub needs_places: bool,
    /// Triangles without area that were left out.
    pub degenerate: usize,
    /// What the user should know of the shape's file, a sentence each.
    pub notices: Vec<String>,
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
    // Its faces are flat without being told so.
    fields.ignore(&["face_normals"]);
    let mut corners = [Vec3::ZERO; 8];
    for (index, corner) in corners.iter_mut().enumerate() {
        let sign = |bit: usize| if index >> bit & 1 == 1 { 1.0 } else { -1.0 };
        *corner = to_single(to_world.point(DVec3::new(sign(0), sign(1), sign(2))), fields)?;
    }
    let mirrored = to_world.handedness() < 0.0;
    let mut shape = ShapeGeometry::default();
    for face in CUBE_FACES {
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            let [a, b, c] = triangle;
            let order = if mirrored != flip { [c, b, a] } else { triangle };
            shape.texture_coordinates.push(order.map(|corner| CUBE_FACE_COORDINATES[corner]));
            let vertices = order.map(|corner| corners[face[corner]]);
            shape.primitives.push(Primitive::Triangle(Triangle { vertices }));
        }
    }
    Ok(shape)
}

/// The corners of each face counter-clockwise from outside; bit 0 of a corner is x, bit 1 is y, bit 2 is z.
const CUBE_FACES: [[usize; 4]; 6] =
    [[1, 5, 4, 0], [3, 2, 6, 7], [1, 3, 7, 5], [5, 7, 6, 4], [4, 6, 2, 0], [3, 1, 0, 2]];
/// The texture coordinates of each face's corners, as in Mitsuba.
const CUBE_FACE_COORDINATES: [Vec2; 4] = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO];

/// Reads a `ply` shape.
pub fn read_ply(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    if let Some(made) = fields.string("filename")?.and_then(|name| bundle.mesh(name)) {
        return from_mesh(Cow::Borrowed(&made), fields, false);
    }
    let (bytes, location) = mesh_file(fields, bundle)?;
    from_mesh(Cow::Owned(ply::read(&bytes, &location)?), fields, false)
}

/// Reads an `obj` shape.
pub fn read_obj(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    let (bytes, location) = mesh_file(fields, bundle)?;
    let material = fields.string("material")?;
    let obj::ObjMesh { mesh, notice } = obj::read(&bytes, material, &location)?;
    let shape = from_mesh(Cow::Owned(mesh), fields, true)?;
    Ok(ShapeGeometry { notices: notice.into_iter().collect(), ..shape })
}

/// Reads a `serialized` shape.
pub fn read_serialized(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<ShapeGeometry, SceneError> {
    let (bytes, location) = mesh_file(fields, bundle)?;
    let index = fields.integer("shape_index")?.unwrap_or(0);
    let index = usize::try_from(index)
        .map_err(|_| fields.error("shape_index", format!("\"shape_index\" is {index}"), "meshes are counted from 0"))?;
    from_mesh(Cow::Owned(serialized::read(&bytes, index, &location)?), fields, false)
}

pub(super) fn mesh_file(
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

/// `flip_by_default` is what `flip_tex_coords` is when it is not given.
fn from_mesh(
    mesh: Cow<'_, TriangleMesh>,
    fields: &mut Fields<'_>,
    flip_by_default: bool,
) -> Result<ShapeGeometry, SceneError> {
    let to_world = ToWorld::read(fields)?;
    let face_normals = fields.boolean("face_normals")?.unwrap_or(mesh.face_normals);
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let downwards = fields.boolean("flip_tex_coords")?.unwrap_or(flip_by_default);
    let points = points_in_world(&mesh, &to_world, fields)?;
    // A mirror image keeps its outside where the file's normals say what that is: its triangles turn the other way.
    let turns = to_world.turns_outside(fields)? && (face_normals || mesh.normals.is_empty());
    let reversed = flip != (to_world.handedness() < 0.0 && !turns);
    let sign = |turned: bool| if turned { -1.0 } else { 1.0 };
    let normals: Vec<Vec3> = match (face_normals, mesh.normals.is_empty()) {
        (true, _) => Vec::new(),
        (false, true) => {
            let normals = smooth_normals(&mesh.triangles, &points);
            normals.into_iter().map(|normal| normal * sign(reversed)).collect()
        }
        (false, false) => mesh
            .normals
            .iter()
            .map(|normal| to_world.normal(Vec3::from_array(*normal).as_dvec3()).as_vec3() * sign(flip))
            .collect(),
    };
    // A mirror image has the bitangents of a mirror image, whichever side is its outside.
    let side = sign(reversed);
    let tangent = |[x, y, z, w]: &[f32; 4]| {
        to_world.vector(DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z))).as_vec3().extend(*w * side)
    };
    let tangents = mesh.tangents.iter().map(tangent).collect();
    let (triangles, mut coordinates, values) = match mesh {
        Cow::Owned(mesh) => (Cow::Owned(mesh.triangles), mesh.texture_coordinates, mesh.attributes),
        Cow::Borrowed(mesh) => {
            (Cow::Borrowed(&mesh.triangles), mesh.texture_coordinates.clone(), mesh.attributes.clone())
        }
    };
    if downwards {
        coordinates.iter_mut().for_each(|[_, v]| *v = 1.0 - *v);
    }
    let vertices = Vertices { points, normals, coordinates, tangents };
    let mut shape = triangles_of(&triangles, &vertices, reversed);
    shape.attributes = attributes::of_triangles(values, &triangles, &vertices.points, reversed);
    check_area(&shape, triangles.len(), fields)?;
    Ok(shape)
}

/// A closed or open surface that is met from outside only, whose mesh lies in world space already and has normals and texture
/// coordinates.
pub(super) fn one_sided(mesh: TriangleMesh, fields: &Fields<'_>) -> Result<ShapeGeometry, SceneError> {
    let vertices = Vertices {
        points: points_in_world(&mesh, &ToWorld::IDENTITY, fields)?,
        normals: mesh.normals.into_iter().map(Vec3::from_array).collect(),
        coordinates: mesh.texture_coordinates,
        tangents: Vec::new(),
    };
    let mut shape = triangles_of(&mesh.triangles, &vertices, false);
    check_area(&shape, mesh.triangles.len(), fields)?;
    for primitive in &mut shape.primitives {
        if let Primitive::Triangle(triangle) = *primitive {
            *primitive = Primitive::OneSidedTriangle(OneSidedTriangle(triangle));
        }
    }
    Ok(shape)
}

fn points_in_world(mesh: &TriangleMesh, to_world: &ToWorld, fields: &Fields<'_>) -> Result<Vec<Vec3>, SceneError> {
    let point = |point: &[f32; 3]| to_single(to_world.point(Vec3::from_array(*point).as_dvec3()), fields);
    mesh.positions.iter().map(point).collect()
}

/// Fails when none of a mesh's triangles has an area.
fn check_area(shape: &ShapeGeometry, triangles: usize, fields: &Fields<'_>) -> Result<(), SceneError> {
    if !shape.primitives.is_empty() {
        return Ok(());
    }
    let problem = match triangles {
        1 => "the mesh's only triangle has no area".to_owned(),
        count => format!("none of the mesh's {count} triangles has an area"),
    };
    Err(SceneError::new(fields.location(), problem, "check the mesh, its size and its to_world"))
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

/// What triangles refer to, in world space.
struct Vertices {
    points: Vec<Vec3>,
    /// Unit, or not finite; empty when triangles are shaded flat.
    normals: Vec<Vec3>,
    /// Empty when the mesh has none.
    coordinates: Vec<[f32; 2]>,
    /// With the sign of the bitangent; empty when the mesh has none.
    tangents: Vec<Vec4>,
}

/// The corners of a triangle in the order of its primitive.
fn corners([a, b, c]: [u32; 3], reversed: bool) -> [u32; 3] {
    // As in Mitsuba, where barycentric coordinates stand in for texture coordinates.
    if reversed { [c, b, a] } else { [a, b, c] }
}

/// The triangle of three corners; none where it has no area.
fn with_area(order: [usize; 3], points: &[Vec3]) -> Option<Triangle> {
    let triangle = Triangle { vertices: order.map(|index| points[index]) };
    (triangle.area() != 0.0).then_some(triangle)
}

fn triangles_of(triangles: &[[u32; 3]], vertices: &Vertices, reversed: bool) -> ShapeGeometry {
    let Vertices { points, normals, coordinates, tangents } = vertices;
    let mut shape = ShapeGeometry::default();
    shape.primitives.reserve_exact(triangles.len());
    shape.shading_normals.reserve_exact(if normals.is_empty() { 0 } else { triangles.len() });
    shape.texture_coordinates.reserve_exact(if coordinates.is_empty() { 0 } else { triangles.len() });
    shape.tangents.reserve_exact(if tangents.is_empty() { 0 } else { triangles.len() });
    for indices in triangles {
        let order = corners(*indices, reversed).map(|index| index as usize);
        let Some(triangle) = with_area(order, points) else {
            shape.degenerate += 1;
            continue;
        };
        if !normals.is_empty() {
            let face = triangle.sample([0.5, 0.5]).normal;
            // A vertex without a usable normal takes the triangle's.
            let usable = |normal: Vec3| if normal.is_finite() { normal } else { face };
            shape.shading_normals.push(order.map(|index| usable(normals[index])));
        }
        if !coordinates.is_empty() {
            shape.texture_coordinates.push(order.map(|index| Vec2::from_array(coordinates[index])));
        }
        if !tangents.is_empty() {
            shape.tangents.push(order.map(|index| tangents[index]));
        }
        shape.primitives.push(Primitive::Triangle(triangle));
    }
    shape
}
