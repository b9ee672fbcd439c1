//! Wavefront OBJ meshes.
//!
//! Positions (`v`), texture coordinates (`vt`), normals (`vn`) and faces (`f`) are read; a `\` at the end of a line continues
//! it. Groups, materials, smoothing, lines and points are passed over, and so is every other statement, which is told. A corner
//! without texture coordinates gets (0, 0) if others have some, one without a normal gets that of its triangle.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

use super::super::bundle::without_byte_order_mark;
use super::super::error::{Location, SceneError};
use super::triangle_mesh::TriangleMesh;

/// Statements that every mesh may have and that say nothing about the surface.
const PASSED_OVER: [&[u8]; 8] = [b"mtllib", b"g", b"o", b"s", b"l", b"p", b"vp", b"usemap"];
/// How many statements that were passed over are named.
const MOST_NAMED: usize = 12;

/// What of a file is a mesh.
pub struct ObjMesh {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// Statements that were passed over and may have meant something, one sentence; empty without any.
    pub notice: Option<String>,
}

/// Reads the mesh of an OBJ file, or of it the faces that come after `usemtl` and the name of `material`. `location` names the
/// mesh file and the shape that it belongs to.
///
/// # Errors
/// With the line: on numbers that cannot be read, indices out of range, coordinates that are not finite. Also when there is no
/// face.
pub fn read(bytes: &[u8], material: Option<&str>, location: &Location) -> Result<ObjMesh, SceneError> {
    // Faces before any `usemtl` have the empty name.
    let skips = material.is_some_and(|name| !name.is_empty());
    let mut reader = Reader { wanted: material.map(str::to_owned), skips, ..Reader::default() };
    for (index, line) in lines(bytes) {
        reader.line(&line).map_err(|(problem, remedy)| {
            let place = Location { line: u32::try_from(index).unwrap_or(u32::MAX), ..location.clone() };
            SceneError::new(&place, problem, remedy)
        })?;
    }
    if reader.mesh.triangles.is_empty() {
        return Err(SceneError::new(location, "the mesh has no faces", "export it with its faces"));
    }
    Ok(reader.finish())
}

/// The statements of a file, each with the number of its first line, counted from 1.
pub fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, [u8]>)> {
    let bytes = without_byte_order_mark(bytes);
    let mut physical =
        bytes.split(|byte| *byte == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line)).enumerate();
    std::iter::from_fn(move || {
        let (index, line) = physical.next()?;
        let mut line = Cow::Borrowed(line);
        while let Some(begun) = line.strip_suffix(b"\\") {
            let mut joined = begun.to_vec();
            joined.push(b' ');
            let Some((_, next)) = physical.next() else { return Some((index + 1, Cow::Owned(joined))) };
            joined.extend_from_slice(next);
            line = Cow::Owned(joined);
        }
        Some((index + 1, line))
    })
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
    any_normal: bool,
    any_texture_coordinate: bool,
    polygon: Vec<u32>,
    /// The material whose faces are wanted; all are when there is none.
    wanted: Option<String>,
    /// Whether faces are of another material.
    skips: bool,
    /// Statements that were passed over and may have meant something.
    passed_over: BTreeSet<String>,
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
            Some(b"f" | b"fo") if self.skips => {}
            Some(b"f" | b"fo") => self.face(words)?,
            Some(b"usemtl") => {
                let name = material_name(line);
                self.skips = self.wanted.as_ref().is_some_and(|wanted| *wanted != name);
            }
            Some(comment) if comment.starts_with(b"#") => {}
            Some(keyword) if PASSED_OVER.contains(&keyword) => {}
            Some(keyword) => self.pass_over(&shown(keyword)),
        }
        Ok(())
    }

    fn pass_over(&mut self, statement: &str) {
        if self.passed_over.len() < MOST_NAMED {
            self.passed_over.insert(format!("\"{statement}\""));
        }
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), Refusal> {
        self.polygon.clear();
        for word in words.take_while(|word| !word.starts_with(b"#")) {
            let corner = self.corner(word)?;
            let vertex = self.vertex(corner)?;
            self.polygon.push(vertex);
        }
        if self.polygon.len() < 3 {
            self.pass_over("f with fewer than three corners");
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
        let normal = corner.normal.map(|index| self.normals[index as usize]);
        self.any_normal |= normal.is_some();
        // Where there is none, or it is zero, the triangle's counts.
        self.mesh.normals.push(normal.unwrap_or_default());
        Ok(vertex)
    }

    fn finish(mut self) -> ObjMesh {
        if !self.any_texture_coordinate {
            self.mesh.texture_coordinates = Vec::new();
        }
        if !self.any_normal {
            self.mesh.normals = Vec::new();
        }
        let named: Vec<String> = self.passed_over.into_iter().collect();
        let notice =
            (!named.is_empty()).then(|| format!("statements without polygons are passed over: {}", named.join(", ")));
        ObjMesh { mesh: self.mesh, notice }
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
        let parsed = std::str::from_utf8(word).ok().and_then(parsed);
        *number = parsed.ok_or_else(|| (format!("\"{}\" is not a number", shown(word)), "export the mesh again"))?;
        if !number.is_finite() {
            return Err((format!("the coordinate \"{}\" is not finite", shown(word)), "repair the mesh"));
        }
    }
    Ok(numbers)
}

/// A number, also with its exponent written as in `3.1+e2`.
fn parsed(text: &str) -> Option<f32> {
    let swapped = || {
        let (number, exponent) = ["+e", "-e", "+E", "-E"].iter().find_map(|sign| {
            let at = text.find(sign)?;
            Some((&text[..at], format!("{}{}", &sign[..1], &text[at + sign.len()..])))
        })?;
        format!("{number}e{exponent}").parse().ok()
    };
    text.parse().ok().or_else(swapped)
}

/// The name of the material that a statement `usemtl` or `newmtl` gives, which may have spaces.
pub fn material_name(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line);
    let rest = text.trim_start().split_once(char::is_whitespace).map_or("", |(_, rest)| rest);
    rest.trim().to_owned()
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
