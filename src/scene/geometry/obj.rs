//! Wavefront OBJ meshes.
//!
//! Positions (`v`), texture coordinates (`vt`), normals (`vn`) and faces (`f`) are read; groups, materials, smoothing,
//! lines and points are passed over. Normals must be given for all corners of all faces or for none. A corner without
//! texture coordinates gets (0, 0) if others have some.

use std::collections::HashMap;

use super::super::error::{Location, SceneError};
use super::triangle_mesh::TriangleMesh;

/// Statements that say nothing about the surface.
const PASSED_OVER: [&[u8]; 9] = [b"mtllib", b"usemtl", b"g", b"o", b"s", b"l", b"p", b"vp", b"usemap"];

/// Reads the mesh of an OBJ file. `location` names the mesh file and the shape that it belongs to.
///
/// # Errors
/// With the line: on statements and numbers that cannot be read, indices out of range, coordinates that are not finite,
/// and faces some of which have normals. Also when there is no face.
pub fn read(bytes: &[u8], location: &Location) -> Result<TriangleMesh, SceneError> {
    let mut reader = Reader::default();
    for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        reader.line(line).map_err(|(problem, remedy)| {
            let place = Location { line: u32::try_from(index + 1).unwrap_or(u32::MAX), ..location.clone() };
            SceneError::new(&place, problem, remedy)
        })?;
    }
    if reader.mesh.triangles.is_empty() {
        return Err(SceneError::new(location, "the mesh has no faces", "export it with its faces"));
    }
    Ok(reader.finish())
}

/// A problem and its remedy; the line is added by the caller.
type Refusal = (String, &'static str);

/// Positions in the file's lists of what makes one corner of a face.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    texture_coordinate: Option<u32>,
    normal: Option<u32>,
}

#[derive(Default)]
struct Reader {
    positions: Vec<[f32; 3]>,
    texture_coordinates: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// The vertex of the mesh for each combination that has been seen.
    vertices: HashMap<Corner, u32>,
    /// Whether faces have normals, by the first face's first corner.
    has_normals: Option<bool>,
    any_texture_coordinate: bool,
    polygon: Vec<u32>,
    mesh: TriangleMesh,
}

impl Reader {
    fn line(&mut self, line: &[u8]) -> Result<(), Refusal> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            None => {}
            Some(b"v") => self.positions.push(numbers::<3>(words, 3)?),
            Some(b"vn") => self.normals.push(numbers::<3>(words, 3)?),
            Some(b"vt") => self.texture_coordinates.push(numbers::<2>(words, 1)?),
            Some(b"f") => self.face(words)?,
            Some(comment) if comment.starts_with(b"#") => {}
            Some(keyword) if PASSED_OVER.contains(&keyword) => {}
            Some(keyword) => {
                let problem = format!("\"{}\" is not a statement of an OBJ mesh", shown(keyword));
                return Err((problem, "export the mesh as plain polygons"));
            }
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), Refusal> {
        self.polygon.clear();
        for word in words.take_while(|word| !word.starts_with(b"#")) {
            let corner = self.corner(word)?;
            let vertex = self.vertex(corner)?;
            self.polygon.push(vertex);
        }
        if self.polygon.len() < 3 {
            return Err((format!("a face with {} corners", self.polygon.len()), "a face needs at least three"));
        }
        self.mesh.push_polygon(&self.polygon);
        Ok(())
    }

    fn corner(&self, word: &[u8]) -> Result<Corner, Refusal> {
        let mut parts = word.split(|byte| *byte == b'/');
        let position = index(parts.next().unwrap_or_default(), self.positions.len(), word)?;
        let optional = |part: Option<&[u8]>, count| match part {
            None | Some(b"") => Ok(None),
            Some(part) => index(part, count, word).map(Some),
        };
        let texture_coordinate = optional(parts.next(), self.texture_coordinates.len())?;
        let normal = optional(parts.next(), self.normals.len())?;
        if parts.next().is_some() {
            return Err((format!("corner \"{}\" has too many parts", shown(word)), "write v, v/vt, v/vt/vn or v//vn"));
        }
        Ok(Corner { position, texture_coordinate, normal })
    }

    fn vertex(&mut self, corner: Corner) -> Result<u32, Refusal> {
        if *self.has_normals.get_or_insert(corner.normal.is_some()) != corner.normal.is_some() {
            let remedy = "export normals for all faces or for none";
            return Err(("some corners have normals and some have none".to_owned(), remedy));
        }
        if let Some(vertex) = self.vertices.get(&corner) {
            return Ok(*vertex);
        }
        let vertex = u32::try_from(self.mesh.positions.len())
            .map_err(|_| ("the mesh has more than 2^32 vertices".to_owned(), "split it"))?;
        self.vertices.insert(corner, vertex);
        self.mesh.positions.push(self.positions[corner.position as usize]);
        let coordinates = corner.texture_coordinate.map(|index| self.texture_coordinates[index as usize]);
        self.any_texture_coordinate |= coordinates.is_some();
        self.mesh.texture_coordinates.push(coordinates.unwrap_or_default());
        self.mesh.normals.extend(corner.normal.map(|index| self.normals[index as usize]));
        Ok(vertex)
    }

    fn finish(mut self) -> TriangleMesh {
        if !self.any_texture_coordinate {
            self.mesh.texture_coordinates = Vec::new();
        }
        self.mesh
    }
}

/// Up to `N` finite numbers, of which `required` must be there; more (weights, vertex colors) are passed over.
fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a [u8]>,
    required: usize,
) -> Result<[f32; N], Refusal> {
    let mut numbers = [0.0; N];
    for (position, number) in numbers.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            if position < required {
                return Err((format!("{position} numbers where {required} belong"), "export the mesh again"));
            }
            break;
        };
        let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f32>().ok());
        *number = parsed.ok_or_else(|| (format!("\"{}\" is not a number", shown(word)), "export the mesh again"))?;
        if !number.is_finite() {
            return Err((format!("the coordinate \"{}\" is not finite", shown(word)), "repair the mesh"));
        }
    }
    Ok(numbers)
}

/// A zero-based index from one that counts from 1, or backwards from -1.
fn index(part: &[u8], count: usize, word: &[u8]) -> Result<u32, Refusal> {
    let number = std::str::from_utf8(part).ok().and_then(|text| text.parse::<i64>().ok());
    let number = number
        .ok_or_else(|| (format!("corner \"{}\" is not made of indices", shown(word)), "export the mesh again"))?;
    let count = i64::try_from(count).unwrap_or(i64::MAX);
    let zero_based = if number < 0 { count.saturating_add(number) } else { number - 1 };
    match u32::try_from(zero_based) {
        Ok(index) if zero_based < count => Ok(index),
        _ => {
            let problem = format!("index {number} in \"{}\" is out of range: {count} are given so far", shown(word));
            Err((problem, "repair the mesh"))
        }
    }
}

fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned()
}
