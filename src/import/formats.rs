//! The formats of scene files: one table, and how a file's beginning says which it has.

use super::{ceng795, changes, gltf, mgf, pbrt};
use crate::scene::bundle::{scene_in_comment, without_byte_order_mark};
use crate::scene::error::{Location, SceneError};

/// One format that a scene file may have.
#[derive(Clone, Copy, Debug)]
pub struct SceneFormat {
    /// What people call it.
    pub name: &'static str,
    /// How the names of its files end.
    pub extension: &'static str,
    /// What the scene file of an archive may be called whatever stands beside it.
    pub standard_name: &'static str,
    pub(super) format: Format,
}

/// What a scene file may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Xml,
    Ceng795,
    Json,
    Gltf,
    Glb,
    Mgf,
    Pbrt,
    /// An archive with a scene of one of the others.
    Zip,
}

const fn row(format: Format, name: &'static str, extension: &'static str, standard_name: &'static str) -> SceneFormat {
    SceneFormat { name, extension, standard_name, format }
}

/// All formats but archives.
pub const FORMATS: &[SceneFormat] = &[
    row(Format::Xml, "Mitsuba XML of any version", "xml", "scene.xml"),
    row(Format::Json, "Mitsuba 3 JSON", "json", "scene.json"),
    row(Format::Gltf, "glTF", "gltf", "scene.gltf"),
    row(Format::Glb, "GLB", "glb", "scene.glb"),
    row(Format::Mgf, "MGF", "mgf", "scene.mgf"),
    row(Format::Pbrt, "pbrt", "pbrt", "scene.pbrt"),
    row(Format::Ceng795, "CENG 795 XML", "xml", "scene.xml"),
];

/// What a scene may be, as help and errors tell it.
pub fn told() -> String {
    let names: Vec<&str> = FORMATS.iter().map(|row| row.name).collect();
    format!("{}, or a zip archive with everything it refers to", names.join(", "))
}

/// Tells the format by how the file begins.
pub(super) fn format(bytes: &[u8], location: &Location) -> Result<Format, SceneError> {
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        return Ok(Format::Zip);
    }
    if bytes.starts_with(gltf::MAGIC) {
        return Ok(Format::Glb);
    }
    let text = without_byte_order_mark(bytes);
    match text.trim_ascii_start().first() {
        Some(b'<') if ceng795::is_ceng795(text) => Ok(Format::Ceng795),
        Some(b'<') => Ok(Format::Xml),
        Some(b'{') if gltf::is_gltf(text) => Ok(Format::Gltf),
        Some(b'{') => Ok(Format::Json),
        None => Err(SceneError::new(location, "the scene file is empty", format!("give {}", told()))),
        Some(_) if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") => {
            Err(SceneError::new(location, "the scene file is UTF-16 text", "save it as UTF-8"))
        }
        Some(_) if mgf::is_mgf(text, &location.file) => Ok(Format::Mgf),
        Some(_) if pbrt::is_pbrt(text, &location.file) => Ok(Format::Pbrt),
        Some(_) => {
            let problem = "this is in none of the formats that are read";
            Err(SceneError::new(location, problem, format!("give {}", told())))
        }
    }
}

/// What a scene file is called in an archive that has others.
pub(super) fn standard_name(format: Format) -> &'static str {
    let row = FORMATS.iter().find(|row| row.format == format);
    row.map_or("scene.zip", |row| row.standard_name)
}

/// What the scene file of an archive may be called whatever stands beside it.
pub(super) fn standard_names() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().map(|row| row.standard_name)
}

/// The scene file of an archive with files of these names: the one that its comment names, else [`scene_file`].
///
/// # Errors
/// Why there is none.
pub fn scene_in_archive<'a>(archive: &[u8], names: impl Iterator<Item = &'a str> + Clone) -> Result<String, String> {
    match scene_in_comment(archive) {
        Some(scene) if names.clone().any(|name| name == scene) => Ok(scene),
        _ => scene_file(names).map_err(|what| format!("the archive has {what}")),
    }
}

/// The scene file among the names in an archive or a folder: the one with a format's standard name, or else the only one at the top level with one
/// of the formats' extensions.
///
/// # Errors
/// What there is instead.
pub fn scene_file<'a>(names: impl Iterator<Item = &'a str> + Clone) -> Result<String, String> {
    let top: Vec<&str> = names.filter(|name| !name.contains('/') && *name != changes::FILE).collect();
    let is_scene = |name: &&str| {
        let extension = name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
        FORMATS.iter().any(|row| extension.as_deref() == Some(row.extension))
    };
    let is_standard = |name: &&str| standard_names().any(|standard| standard == *name);
    let preferred: Vec<&str> = top.iter().copied().filter(is_standard).collect();
    let candidates = if preferred.is_empty() { top.into_iter().filter(is_scene).collect() } else { preferred };
    match candidates.as_slice() {
        [scene] => Ok((*scene).to_owned()),
        [] => Err("no scene file at its top level".to_owned()),
        several => Err(format!("several scene files at its top level: {}", several[..2].join(", "))),
    }
}
