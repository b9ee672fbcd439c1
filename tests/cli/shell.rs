//! What shells, manuals and scripts get of the command line.

use crate::command_line::{ended, program, run, text};

const SCENE: &str = "tests/references/cornell-diffuse/scene.xml";

#[test]
fn shells_complete_every_command() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = run(&["completions", shell]);
        ended(&output, 0);
        let script = String::from_utf8(output.stdout).expect("text");
        assert!(["render", "submit", "overwrite"].iter().all(|word| script.contains(word)), "{shell}: {script}");
    }
    ended(&run(&["completions", "command.com"]), 2);
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().expect("a folder");
    ended(&run(&["manual", text(folder.path())]), 0);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a page");
    assert!(page("photonfarm.1").contains("photonfarm") && page("photonfarm-render.1").contains("overwrite"));
    assert!(ended(&run(&["manual", "no/such/folder"]), 5).contains("no/such/folder"));
}

/// Nothing but errors on standard error, whose exit codes stay.
#[test]
fn quiet_is_quiet() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("a.exr");
    let render = ["render", SCENE, "--size", "8", "--passes", "1", "-o", text(&picture)];
    assert!(!ended(&run(&render), 0).is_empty());
    assert_eq!(ended(&run(&[render.as_slice(), &["--quiet"]].concat()), 0), "");
    assert!(picture.exists());
    assert!(ended(&run(&["--quiet", "render", "no-such-scene.xml"]), 5).contains("no-such-scene.xml"));
    ended(&program(&["-q", "-v", "methods"]).output().expect("it starts"), 2);
}
