//! Custom attributes of an EXR header, in an order that is always the same.

use exr::meta::attribute::{AttributeValue, Text};

use super::{PictureFileError, PictureMetadata};

/// The attribute that counts a picture's passes.
pub(super) const PASSES: &str = "photonfarm.passes";
/// The attribute that holds its scene's hash.
pub(super) const SCENE: &str = "photonfarm.scene";

/// The attributes that say where a picture comes from. Counts that may not fit into EXR's 32-bit integers are text.
pub(super) fn attributes(metadata: &PictureMetadata) -> Vec<(Text, AttributeValue)> {
    let parameters = serde_json::Value::Object(metadata.parameters.clone()).to_string();
    let texts = [
        ("photonfarm.job", metadata.job.clone()),
        ("photonfarm.method", metadata.method.clone()),
        ("photonfarm.parameters", parameters),
        (PASSES, metadata.passes.to_string()),
        ("photonfarm.photons_emitted", metadata.photons_emitted.to_string()),
        (SCENE, metadata.scene.clone()),
        ("photonfarm.seed", metadata.seed.to_string()),
        ("photonfarm.version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    let text = |value: &str| Text::from_slice_unchecked(ascii(value).as_bytes());
    texts.map(|(name, value)| (text(name), AttributeValue::Text(text(&value)))).to_vec()
}

/// EXR knows bytes only: whatever is not ASCII is written as JSON writes it, `\u` and four hexadecimal digits.
fn ascii(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut units = [0u16; 2];
    for character in text.chars() {
        if character.is_ascii() {
            escaped.push(character);
        } else {
            for unit in character.encode_utf16(&mut units) {
                escaped.push_str(&format!("\\u{unit:04x}"));
            }
        }
    }
    escaped
}

/// Sorts the attributes of a single-part EXR file by name. The `exr` crate keeps custom attributes in a hash map and
/// writes them in an order that differs from run to run; the header's length, hence all offsets, stay as they are.
pub(super) fn sort_attributes(file: &mut [u8]) -> Result<(), PictureFileError> {
    let broken = || PictureFileError::Encode { problem: "the EXR header has an unknown structure".to_owned() };
    const START: usize = 8; // magic number and version
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut position = START;
    while *file.get(position).ok_or_else(broken)? != 0 {
        let length = attribute_length(&file[position..]).ok_or_else(broken)?;
        attributes.push(file[position..position + length].to_vec());
        position += length;
    }
    attributes.sort();
    file[START..position].copy_from_slice(&attributes.concat());
    Ok(())
}

/// Length in bytes of the attribute at the start of `bytes`: name and type, each ended by 0, a 32-bit size, the value.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|byte| *byte == 0)? + 1;
    let kind = bytes[name..].iter().position(|byte| *byte == 0)? + 1;
    let size_at = name + kind;
    let size = i32::from_le_bytes(bytes.get(size_at..size_at + 4)?.try_into().ok()?);
    let length = size_at + 4 + usize::try_from(size).ok()?;
    (length <= bytes.len()).then_some(length)
}
