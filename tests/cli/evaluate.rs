//! `evaluate` and `chart` as their users meet them.

use std::path::{Path, PathBuf};

use crate::command_line::{failure, run, success, text};
use crate::result_records::with_errors;
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::{PictureMetadata, encode_exr, write_file};
use photonfarm::evaluation::{Record, read_results};

const SCENE: &str = "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><film type='hdrfilm'>\
    <integer name='width' value='16'/><integer name='height' value='12'/><rfilter type='box'/></film></sensor>\
    <shape type='sphere'><point name='center' x='0' y='0' z='4'/><bsdf type='diffuse'>\
    <rgb name='reflectance' value='1'/></bsdf></shape><emitter type='constant'/></scene>";

/// A reference: a sphere in a white furnace, said to be `radiance` everywhere.
fn reference(folder: &Path, [width, height]: [u32; 2], radiance: f32) -> PathBuf {
    let place = folder.join("ball");
    std::fs::create_dir_all(&place).expect("creates");
    std::fs::write(place.join("scene.xml"), SCENE).expect("writes");
    let picture = Picture { width, height, radiance: vec![[radiance; 3]; (width * height) as usize] };
    let bytes = encode_exr(&picture, &[], &PictureMetadata::default()).expect("encodes");
    write_file(&place.join("ref.exr"), &bytes).expect("writes");
    place
}

#[test]
fn an_evaluation_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = reference(folder.path(), [16, 12], 0.9);
    let results = folder.path().join("results.jsonl");
    let evaluate = |more: &[&str]| {
        let fixed = ["evaluate", text(&scene), "--methods", "path,sppm:alpha=0.8", "-o", text(&results), "--seconds"];
        success(&[&fixed, more].concat())
    };
    let told = evaluate(&["0.02,0.05", "--seeds", "2", "--pictures"]);
    assert!(told.contains("4 runs") && told.contains("0 are in the file"), "{told}");
    let first = std::fs::read_to_string(&results).expect("reads");
    assert_eq!(first.lines().count(), 8);
    assert!(evaluate(&["0.02,0.05", "--seeds", "2"]).contains("0 runs"), "all of it is there");
    // Another seed, and for all of them another budget; and the last line was cut off.
    std::fs::write(&results, &first[..first.len() - 40]).expect("writes");
    let told = evaluate(&["0.05,0.03", "--seeds", "3"]);
    assert!(told.contains("6 runs") && told.contains("0 are in the file"), "{told}");
    let second = std::fs::read_to_string(&results).expect("reads");
    let kept: Vec<&str> = first.lines().take(7).collect();
    assert!(second.starts_with(&kept.join("\n")), "lines that are there stay");
    assert_eq!(second.lines().count(), 7 + 1 + 4 + 4, "the lost line, the budget and the seed");
    check_lines(&read_results(&results).expect("reads"), folder.path());
}

fn check_lines(records: &[Record], folder: &Path) {
    for record in records {
        assert!(record.cpu_seconds >= record.budget && record.passes > 0, "{record:?}");
        assert_eq!((record.scene.as_str(), record.version.as_str()), ("ball", env!("CARGO_PKG_VERSION")));
        // The truth is 1: 11 % above what the reference says. A single pass of sppm varies by 1.5 %.
        let tolerance = if record.method == "path" { 0.01 } else { 0.08 };
        assert!((record.metrics.bias - 1.0 / 9.0).abs() < tolerance, "{record:?}");
        assert_eq!(record.metrics.reference_noise, None);
    }
    let sppm = records.iter().find(|record| record.method == "sppm").expect("sppm ran");
    assert_eq!((sppm.label.as_str(), &sppm.parameters["alpha"]), ("sppm:alpha=0.8", &serde_json::json!(0.8)));
    assert!((sppm.theory_rate + 0.4).abs() < 1e-9);
    let pictures: Vec<&Record> = records.iter().filter(|record| record.picture.is_some()).collect();
    assert_eq!(pictures.len(), 2, "the first seed at the largest budget, once a method");
    let picture = pictures[0].picture.as_ref().expect("is there");
    image::open(folder.join(picture)).expect("a PNG beside the results");
}

