//! Mitsuba's serialized meshes, versions 3 and 4: one file of many meshes, each compressed by itself, with their places at
//! the end.
//!
//! Positions, normals, texture coordinates and vertex colors (`vertex_color`) are read, in single or double precision. A
//! mesh that was saved with flat shading is shaded flat.

use std::io::{BufReader, ErrorKind, Read};

use flate2::read::ZlibDecoder;

use super::super::error::{Location, SceneError};
use super::triangle_mesh::{MeshValues, TriangleMesh};

const MAGIC: u16 = 0x041C;
const HEADER: usize = 4;

const HAS_NORMALS: u32 = 0x0001;
const HAS_TEXTURE_COORDINATES: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const DOUBLE_PRECISION: u32 = 0x2000;

/// How far a mesh may expand: this many bytes, and [`EXPANSION_RATIO`] bytes more for every byte of the file.
const EXPANSION_ALLOWANCE: u128 = 64 << 20;
/// See [`EXPANSION_ALLOWANCE`]. Coordinates that differ hardly compress.
const EXPANSION_RATIO: u128 = 200;
/// The most bytes of one mesh.
const MESH_LIMIT: u128 = 4 << 30;
/// The longest name of a mesh, bytes.
const NAME_LIMIT: usize = 4096;

const EXPORT_AGAIN: &str = "export the mesh again";
const COPY_AGAIN: &str = "the file is cut short or damaged: copy it again";

/// Reads mesh `index`, counted from 0. `location` names the mesh file and the shape that it belongs to.
///
/// # Errors
/// On files of another kind or version, an index beyond the file's meshes, data that end early or cannot be unpacked or
/// would expand suspiciously far, vertex indices out of range, and coordinates that are not finite. Also when there is no
/// triangle.
pub fn read(bytes: &[u8], index: usize, location: &Location) -> Result<TriangleMesh, SceneError> {
    let version = version_at(bytes, 0, location)?;
    let start = start_of(bytes, index, version, location)?;
    let version = version_at(bytes, start, location)?;
    let decoder = ZlibDecoder::new(&bytes[start + HEADER..]);
    let mut reader = Reader { stream: BufReader::with_capacity(1 << 16, decoder), double: false, location };
    let flags = u32::from_le_bytes(reader.take()?);
    if version == 4 {
        reader.skip_name()?;
    }
    reader.double = flags & DOUBLE_PRECISION != 0;
    reader.mesh(flags, bytes.len())
}

fn version_at(bytes: &[u8], start: usize, location: &Location) -> Result<u16, SceneError> {
    let number = |at: usize| bytes.get(start + at..)?.first_chunk().map(|pair| u16::from_le_bytes(*pair));
    match (number(0), number(2)) {
        (Some(MAGIC), Some(version @ 3..=4)) => Ok(version),
        (Some(MAGIC), Some(version)) => {
            let problem = format!("the serialized mesh is of version {version}");
            Err(SceneError::new(location, problem, "versions 3 and 4 can be read; export it as PLY"))
        }
        _ if start == 0 => Err(SceneError::new(location, "this is not a file of serialized meshes", EXPORT_AGAIN)),
        _ => Err(SceneError::new(location, format!("no mesh begins at byte {start}"), COPY_AGAIN)),
    }
}

/// The first byte of mesh `index`, from the list at the end of the file: the offsets of all meshes and their number.
fn start_of(bytes: &[u8], index: usize, version: u16, location: &Location) -> Result<usize, SceneError> {
    if index == 0 {
        return Ok(0);
    }
    let damaged = || SceneError::new(location, "the list of the file's meshes is damaged", COPY_AGAIN);
    let (rest, count) = bytes.split_last_chunk().ok_or_else(damaged)?;
    let count = u32::from_le_bytes(*count) as usize;
    let size = if version == 4 { 8 } else { 4 };
    let length = count.checked_mul(size).filter(|length| *length <= rest.len()).ok_or_else(damaged)?;
    if index >= count {
        let meshes = if count == 1 { "mesh" } else { "meshes" };
        let problem = format!("there is no mesh {index}: the file holds {count} {meshes}, counted from 0");
        return Err(SceneError::new(location, problem, "check shape_index"));
    }
    let (_, list) = rest.split_at(rest.len() - length);
    let entry = &list[index * size..(index + 1) * size];
    let offset = entry.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
    usize::try_from(offset).ok().filter(|offset| *offset < bytes.len()).ok_or_else(damaged)
}

struct Reader<'a> {
    stream: BufReader<ZlibDecoder<&'a [u8]>>,
    /// Whether numbers are of double precision.
    double: bool,
    location: &'a Location,
}

