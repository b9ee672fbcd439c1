//! Attributes of an EXR header: those that OpenEXR names, and photonfarm's own, in an order that is always the same.
//!
//! The header is a function of the job: no time of writing is in it, so that the same picture gives the same bytes.

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{LayerAttributes, Vec2};
use time::OffsetDateTime;

use super::{MatteHeader, PictureFileError, PictureMetadata};

/// The attribute that counts a picture's passes.
pub(super) const PASSES: &str = "photonfarm.passes";
/// The attribute that holds its scene's hash.
pub(super) const SCENE: &str = "photonfarm.scene";

/// The primaries and the white of all pictures (ITU-R BT.709).
pub(super) const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

/// The attributes that say where a picture comes from.
pub(super) fn attributes(metadata: &PictureMetadata) -> LayerAttributes {
    let capture_date = metadata.submitted.and_then(date_and_time);
    LayerAttributes {
        software_name: Some(concat!("photonfarm ", env!("CARGO_PKG_VERSION")).into()),
        owner: metadata.owner.as_deref().map(text),
        comments: comment(metadata).as_deref().map(text),
        // The date is one of Greenwich.
        utc_offset: capture_date.is_some().then_some(0.0),
        capture_date,
        world_to_camera: metadata.world_to_camera,
        world_to_normalized_device: metadata.world_to_ndc,
        other: own_attributes(metadata).into_iter().collect(),
        ..LayerAttributes::default()
    }
}

/// What people read of a picture first.
fn comment(metadata: &PictureMetadata) -> Option<String> {
    let PictureMetadata { name, method, passes, .. } = metadata;
    if method.is_empty() {
        return name.clone();
    }
    let plural = if *passes == 1 { "" } else { "es" };
    let name = name.as_ref().map_or(String::new(), |name| format!("{name}: "));
    Some(format!("{name}{passes} pass{plural} of {method}, radiance in W/(sr*m^2)"))
}

/// Seconds since 1970 as OpenEXR writes times; `None` for years that have more than four digits.
fn date_and_time(seconds: u64) -> Option<Text> {
    let time = OffsetDateTime::from_unix_timestamp(i64::try_from(seconds).ok()?).ok()?;
    let (year, month, day) = time.to_calendar_date();
    let (hour, minute, second) = time.to_hms();
    let month = u8::from(month);
    (year <= 9999).then(|| text(&format!("{year:04}:{month:02}:{day:02} {hour:02}:{minute:02}:{second:02}")))
}

/// The attributes that OpenEXR does not name. Counts that may not fit into EXR's 32-bit integers are text.
fn own_attributes(metadata: &PictureMetadata) -> Vec<(Text, AttributeValue)> {
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
    let own = texts.map(|(name, value)| (text(name), AttributeValue::Text(text(&value))));
    own.into_iter().chain(metadata.mattes.iter().flat_map(matte_attributes)).collect()
}

/// Names stand in UTF-8 in a manifest, as the specification has it.
fn matte_attributes(matte: &MatteHeader) -> [(Text, AttributeValue); 4] {
    let exact = |value: &str| Text::from_slice_unchecked(value.as_bytes());
    matte.attributes().map(|(name, value)| (exact(&name), AttributeValue::Text(exact(&value))))
}

fn text(value: &str) -> Text {
    Text::from_slice_unchecked(ascii(value).as_bytes())
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
