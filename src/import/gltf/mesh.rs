//! Mesh primitives become PLY files.

use std::collections::HashMap;

use glam::DVec3;

use super::accessor::Accessor;
use super::entry::Entry;
use super::{GENERATED_FOLDER, Input, Output, extensions};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// A primitive as a file of the bundle.
#[derive(Clone)]
pub(super) struct MeshFile {
    pub name: String,
    /// Whether the primitive has no normals; glTF then wants flat triangles.
    pub flat: bool,
    /// Least and greatest coordinates in the mesh's own space.
    pub bounds: [DVec3; 2],
}

/// What makes two primitives the same file: mode, indices, positions, normals, texture coordinates.
type Key = (usize, Option<usize>, usize, Option<usize>, Option<usize>);

/// The files of all primitives so far.
#[derive(Default)]
pub(super) struct MeshFiles {
    files: HashMap<Key, Option<MeshFile>>,
}

impl MeshFiles {
    /// The file of a primitive with the texture coordinates `set`; nothing when it has no triangles.
    ///
    /// # Errors
    /// On accessors that lead out of their buffers, indices out of range, numbers that are not finite.
    pub(super) fn file<'a>(
        &mut self,
        primitive: &Entry<'a>,
        set: usize,
        input: &Input<'a>,
        output: &mut Output,
    ) -> Result<Option<MeshFile>, SceneError> {
        let Some(source) = Primitive::open(primitive, set, input, output)? else { return Ok(None) };
        let key = (source.mode, source.keys[0], source.keys[1].unwrap_or(0), source.keys[2], source.keys[3]);
        if let Some(known) = self.files.get(&key) {
            return Ok(known.clone());
        }
        let triangles = source.triangles()?;
        let file = if triangles.is_empty() {
            output.notices.add(Notice::ignored(&primitive.location(), "a primitive without triangles", ""));
            None
        } else {
            let name = format!("{GENERATED_FOLDER}mesh_{}.ply", self.files.len());
            let (bytes, bounds) = source.ply(&triangles, output)?;
            output.generated.insert(name.clone(), bytes.into());
            Some(MeshFile { name, flat: source.normals.is_none(), bounds })
        };
        self.files.insert(key, file.clone());
        Ok(file)
    }
}

/// The opened accessors of a primitive.
struct Primitive<'a> {
    entry: Entry<'a>,
    mode: usize,
    /// Indices of the accessors of: indices, positions, normals, texture coordinates.
    keys: [Option<usize>; 4],
    indices: Option<Accessor<'a>>,
    positions: Accessor<'a>,
    normals: Option<Accessor<'a>>,
    coordinates: Option<Accessor<'a>>,
}

// Mode 5, between them, is the strip.
const TRIANGLES: usize = 4;
const FAN: usize = 6;

impl<'a> Primitive<'a> {
    /// Opens the accessors; nothing for points, lines, and primitives without positions.
    fn open(entry: &Entry<'a>, set: usize, input: &Input<'a>, output: &mut Output) -> Result<Option<Self>, SceneError> {
        extensions::report_unread(entry, output)?;
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
        let (coordinates_key, coordinates) = open(&attributes, &format!("TEXCOORD_{set}"), "VEC2")?;
        if indices.as_ref().is_some_and(|indices| !indices.holds_indices()) {
            return Err(entry.error("the indices are not whole numbers without a sign", "export the scene again"));
        }
        for other in [&normals, &coordinates].into_iter().flatten() {
            if other.count() != positions.count() {
                let problem = format!("{} positions, but {} of another attribute", positions.count(), other.count());
                return Err(attributes.error(problem, "export the scene again"));
            }
        }
        let keys = [indices_key, positions_key, normals_key, coordinates_key];
        Ok(Some(Self { entry: entry.clone(), mode, keys, indices, positions, normals, coordinates }))
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

    /// A binary PLY of the vertices that `triangles` use, and its bounds.
    fn ply(&self, triangles: &[[u32; 3]], output: &mut Output) -> Result<(Vec<u8>, [DVec3; 2]), SceneError> {
        // Some exporters let many primitives use parts of one long list of vertices.
        let mut vertices = Vec::new();
        let mut places: HashMap<u32, u32> = HashMap::new();
        let mut place = |vertex: u32| {
            *places.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            })
        };
        let faces: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(&mut place)).collect();
        let optional = [("nx ny nz", self.normals.is_some()), ("u v", self.coordinates.is_some())];
        let components = optional.iter().filter(|(_, given)| *given).map(|(names, _)| *names);
        let names: Vec<&str> = ["x y z"].into_iter().chain(components).flat_map(|names| names.split(' ')).collect();
        output.budget.take((vertices.len() * names.len() * 4 + faces.len() * 13) as u64, &self.entry)?;
        let mut bytes = header(vertices.len(), &names, faces.len()).into_bytes();
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for vertex in &vertices {
            let position = DVec3::from_array(self.write(&self.positions, *vertex, "POSITION", &mut bytes)?);
            bounds = [bounds[0].min(position), bounds[1].max(position)];
            if let Some(normals) = &self.normals {
                self.write::<3>(normals, *vertex, "NORMAL", &mut bytes)?;
            }
            if let Some(coordinates) = &self.coordinates {
                self.write::<2>(coordinates, *vertex, "TEXCOORD", &mut bytes)?;
            }
        }
        for corners in faces {
            bytes.push(3);
            bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
        }
        Ok((bytes, bounds))
    }

    /// Appends an element of an attribute in single precision.
    fn write<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        vertex: u32,
        name: &str,
        bytes: &mut Vec<u8>,
    ) -> Result<[f64; N], SceneError> {
        let numbers = accessor.vector::<N>(vertex as usize);
        if numbers.iter().all(|number| number.is_finite()) {
            bytes.extend(numbers.iter().flat_map(|number| (*number as f32).to_le_bytes()));
            return Ok(numbers);
        }
        let attributes = self.entry.get("attributes");
        let place = attributes.and_then(|attributes| attributes.get(name)).unwrap_or_else(|| self.entry.clone());
        Err(place.error(format!("{name} of vertex {vertex} is not finite"), "repair the mesh"))
    }
}

fn header(vertices: usize, names: &[&str], faces: usize) -> String {
    let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n{properties}element face {faces}\n\
        property list uchar uint vertex_indices\nend_header\n"
    )
}

/// Reports what a primitive has and a PLY file does not hold.
fn report_unused(entry: &Entry<'_>, attributes: &Entry<'_>, output: &mut Output) {
    if attributes.has("COLOR_0") {
        let explanation = "the material's own color is taken as it is";
        output.notices.add(Notice::ignored(&entry.location(), "the vertex colors of a primitive", explanation));
    }
    if entry.has("targets") {
        let explanation = "the mesh has its shape without them";
        output.notices.add(Notice::ignored(&entry.location(), "the morph targets of a primitive", explanation));
    }
}
