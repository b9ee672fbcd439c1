//! The bytes in which a scene travels over HTTP.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::Arc;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::formats::{format, scene_file, standard_name, standard_names};
use super::{ReadScene, Source, read_source};
use crate::scene::bundle::{Bundle, Files, SCENE_COMMENT, normalized_name, steps_up, without_common_folder};
use crate::scene::error::{Location, SceneError};

/// Reads the scene at `path` and every file it refers to, and gives the bytes that [`super::load_bytes`] reads.
///
/// A scene that refers to no file stays as it is; otherwise it becomes a zip archive, whose bytes depend on the files'
/// names and contents only. Files that a scene refers to are those it includes and every string parameter called
/// `filename`. Where some of them lie above the scene's folder, the archive holds the nearest folder that has them all, and
/// its comment names the scene file. `defines` are as in [`super::load_file`]: they may choose files, and are not packed themselves.
///
/// # Errors
/// As [`super::load_file`]; when a file is missing; when the scene's file name would be ambiguous in the archive.
pub fn pack(path: &Path, defines: &[(String, String)]) -> Result<Vec<u8>, SceneError> {
    let source = read_source(path)?;
    let original = || {
        std::fs::read(path).map_err(|error| {
            let location = Location { file: path.display().to_string(), ..Location::default() };
            SceneError::new(&location, format!("the file cannot be read: {error}"), "")
        })
    };
    pack_source(&source, defines, original)
}

/// [`pack`] of a scene that was read already.
///
/// # Errors
/// As [`pack`].
pub fn pack_read(scene: ReadScene<'_>, defines: &[(String, String)]) -> Result<Vec<u8>, SceneError> {
    let source = Source::read_in(scene.folder, scene.name, scene.bytes.into())?;
    pack_source(&source, defines, || Ok(scene.bytes.to_vec()))
}

/// `original` gives the bytes of a source that is an archive.
fn pack_source(
    source: &Source,
    defines: &[(String, String)],
    original: impl FnOnce() -> Result<Vec<u8>, SceneError>,
) -> Result<Vec<u8>, SceneError> {
    let imported = source.import(defines)?;
    let mut files = BTreeMap::new();
    for (name, location) in &imported.files {
        files.insert(normalized_name(name, location)?, source.bundle.read(name, location)?);
    }
    let Bundle::Folder(folder) = &source.bundle else {
        // An archive is what was asked for already, and all that it refers to is inside.
        return original();
    };
    if files.is_empty() {
        return Ok(source.text.to_vec());
    }
    let location = Location { file: source.name.clone(), ..Location::default() };
    let (files, comment) = match files.keys().map(|name| steps_up(name).0).max() {
        Some(0) | None => {
            files.insert(name_in_archive(source, &files, &location)?, source.text.clone());
            (files, String::new())
        }
        Some(above) => from_above(source, files, above, folder, &location)?,
    };
    write_zip(&files, &comment)
        .map_err(|error| SceneError::new(&location, format!("the scene cannot be packed: {error}"), "pack it by hand"))
}

/// The files by their names in the folder `above` steps over the scene's, with the scene; and the archive's comment.
fn from_above(
    source: &Source,
    files: Files,
    above: usize,
    folder: &Path,
    location: &Location,
) -> Result<(Files, String), SceneError> {
    let whole = folder.canonicalize().map_err(|error| {
        SceneError::new(location, format!("the scene's folder cannot be read: {error}"), "check its permissions")
    })?;
    let parents = whole.components().rev().take(above);
    let mut folders: Vec<String> =
        parents.map(|part| part.as_os_str().to_string_lossy().into_owned()).filter(|part| part != "/").collect();
    folders.reverse();
    if folders.len() < above {
        return Err(SceneError::new(location, "a file name leads above all folders", "give fewer \"..\""));
    }
    let is_hidden = |name: &&String| steps_up(name).1.split('/').any(|part| part.starts_with('.'));
    if let Some(name) = files.keys().filter(|name| steps_up(name).0 > 0).find(is_hidden) {
        // A scene from elsewhere must not carry off keys and settings.
        let problem = format!("the scene names \"{name}\", a hidden file above its folder");
        return Err(SceneError::new(location, problem, "copy it beside the scene, if it belongs to it"));
    }
    let renamed = files.into_iter().map(|(name, content)| (normalized(&folders, &name), content));
    let mut renamed: Files = renamed.collect();
    let mut scene = normalized(&folders, &source.name);
    renamed.insert(scene.clone(), source.text.clone());
    loop {
        let count = renamed.keys().map(String::len).sum::<usize>();
        renamed = without_common_folder(renamed);
        if renamed.keys().map(String::len).sum::<usize>() == count {
            break;
        }
        scene = scene.split_once('/').map_or(scene.clone(), |(_, inside)| inside.to_owned());
    }
    let comment = if scene.contains('/') { format!("{SCENE_COMMENT}{scene}") } else { String::new() };
    Ok((renamed, comment))
}

/// A normalised name that is seen from the folder `folders`, as seen from the top.
fn normalized(folders: &[String], name: &str) -> String {
    let (above, inside) = steps_up(name);
    let kept = folders.iter().take(folders.len() - above.min(folders.len())).map(String::as_str);
    kept.chain([inside]).collect::<Vec<_>>().join("/")
}

/// The scene file's own name if loading would find the scene under it, else `scene.xml` or `scene.json`.
fn name_in_archive(
    source: &Source,
    files: &BTreeMap<String, Arc<[u8]>>,
    location: &Location,
) -> Result<String, SceneError> {
    let standard = standard_name(format(&source.text, location)?);
    let found = |name: &&str| {
        let names = files.keys().map(String::as_str).chain([*name]);
        !files.contains_key(*name) && scene_file(names).is_ok_and(|scene| scene == *name)
    };
    let name = [source.name.as_str(), standard].into_iter().find(found).ok_or_else(|| {
        let problem = "another file that the scene refers to would be taken for the scene";
        SceneError::new(location, problem, format!("name the scene file {standard}, and no other file so"))
    })?;
    Ok(name.to_owned())
}

/// What scenes are called that came without a name of their own.
pub const UNNAMED: &str = "scene";

/// What a packed scene may be called in messages instead of its file's name.
pub fn packed_names() -> impl Iterator<Item = &'static str> {
    std::iter::once(UNNAMED).chain(standard_names())
}

/// A zip archive whose bytes depend on the files' names and contents only.
pub(super) fn write_zip(files: &BTreeMap<String, Arc<[u8]>>, comment: &str) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(name, options)?;
        archive.write_all(content)?;
    }
    if !comment.is_empty() {
        archive.set_comment(comment)?;
    }
    Ok(archive.finish()?.into_inner())
}