impl Reader<'_> {
    fn mesh(&mut self, flags: u32, file_size: usize) -> Result<TriangleMesh, SceneError> {
        let counts = [u64::from_le_bytes(self.take()?), u64::from_le_bytes(self.take()?)];
        let [vertices, triangles] = self.checked_counts(counts, flags, file_size)?;
        let mut mesh = TriangleMesh { face_normals: flags & FACE_NORMALS != 0, ..TriangleMesh::default() };
        mesh.positions = self.finite_vectors(vertices, "position")?;
        if flags & HAS_NORMALS != 0 {
            // Normals that are not finite are replaced later: Mitsuba saves such for vertices without area around.
            mesh.normals = self.vectors(vertices)?;
        }
        if flags & HAS_TEXTURE_COORDINATES != 0 {
            mesh.texture_coordinates = self.finite_vectors(vertices, "texture coordinate")?;
        }
        if flags & HAS_COLORS != 0 {
            let colors: Vec<[f32; 3]> = self.finite_vectors(vertices, "color")?;
            let numbers = colors.into_iter().flatten().collect();
            mesh.attributes.push(MeshValues { name: "vertex_color".to_owned(), channels: 3, numbers });
        }
        mesh.triangles = self.triangles(triangles, vertices)?;
        Ok(mesh)
    }

    /// The counts of vertices and triangles, which the file can hold.
    fn checked_counts(&self, counts: [u64; 2], flags: u32, file_size: usize) -> Result<[usize; 2], SceneError> {
        let [vertices, triangles] = counts;
        if vertices == 0 || triangles == 0 {
            return Err(self.error("the mesh has no triangles", "export it with its triangles"));
        }
        let optional = [(HAS_NORMALS, 3), (HAS_TEXTURE_COORDINATES, 2), (HAS_COLORS, 3)];
        let numbers: u128 =
            3 + optional.map(|(flag, count)| if flags & flag != 0 { count } else { 0 }).iter().sum::<u128>();
        let vertex_size = numbers * if self.double { 8 } else { 4 };
        let size = u128::from(vertices) * vertex_size + u128::from(triangles) * 12;
        let limit = (EXPANSION_ALLOWANCE + EXPANSION_RATIO * file_size as u128).min(MESH_LIMIT);
        if size > limit || vertices > u64::from(u32::MAX) {
            let problem = format!(
                "the mesh promises {vertices} vertices and {triangles} triangles, which is too much for a file of \
                {file_size} bytes"
            );
            return Err(self.error(&problem, COPY_AGAIN));
        }
        Ok([vertices as usize, triangles as usize])
    }

    fn triangles(&mut self, count: usize, vertices: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let mut triangles = Vec::with_capacity(count);
        for triangle in 0..count {
            let mut indices = [0; 3];
            for index in &mut indices {
                *index = u32::from_le_bytes(self.take()?);
                if *index as usize >= vertices {
                    let problem = format!(
                        "triangle {triangle} refers to vertex {index}, but there are {vertices}, counted from 0"
                    );
                    return Err(self.error(&problem, "repair the mesh"));
                }
            }
            triangles.push(indices);
        }
        Ok(triangles)
    }

    fn finite_vectors<const N: usize>(&mut self, count: usize, what: &str) -> Result<Vec<[f32; N]>, SceneError> {
        let vectors = self.vectors(count)?;
        match vectors.iter().position(|vector: &[f32; N]| vector.iter().any(|number| !number.is_finite())) {
            None => Ok(vectors),
            Some(vertex) => Err(self.error(&format!("the {what} of vertex {vertex} is not finite"), "repair the mesh")),
        }
    }

    fn vectors<const N: usize>(&mut self, count: usize) -> Result<Vec<[f32; N]>, SceneError> {
        let mut vectors = Vec::with_capacity(count);
        for _ in 0..count {
            vectors.push(self.vector()?);
        }
        Ok(vectors)
    }

    fn vector<const N: usize>(&mut self) -> Result<[f32; N], SceneError> {
        let mut vector = [0.0; N];
        for number in &mut vector {
            *number =
                if self.double { f64::from_le_bytes(self.take()?) as f32 } else { f32::from_le_bytes(self.take()?) };
        }
        Ok(vector)
    }

    fn skip_name(&mut self) -> Result<(), SceneError> {
        for _ in 0..NAME_LIMIT {
            if self.take()? == [0] {
                return Ok(());
            }
        }
        Err(self.error("the mesh's name does not end", COPY_AGAIN))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        let mut bytes = [0; N];
        match self.stream.read_exact(&mut bytes) {
            Ok(()) => Ok(bytes),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                Err(self.error("the mesh ends too early", COPY_AGAIN))
            }
            Err(error) => Err(self.error(&format!("the mesh cannot be unpacked: {error}"), COPY_AGAIN)),
        }
    }

    fn error(&self, problem: &str, remedy: &str) -> SceneError {
        SceneError::new(self.location, problem, remedy)
    }
}
