//! The scene file as the bytes that are uploaded.

use std::io::{Cursor, Read, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipArchive, ZipWriter};

use super::exit_code::CliError;
use super::scene_input::{SceneInput, name_in_messages};
use super::terminal;
use crate::import;
use crate::import::changes::{Changes, with_changes};
use crate::scene::bundle::scene_in_comment;

/// A define of the command line: name and value.
type Define = (String, String);

/// Reads the scene and everything it refers to, with `defines` written into it and `changes` beside it.
pub(super) fn pack(argument: &Path, defines: &[Define], changes: &Changes) -> Result<Vec<u8>, CliError> {
    Ok(with_changes(&pack_defined(argument, defines)?, changes)?)
}

fn pack_defined(argument: &Path, defines: &[Define]) -> Result<Vec<u8>, CliError> {
    // Packing checks the defines as well: each must be used, and JSON scenes take none.
    let bytes = match SceneInput::open(argument)? {
        SceneInput::File(file) => import::pack(&file, defines)?,
        SceneInput::Bytes(bytes) => import::pack_read(SceneInput::read_scene(&bytes), defines)?,
    };
    tell_of_files_above(&bytes);
    if defines.is_empty() {
        return Ok(bytes);
    }
    let cannot_define = |problem: String| {
        CliError::BadInput(format!("{}: cannot write -D into the scene: {problem}", argument.display()))
    };
    if bytes.starts_with(b"PK") {
        return define_in_archive(bytes, defines).map_err(|error| cannot_define(error.to_string()));
    }
    define_in_xml(&bytes, defines).map_err(|error| cannot_define(error.to_string()))
}

/// What a farm says of a scene that was packed from `argument`, with the user's name for it where the text names the scene itself.
pub(super) fn in_users_file(text: &str, argument: &Path) -> String {
    let rest_after = |name| text.strip_prefix(name).filter(|rest| rest.starts_with([':', ' ']));
    let packed = import::packed_names().find_map(rest_after);
    match (packed, name_in_messages(argument)) {
        (Some(rest), Some(name)) => format!("{name}{rest}"),
        _ => text.to_owned(),
    }
}

/// Whoever sends a scene that came from elsewhere sees what else it takes along.
fn tell_of_files_above(bytes: &[u8]) {
    let Some(scene) = scene_in_comment(bytes) else { return };
    let folder = scene.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
    let Ok(archive) = ZipArchive::new(Cursor::new(bytes)) else { return };
    let names: Vec<String> = archive.file_names().filter_map(|name| name.ok().map(String::from)).collect();
    let above: Vec<&str> = names.iter().map(String::as_str).filter(|name| !name.starts_with(&folder)).collect();
    if !above.is_empty() {
        terminal::note(&format!("the scene takes along files from above its folder: {}", above.join(", ")));
    }
}

/// Defines become the first `<default>`s of the scene, which count before its own. They share the line of what follows,
/// so that later errors still name the user's lines.
fn define_in_xml(bytes: &[u8], defines: &[Define]) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let text = std::str::from_utf8(bytes)?;
    let document = roxmltree::Document::parse(text)?;
    let first_child = document.root_element().first_child().ok_or("the scene is empty")?;
    let (head, tail) = text.split_at(first_child.range().start);
    let defaults = defines.iter().map(|(name, value)| {
        format!("<default name=\"{}\" value=\"{}\"/>", attribute_text(name), attribute_text(value))
    });
    Ok(format!("{head}{}{tail}", defaults.collect::<String>()).into_bytes())
}

fn attribute_text(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// The archive with its scene file changed.
fn define_in_archive(bytes: Vec<u8>, defines: &[Define]) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut archive = ZipArchive::new(Cursor::new(&bytes))?;
    let names = archive.file_names().map(|name| name.map(String::from)).collect::<Result<Vec<String>, _>>()?;
    let scene = import::scene_in_archive(&bytes, names.iter().map(String::as_str))?;
    let comment = String::from_utf8_lossy(archive.comment()).into_owned();
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default()).unix_permissions(0o644);
    let mut changed = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..archive.len() {
        let mut file = archive.by_index(index)?;
        if file.is_dir() {
            continue;
        }
        let name = file.name()?.into_owned();
        let mut content = Vec::new();
        file.read_to_end(&mut content)?;
        changed.start_file(name.as_str(), options)?;
        changed.write_all(&if name == scene { define_in_xml(&content, defines)? } else { content })?;
    }
    changed.set_comment(comment)?;
    Ok(changed.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "<?xml version='1.0'?>\n<scene version='3.0.0'>\n<default name='size' value='8'/>\n\
        <sensor type='perspective'><film type='hdrfilm'><integer name='width' value='$size'/></film></sensor></scene>";

    fn define(value: &str) -> Vec<Define> {
        vec![("size".to_owned(), value.to_owned())]
    }

    fn packed(files: &[(&str, &str)], defines: &[Define]) -> Result<Vec<u8>, CliError> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).expect("writes");
        }
        pack_defined(&folder.path().join(files[0].0), defines)
    }

    #[test]
    fn a_define_beats_the_scenes_default() {
        let bytes = packed(&[("a.xml", SCENE)], &define("32")).expect("packs");
        let defined = import::load_bytes("a.xml", &bytes, &[]).expect("loads");
        assert!(format!("{:?}", defined.root).contains("Integer(32)"));
        let text = String::from_utf8(bytes).expect("XML");
        assert_eq!(text.lines().count(), SCENE.lines().count());
    }

    #[test]
    fn a_define_reaches_a_scene_with_files() {
        let scene =
            SCENE.replace("</scene>", "<shape type='obj'><string name='filename' value='a.obj'/></shape></scene>");
        let bytes = packed(&[("a.xml", &scene), ("a.obj", "v 0 0 0\n")], &define("32")).expect("packs");
        assert!(bytes.starts_with(b"PK"));
        let defined = import::load_bytes("a.zip", &bytes, &[]).expect("loads");
        assert!(format!("{:?}", defined.root).contains("Integer(32)"));
    }

    #[test]
    fn an_unused_define_is_bad_input() {
        let unused = vec![("sice".to_owned(), "3".to_owned())];
        assert!(matches!(packed(&[("a.xml", SCENE)], &unused), Err(CliError::BadInput(_))));
    }
}
