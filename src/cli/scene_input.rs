//! The scene argument: a file, a folder with a scene file in it, or `-` for standard input.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::exit_code::CliError;
use crate::import::formats::told;
use crate::import::{ReadScene, scene_file};

/// What stands for standard input.
const STANDARD_INPUT: &str = "-";
/// What errors call a scene that came from there.
const ITS_NAME: &str = "standard input";

/// What the scene argument may be.
pub(super) fn scene_help() -> String {
    format!(
        "Scene: {}; a folder that holds one; or - for standard input, whose files are looked up in the current folder",
        told()
    )
}

/// A scene to read.
pub(super) enum SceneInput {
    /// A file that is there and can be opened.
    File(PathBuf),
    /// The bytes of standard input.
    Bytes(Vec<u8>),
}

impl SceneInput {
    /// Looks for the scene, and reads it where it can be read only once.
    pub(super) fn open(argument: &Path) -> Result<Self, CliError> {
        if is_standard_input(argument) {
            return read_standard_input().map(Self::Bytes);
        }
        let file = if argument.is_dir() { scene_of_folder(argument)? } else { argument.to_owned() };
        fs::File::open(&file).map_err(|error| unreadable(&file, &error))?;
        Ok(Self::File(file))
    }

    /// What was read of standard input, as importers take it.
    pub(super) fn read_scene(bytes: &[u8]) -> ReadScene<'_> {
        ReadScene { name: ITS_NAME, bytes, folder: Path::new(".") }
    }
}

/// Whether the scene comes from standard input.
pub(super) fn is_standard_input(argument: &Path) -> bool {
    argument.as_os_str() == STANDARD_INPUT
}

/// What messages call the scene.
pub(super) fn name_in_messages(argument: &Path) -> Option<String> {
    if is_standard_input(argument) {
        return Some(ITS_NAME.to_owned());
    }
    let found = if argument.is_dir() { scene_of_folder(argument).ok() } else { None };
    let file = found.as_deref().unwrap_or(argument);
    file.file_name().map(|name| name.to_string_lossy().into_owned())
}

/// What pictures of the scene are called: as its file, or as its folder where the file is called `scene`.
pub(super) fn picture_name(argument: &Path) -> PathBuf {
    if is_standard_input(argument) {
        return "picture".into();
    }
    let full = std::path::absolute(argument).unwrap_or_else(|_| argument.to_owned());
    let folder = full.parent().and_then(Path::file_name);
    let name = match full.file_stem() {
        _ if argument.is_dir() => full.file_name(),
        Some(stem) if stem == "scene" => folder.or(Some(stem)),
        stem => stem,
    };
    name.map_or_else(|| "picture".into(), PathBuf::from)
}

fn read_standard_input() -> Result<Vec<u8>, CliError> {
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes).map_err(|error| {
        CliError::File(format!("cannot read standard input: {error}; give the name of a scene file"))
    })?;
    Ok(bytes)
}

/// The scene file of a folder, found as that of an archive is.
fn scene_of_folder(folder: &Path) -> Result<PathBuf, CliError> {
    let entries = fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries.map_err(|error| unreadable(folder, &error))?;
    let files = entries.iter().filter(|entry| entry.path().is_file());
    let mut names: Vec<String> = files.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let scene = scene_file(names.iter().map(String::as_str));
    let scene = scene.map_err(|what| {
        let folder = folder.display();
        CliError::BadInput(format!("\"{folder}\" has {what}; give the name of the scene file"))
    })?;
    Ok(folder.join(scene))
}

fn unreadable(path: &Path, error: &std::io::Error) -> CliError {
    CliError::File(format!("cannot read \"{}\": {error}; check the name and the permissions", path.display()))
}
