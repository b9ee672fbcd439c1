//! Mesh primitives become meshes.

use std::collections::HashMap;

use glam::DVec3;

use super::accessor::Accessor;
use super::entry::Entry;
use super::{GENERATED_FOLDER, Input, Output, extensions, tangents};
use crate::scene::error::SceneError;
use crate::scene::geometry::TriangleMesh;
use crate::scene::geometry::triangle_mesh::MeshValues;
use crate::scene::notice::Notice;

/// A primitive as a mesh of the bundle.
#[derive(Clone)]
pub(super) struct MeshFile {
    pub name: String,
    /// How many triangles it has.
    pub triangles: usize,
    /// Whether the primitive has no normals; glTF then wants flat triangles.
    pub flat: bool,
    /// Least and greatest coordinates in the mesh's own space.
    pub bounds: [DVec3; 2],
}

/// What makes two primitives the same mesh.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    mode: usize,
    accessors: [Option<usize>; 6],
    wish: Wish,
}

/// The attribute that holds the colors of vertices, and the name that textures know them by.
const COLORS: &str = "COLOR_0";
pub(super) const VERTEX_COLOR: &str = "vertex_color";

/// What a material wants of a mesh.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Wish {
    /// The set of texture coordinates.
    pub texture_coordinates: usize,
    /// Whether it has a normal map, which needs tangents.
    pub tangents: bool,
    /// Whether the vertices have colors.
    pub colors: bool,
}

/// The meshes of all primitives so far.
#[derive(Default)]
pub(super) struct MeshFiles {
    files: HashMap<Key, Option<MeshFile>>,
}

impl MeshFiles {
    /// The mesh of a primitive; nothing when it has no triangles.
    ///
    /// # Errors
    /// On accessors that lead out of their buffers, indices out of range, numbers that are not finite.
    pub(super) fn file<'a>(
        &mut self,
        primitive: &Entry<'a>,
        wish: Wish,
        input: &Input<'a>,
        output: &mut Output,
    ) -> Result<Option<MeshFile>, SceneError> {
        let Some(source) = Primitive::open(primitive, wish, input, output)? else { return Ok(None) };
        let key = Key { mode: source.mode, accessors: source.keys, wish };
        if let Some(known) = self.files.get(&key) {
            return Ok(known.clone());
        }
        let triangles = source.triangles()?;
        let file = if triangles.is_empty() {
            output.notices.add(Notice::ignored(&primitive.location(), "a primitive without triangles", ""));
            None
        } else {
            let name = format!("{GENERATED_FOLDER}mesh_{}.ply", self.files.len());
            let (mut mesh, bounds) = source.mesh(&triangles, output)?;
            if wish.tangents && mesh.tangents.is_empty() {
                mesh = tangents::with_tangents(mesh);
            }
            let file = MeshFile { triangles: triangles.len(), flat: source.normals.is_none(), bounds, name };
            output.made.meshes.insert(file.name.clone(), mesh.into());
            Some(file)
        };
        self.files.insert(key, file.clone());
        Ok(file)
    }
}

/// The opened accessors of a primitive.
struct Primitive<'a> {
    entry: Entry<'a>,
    mode: usize,
    /// Indices of the accessors of: indices, positions, normals, texture coordinates, tangents, colors.
    keys: [Option<usize>; 6],
    indices: Option<Accessor<'a>>,
    positions: Accessor<'a>,
    normals: Option<Accessor<'a>>,
    coordinates: Option<Accessor<'a>>,
    tangents: Option<Accessor<'a>>,
    colors: Option<Accessor<'a>>,
}

// Mode 5, between them, is the strip.
const TRIANGLES: usize = 4;
const FAN: usize = 6;

