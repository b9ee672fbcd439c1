//! GLB: one file that holds the JSON and the first buffer.

use crate::scene::error::{Location, SceneError};

/// What a GLB file begins with.
pub(in super::super) const MAGIC: &[u8] = b"glTF";

/// What the beginning of a chunk is a multiple of, bytes.
const ALIGNMENT: usize = 4;

const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// The JSON of a `.gltf` or `.glb` file, and the binary chunk of a `.glb`.
///
/// # Errors
/// On a GLB of another version than 2, on one that ends before its chunks do, and on one without JSON.
pub(super) fn split<'a>(bytes: &'a [u8], location: &Location) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let truncated = || SceneError::new(location, "the GLB file is cut off", "copy or export it again");
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes).ok_or_else(truncated)
    };
    let version = word(4)?;
    if version != 2 {
        return Err(SceneError::new(location, format!("the GLB file has version {version}"), "export it as glTF 2.0"));
    }
    // The padding of the last chunk counts, and is left out by some writers.
    let content = match bytes.get(..word(8)? as usize) {
        Some(content) => content,
        None if word(8)? as usize - bytes.len() < ALIGNMENT => bytes,
        None => return Err(truncated()),
    };
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < content.len() {
        let (length, kind) = (word(at)? as usize, word(at + 4)?);
        let rest = content.get(at + 8..).unwrap_or_default();
        let missing = length.saturating_sub(rest.len());
        let chunk = if missing < ALIGNMENT { &rest[..length - missing] } else { return Err(truncated()) };
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(chunk),
            BINARY_CHUNK if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        // Chunks begin at multiples of four bytes; old versions of trimesh let them follow each other without a gap.
        let end = at + 8 + length;
        let follows = |at: usize| content.get(at + 4..at + 8) == Some(b"BIN\0".as_slice());
        let padded = end.next_multiple_of(ALIGNMENT);
        at = if follows(end) && !follows(padded) { end } else { padded };
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err(SceneError::new(location, "the GLB file has no JSON chunk", "export it again")),
    }
}
