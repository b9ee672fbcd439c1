//! The line that tells how a job is doing, on terminals of several widths.

use std::process::{Command, Stdio};

use crate::command_line::text;

const SCENE: &str = "tests/references/cornell-diffuse/scene.xml";

/// What a render of four seconds draws on a terminal of so many columns, which `script` makes: one text for each time that the line was drawn.
fn drawn(columns: usize) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("a.exr");
    let program = env!("CARGO_BIN_EXE_photonfarm");
    let stop = "--size 32 --method path --threads 1 --passes 1000000 --seconds 4";
    let command = format!("stty cols {columns} rows 24; {program} render {SCENE} {stop} -o {}", text(&picture));
    let mut script = Command::new("script");
    let output = script.args(["-qec", &command, "/dev/null"]).stdin(Stdio::null()).output().expect("script starts");
    let drawn = String::from_utf8(output.stdout).expect("UTF-8");
    drawn.split(['\r', '\n']).map(without_escapes).filter(|line| line.starts_with('[')).collect()
}

/// A terminal's orders begin with an escape and end with a letter.
fn without_escapes(line: &str) -> String {
    let mut parts = line.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        text + part.trim_start_matches(|sign: char| !sign.is_ascii_alphabetic()).get(1..).unwrap_or_default()
    })
}

#[test]
fn narrow_terminals_show_the_time_that_is_left() {
    for (columns, shown) in [(50, vec![" of 1000000 passes", " s left"]), (80, vec![" s left", "relMSE < "])] {
        let lines = drawn(columns);
        let is_full = |line: &&String| shown.iter().all(|part| line.contains(part));
        assert!(lines.iter().any(|line| is_full(&line)), "no {shown:?} in {lines:#?}");
        assert!(lines.iter().all(|line| line.chars().count() <= columns), "{lines:#?}");
    }
    let wide = drawn(160);
    assert!(wide.iter().any(|line| line.contains("million samples/s") && line.contains(" s left")), "{wide:#?}");
}