#[test]
fn what_cannot_be_evaluated_is_told_before_rendering() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = reference(folder.path(), [16, 12], 0.9);
    let results = folder.path().join("results.jsonl");
    let evaluate = |scene: &Path, more: &[&str], code| {
        failure(&[&["evaluate", text(scene), "-o", text(&results)], more].concat(), code)
    };
    assert!(evaluate(&scene, &["--methods", "path,spm"], 3).contains("no method \"spm\""));
    assert!(evaluate(&scene, &["--methods", "sppm:alpha=2"], 3).contains("alpha"));
    assert!(evaluate(&scene, &["--methods", "sppm:alpha"], 2).contains("a name, =, and a value"));
    assert!(evaluate(&scene, &["--seconds", "1,0"], 2).contains("above 0"));
    assert!(evaluate(&scene, &["-D", "size=3"], 3).contains("size"));
    assert!(evaluate(&folder.path().join("none"), &[], 5).contains("scene.xml and ref.exr"));
    assert!(evaluate(&scene, &["--reference", "none.exr"], 5).contains("none.exr"));
    reference(folder.path(), [12, 16], 0.9);
    assert!(evaluate(&scene, &[], 3).contains("16 × 12 pixels and its reference 12 × 16"));
    reference(folder.path(), [16, 12], 0.0);
    assert!(evaluate(&scene, &[], 3).contains("black"));
    failure(&["evaluate", text(&scene)], 2);
    failure(&["evaluate", "-o", text(&results)], 2);
    assert!(!results.exists(), "nothing was written");
}

fn write_records(path: &Path, records: &[Record]) {
    let lines = records.iter().map(|record| serde_json::to_string(record).expect("JSON") + "\n");
    std::fs::write(path, lines.collect::<String>()).expect("writes");
}

#[test]
fn comparisons_have_an_exit_code() {
    let folder = tempfile::tempdir().expect("a folder");
    let [old, new] = ["old.jsonl", "new.jsonl"].map(|name| folder.path().join(name));
    let compare = ["evaluate", "--compare", text(&old), text(&new)];
    write_records(&old, &with_errors("box", &[0.1, 0.11, 0.09]));
    write_records(&new, &with_errors("box", &[0.105, 0.112, 0.09]));
    assert!(success(&compare).contains("0 better, 0 worse, 1 without change"));
    write_records(&new, &with_errors("box", &[0.3, 0.33, 0.27]));
    assert!(failure(&compare, 6).contains("1 worse"));
    let table = String::from_utf8_lossy(&run(&compare).stdout).into_owned();
    assert!(table.contains("| box | sppm | 10 | 3.000 |") && table.contains("WORSE"), "{table}");
    write_records(&new, &with_errors("room", &[0.3]));
    assert!(failure(&compare, 3).contains("no cell in common"));
    failure(&["evaluate", "--compare", text(&old), "none.jsonl"], 5);
}

#[test]
fn charts_are_written_by_the_end_of_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name);
    write_records(&place("a.jsonl"), &with_errors("box", &[0.1, 0.11]));
    let results = place("a.jsonl");
    let outputs = ["a.html", "a.svg", "a.png"].map(place);
    let chart = ["chart", text(&results), "--kind", "best", "-o"];
    success(&[&chart[..], &[text(&outputs[0]), "-o", text(&outputs[1]), "-o", text(&outputs[2])]].concat());
    let starts: [&[u8]; 3] = [b"<!DOCTYPE html>", b"<svg", b"\x89PNG"];
    for (path, start) in outputs.iter().zip(starts) {
        assert!(std::fs::read(path).expect("is there").starts_with(start), "{}", path.display());
    }
    let jpg = place("a.jpg");
    assert!(failure(&[&chart[..], &[text(&jpg)]].concat(), 2).contains(".html, .svg or .png"));
    let html = text(&outputs[0]);
    assert!(failure(&["chart", text(&results), "-o", html, "--peers", "none.csv"], 5).contains("none.csv"));
    assert!(failure(&["chart", text(&results), "-o", html, "--target", "0"], 2).contains("--target"));
    std::fs::write(place("empty.jsonl"), "").expect("writes");
    assert!(failure(&["chart", text(&place("empty.jsonl")), "-o", html], 3).contains("no results"));
}
