//! What a `uri` of a buffer or image names: a file beside the scene, or the content itself.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::GENERATED_FOLDER;
use super::entry::Entry;
use crate::scene::bundle::checked_name;
use crate::scene::error::SceneError;

/// Some exporters leave the padding out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// What a URI names.
pub(super) enum Uri<'a> {
    /// A file of the scene's bundle.
    File(String),
    /// Content in base64.
    Data(&'a str),
}

/// Reads the `uri` of a buffer or image; nothing when it has none.
///
/// # Errors
/// On other schemes than `data:`, on names that lead out of the scene's folder, on broken percent escapes.
pub(super) fn read<'a>(owner: &Entry<'a>) -> Result<Option<Uri<'a>>, SceneError> {
    let (Some(text), Some(entry)) = (owner.text("uri")?, owner.get("uri")) else { return Ok(None) };
    if let Some(data) = text.strip_prefix("data:") {
        return match data.split_once(";base64,") {
            Some((_, content)) => Ok(Some(Uri::Data(content))),
            None => Err(entry.error("the data: URI is not in base64", "export the scene with files of their own")),
        };
    }
    if text.split('/').next().is_some_and(|start| start.contains(':')) {
        let remedy = "put the file into the folder of the scene and name it relative to that";
        return Err(entry.error("the URI names something outside of the scene's folder", remedy));
    }
    let name = without_escapes(text)
        .ok_or_else(|| entry.error("the URI has a broken percent escape", "write % as %25, and names as UTF-8"))?;
    let name = checked_name(&name, &entry.location())?;
    if name.starts_with(GENERATED_FOLDER) {
        let problem = format!("the folder name \"{GENERATED_FOLDER}\" is taken by meshes that the import makes");
        return Err(entry.error(problem, "give the folder another name"));
    }
    Ok(Some(Uri::File(name)))
}

/// How many bytes `text` in base64 stands for, or a few more.
pub(super) fn decoded_size(text: &str) -> u64 {
    text.len() as u64 / 4 * 3 + 3
}

/// The bytes that `text` in base64 stands for.
///
/// # Errors
/// At the `uri` of `owner`, when the text is not base64.
pub(super) fn decode(text: &str, owner: &Entry<'_>) -> Result<Vec<u8>, SceneError> {
    BASE64.decode(text).map_err(|error| {
        let entry = owner.get("uri").unwrap_or_else(|| owner.clone());
        let reason = error.to_string();
        let problem = format!("the base64 content cannot be read: {}", reason.trim_end_matches('.'));
        entry.error(problem, "export the scene again")
    })
}

/// `text` with every `%20` and so on replaced by the byte it stands for.
fn without_escapes(text: &str) -> Option<String> {
    let mut parts = text.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2).filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()))?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).ok()
}