impl<'a> Primitive<'a> {
    /// Opens the accessors; nothing for points, lines, and primitives without positions.
    fn open(entry: &Entry<'a>, wish: Wish, input: &Input<'a>, output: &mut Output) -> Result<Option<Self>, SceneError> {
        extensions::report_unread(entry, output)?;
        check_compression(entry, output)?;
        let mode = entry.integer("mode")?.unwrap_or(TRIANGLES);
        let attributes = entry.child("attributes")?;
        let Some(attributes) = attributes.filter(|attributes| attributes.has("POSITION")) else {
            output.notices.add(Notice::ignored(&entry.location(), "a primitive without positions", ""));
            return Ok(None);
        };
        if mode < TRIANGLES {
            output.notices.add(Notice::ignored(
                &entry.location(),
                "a primitive of points or lines",
                "it has no surface",
            ));
            return Ok(None);
        }
        if mode > FAN {
            return Err(entry.error(format!("there is no primitive mode {mode}"), "give a mode from 0 to 6"));
        }
        report_unused(entry, &attributes, output);
        let open = |owner: &Entry<'a>, key: &str, kind: &str| -> Result<_, SceneError> {
            let Some((index, accessor)) = owner.reference(key, "accessors")? else { return Ok((None, None)) };
            Ok((Some(index), Some(Accessor::open(input.buffers, &accessor, kind)?)))
        };
        let (indices_key, indices) = open(entry, "indices", "SCALAR")?;
        let (positions_key, Some(positions)) = open(&attributes, "POSITION", "VEC3")? else { return Ok(None) };
        let (normals_key, normals) = open(&attributes, "NORMAL", "VEC3")?;
        let set = format!("TEXCOORD_{}", wish.texture_coordinates);
        let (coordinates_key, coordinates) = open(&attributes, &set, "VEC2")?;
        // glTF passes tangents over where it makes the normals.
        let (tangents_key, tangents) = match wish.tangents && normals.is_some() {
            true => open(&attributes, "TANGENT", "VEC4")?,
            false => (None, None),
        };
        let (colors_key, colors) = match wish.colors {
            true => open(&attributes, COLORS, color_type(&attributes)?)?,
            false => (None, None),
        };
        if indices.as_ref().is_some_and(|indices| !indices.holds_indices()) {
            return Err(entry.error("the indices are not whole numbers without a sign", "export the scene again"));
        }
        for other in [&normals, &coordinates, &tangents, &colors].into_iter().flatten() {
            if other.count() != positions.count() {
                let problem = format!("{} positions, but {} of another attribute", positions.count(), other.count());
                return Err(attributes.error(problem, "export the scene again"));
            }
        }
        let keys = [indices_key, positions_key, normals_key, coordinates_key, tangents_key, colors_key];
        let entry = entry.clone();
        Ok(Some(Self { entry, mode, keys, indices, positions, normals, coordinates, tangents, colors }))
    }

    /// The vertices of all triangles, in range.
    fn triangles(&self) -> Result<Vec<[u32; 3]>, SceneError> {
        let count = self.indices.as_ref().map_or(self.positions.count(), Accessor::count);
        let corner = |position: usize| self.indices.as_ref().map_or(position as u32, |indices| indices.index(position));
        let vertices = self.positions.count();
        if let Some(bad) = (0..count).find(|position| corner(*position) as usize >= vertices) {
            let problem = format!("index {bad} is vertex {}, but there are {vertices}, counted from 0", corner(bad));
            let place = self.entry.get("indices").unwrap_or_else(|| self.entry.clone());
            return Err(place.error(problem, "export the scene again"));
        }
        if self.mode == TRIANGLES {
            if !count.is_multiple_of(3) {
                let problem = format!("{count} corners do not make triangles");
                return Err(self.entry.error(problem, "export the scene again"));
            }
            return Ok((0..count / 3).map(|triangle| [0, 1, 2].map(|side| corner(3 * triangle + side))).collect());
        }
        let fan = self.mode == FAN;
        let triangle = |index: usize| match (fan, index % 2) {
            (true, _) => [index + 1, index + 2, 0].map(corner),
            // Every other triangle of a strip is wound the other way.
            (false, 0) => [index, index + 1, index + 2].map(corner),
            (false, _) => [index + 1, index, index + 2].map(corner),
        };
        // Strips repeat corners to jump.
        let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        Ok((0..count.saturating_sub(2)).map(triangle).filter(has_area).collect())
    }

    /// The mesh of the vertices that `triangles` use, and its bounds.
    fn mesh(&self, triangles: &[[u32; 3]], output: &mut Output) -> Result<(TriangleMesh, [DVec3; 2]), SceneError> {
        // Some exporters let many primitives use parts of one long list of vertices.
        let mut vertices = Vec::new();
        let mut places: HashMap<u32, u32> = HashMap::new();
        let mut place = |vertex: u32| {
            *places.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            })
        };
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(&mut place)).collect();
        let mut mesh = TriangleMesh {
            positions: self.all(Some(&self.positions), &vertices, "POSITION")?,
            normals: self.all(self.normals.as_ref(), &vertices, "NORMAL")?,
            texture_coordinates: self.all(self.coordinates.as_ref(), &vertices, "TEXCOORD")?,
            tangents: self.all(self.tangents.as_ref(), &vertices, "TANGENT")?,
            triangles,
            attributes: self.colors(&vertices, output)?.into_iter().collect(),
            face_normals: false,
        };
        // Whatever is not negative is a right hand.
        mesh.tangents.iter_mut().for_each(|[.., sign]| *sign = if *sign < 0.0 { -1.0 } else { 1.0 });
        output.budget.take(mesh.size() as u64, &self.entry)?;
        let positions = mesh.positions.iter().map(|position| DVec3::from_array(position.map(f64::from)));
        let bounds = positions.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[least, most], position| {
            [least.min(position), most.max(position)]
        });
        Ok((mesh, bounds))
    }

    /// The colors of vertices, held to 0 to 1 as the format says; alpha does not count.
    fn colors(&self, vertices: &[u32], output: &mut Output) -> Result<Option<MeshValues>, SceneError> {
        let colors: Vec<[f32; 3]> = self.all(self.colors.as_ref(), vertices, COLORS)?;
        if colors.as_flattened().iter().any(|number| !(0.0..=1.0).contains(number)) {
            let explanation = "glTF holds them to that";
            output.notices.add(Notice::approximated(
                &self.entry.location(),
                "a vertex color beyond 0 to 1",
                explanation,
            ));
        }
        let numbers: Vec<f32> = colors.into_iter().flatten().map(|number| number.clamp(0.0, 1.0)).collect();
        Ok((!numbers.is_empty()).then(|| MeshValues { name: VERTEX_COLOR.to_owned(), channels: 3, numbers }))
    }

    /// Elements of an attribute in single precision; none without the attribute.
    fn all<const N: usize>(
        &self,
        accessor: Option<&Accessor<'_>>,
        vertices: &[u32],
        name: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let Some(accessor) = accessor else { return Ok(Vec::new()) };
        let mut elements = Vec::with_capacity(vertices.len());
        for vertex in vertices {
            let numbers = accessor.vector::<N>(*vertex as usize);
            if !numbers.iter().all(|number| number.is_finite()) {
                let attributes = self.entry.get("attributes");
                let place = attributes.and_then(|attributes| attributes.get(name));
                let place = place.unwrap_or_else(|| self.entry.clone());
                return Err(place.error(format!("{name} of vertex {vertex} is not finite"), "repair the mesh"));
            }
            elements.push(numbers.map(|number| number as f32));
        }
        Ok(elements)
    }
}

