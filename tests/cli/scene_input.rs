//! Where a scene may come from: a file, a folder, standard input.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use photonfarm::estimate::picture_files::read_exr;

use crate::command_line::{ended, failure, program, run, text};

const SCENE: &str = "<scene version='3.0.0'>\n<default name='size' value='8'/>\n<integrator type='path'/>
    <sensor type='perspective'><film type='hdrfilm'><integer name='width' value='$size'/><integer name='height' value='$size'/></film></sensor>
    <shape type='obj'><string name='filename' value='parts/a.obj'/></shape><emitter type='constant'/></scene>";

/// A folder with a scene of two files.
fn scene_folder(folder: &Path) {
    fs::create_dir(folder.join("parts")).expect("creates");
    fs::write(folder.join("parts/a.obj"), "v -9 -9 3\nv 9 -9 3\nv 0 9 3\nf 1 3 2\n").expect("writes");
    fs::write(folder.join("scene.xml"), SCENE).expect("writes");
}

/// Runs in `folder` with `input` as standard input.
fn fed(folder: &Path, arguments: &[&str], input: &[u8]) -> Output {
    let mut command = program(arguments);
    command.current_dir(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    // A program that refuses its options may end before it reads.
    let _ = child.stdin.take().expect("a pipe").write_all(input);
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_scene_is_the_same_from_a_file_a_folder_and_standard_input() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    scene_folder(folder);
    let options = ["--passes", "2", "-D", "size=6", "--time-shares", "-o"];
    let render = |scene: &str, output: &str, input: &[u8]| {
        let told = ended(&fed(folder, &[["render", scene].as_slice(), &options, &[output]].concat(), input), 0);
        assert!(told.contains("a pass takes"), "{told}");
        read_exr(&folder.join(output)).expect("a picture")
    };
    let expected = render("scene.xml", "file.exr", b"");
    assert!(render(".", "folder.exr", b"") == expected);
    assert!(render("-", "input.exr", SCENE.as_bytes()) == expected);
    // An archive, too.
    ended(&fed(folder, &["import", "-", "-o", "scene.zip"], SCENE.as_bytes()), 0);
    let archive = fs::read(folder.join("scene.zip")).expect("an archive");
    ended(&fed(folder, &["scene", "check", "-"], &archive), 0);
}

#[test]
fn pictures_of_a_folder_have_its_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let room = folder.path().join("room");
    fs::create_dir(&room).expect("creates");
    scene_folder(&room);
    let told = ended(&fed(folder.path(), &["render", "room", "--passes", "1"], b""), 0);
    assert!(told.contains("wrote room.exr\n") && told.contains("wrote room.png\n"), "{told}");
}

#[test]
fn scenes_that_are_not_there_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let empty = failure(&["render", text(folder.path())], 3);
    assert!(empty.contains("has no scene file at its top level; give the name of the scene file"), "{empty}");
    for name in ["a.xml", "b.xml"] {
        fs::write(folder.path().join(name), SCENE).expect("writes");
    }
    let several = failure(&["submit", text(folder.path())], 3);
    assert!(several.contains("has several scene files at its top level: a.xml, b.xml"), "{several}");
    let broken = ended(&fed(folder.path(), &["scene", "check", "-"], b"<scene>\n<oops"), 3);
    assert!(broken.contains("standard input:1"), "{broken}");
    // Nothing is fed here.
    assert!(ended(&run(&["plan", "-"]), 3).contains("standard input: the scene file is empty"));
}
