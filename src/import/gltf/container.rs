//! GLB: one file that holds the JSON and the first buffer.

use crate::scene::error::{Location, SceneError};

/// What a GLB file begins with.
pub(in super::super) const MAGIC: &[u8] = b"glTF";

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
    let content = bytes.get(..word(8)? as usize).ok_or_else(truncated)?;
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < content.len() {
        let (length, kind) = (word(at)? as usize, word(at + 4)?);
        let chunk = content.get(at + 8..).and_then(|rest| rest.get(..length)).ok_or_else(truncated)?;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(chunk),
            BINARY_CHUNK if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        // Chunks begin at multiples of four bytes.
        at += 8 + length.next_multiple_of(4);
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err(SceneError::new(location, "the GLB file has no JSON chunk", "export it again")),
    }
}