/// Whether the vertices of a primitive have colors.
///
/// # Errors
/// When its attributes are no object.
pub(super) fn has_colors(primitive: &Entry<'_>) -> Result<bool, SceneError> {
    Ok(primitive.child("attributes")?.is_some_and(|attributes| attributes.has(COLORS)))
}

/// The type of the colors of vertices, which may have an alpha.
fn color_type(attributes: &Entry<'_>) -> Result<&'static str, SceneError> {
    let given = attributes.reference(COLORS, "accessors")?.map(|(_, accessor)| accessor.text("type")).transpose()?;
    Ok(if given.flatten() == Some("VEC4") { "VEC4" } else { "VEC3" })
}

/// Tells of Draco, and refuses a primitive that is there in compressed form only. A file says that it requires Draco when
/// that is so, but some do not.
///
/// # Errors
/// Where the positions have no numbers beside the compressed ones.
fn check_compression(entry: &Entry<'_>, output: &mut Output) -> Result<(), SceneError> {
    const NAME: &str = "KHR_draco_mesh_compression";
    if entry.extension(NAME)?.is_none() {
        return Ok(());
    }
    let positions = entry.child("attributes")?.map(|attributes| attributes.reference("POSITION", "accessors"));
    let has_numbers = match positions.transpose()?.flatten() {
        Some((_, accessor)) => accessor.has("bufferView") || accessor.has("sparse"),
        None => false,
    };
    if !has_numbers {
        let problem = format!("the primitive is compressed with Draco ({NAME}), and has no numbers beside that");
        return Err(entry.error(problem, "export the scene without mesh compression"));
    }
    let explanation = "the numbers that stand in the file without compression are used";
    output.notices.add(Notice::ignored(&entry.location(), format!("extension \"{NAME}\""), explanation));
    Ok(())
}

/// Reports what a primitive has and a mesh does not hold.
fn report_unused(entry: &Entry<'_>, attributes: &Entry<'_>, output: &mut Output) {
    if attributes.has("COLOR_1") {
        let explanation = "the first ones count";
        output.notices.add(Notice::ignored(&entry.location(), "further vertex colors of a primitive", explanation));
    }
    if entry.has("targets") {
        let explanation = "the mesh has its shape without them";
        output.notices.add(Notice::ignored(&entry.location(), "the morph targets of a primitive", explanation));
    }
}
