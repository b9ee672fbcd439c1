//! The program as its users meet it: what it prints, where, and with which exit code.

use std::path::Path;
use std::process::{Output, Stdio};

use crate::command_line::{ended, program, run};
use crate::exr_channels::exr_channels;
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::{LAYERS, PictureMetadata, encode_exr, write_file};
use photonfarm::import::formats;

/// A port on which nothing listens: the discard port of this machine.
const NOBODY: &str = "http://127.0.0.1:9";
const SCENE: &str = "tests/references/cornell-diffuse/scene.xml";

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Standard error of a run that failed with `code` and printed no result.
fn failure(output: &Output, code: i32) -> String {
    assert_eq!(stdout(output), "", "results only on standard output");
    ended(output, code)
}

fn write_grey(path: &Path, grey: f32) {
    let picture = Picture { width: 16, height: 16, radiance: vec![[grey; 3]; 256] };
    let bytes = encode_exr(&picture, &[], &PictureMetadata::default()).expect("encodes");
    write_file(path, &bytes).expect("writes");
}

#[test]
fn help_tells_the_exit_codes() {
    let output = run(&["--help"]);
    assert!(output.status.success());
    let readme = include_str!("../../README.md");
    let help = stdout(&output);
    let codes: Vec<&str> = help.lines().skip_while(|line| *line != "Exit codes:").skip(1).collect();
    assert_eq!(codes.len(), 8, "{help}");
    for line in codes {
        let (code, meaning) = line.trim().split_once(' ').expect("a code and its meaning");
        // The manual shows commands and options as code.
        let row = format!("| {code} | {} |", meaning.trim());
        assert!(readme.replace('`', "").contains(&row), "README.md lacks {row}");
    }
}

#[test]
fn help_tells_all_formats_of_scenes() {
    for command in [["render"].as_slice(), &["submit"], &["scene", "check"], &["import"], &["plan"]] {
        let help = stdout(&run(&[command, &["--help"]].concat()));
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(help.contains(&formats::told()), "{help}");
    }
}

#[test]
fn wrong_usage_is_2() {
    failure(&run(&["render"]), 2);
    failure(&run(&["render", "a.xml", "--set", "alpha"]), 2);
    failure(&run(&["render", "a.xml", "--threads", "0"]), 2);
    // JSON has no such numbers: without one a rule would be none.
    for number in ["nan", "inf", "1e400"] {
        failure(&run(&["render", "a.xml", "--error", number]), 2);
        failure(&run(&["render", "a.xml", "--seconds", number]), 2);
    }
    for wrong in [
        ["--passes", "0"],
        ["--error", "0"],
        ["--seconds", "-1"],
        ["--passes-per-shard", "2000"],
        ["--shards-per-epoch", "3"],
        ["--exposure", "100"],
        ["--size", "0"],
    ] {
        failure(&run(&[["render", "a.xml"].as_slice(), &wrong].concat()), 2);
    }
    failure(&run(&["serve", "--data", "none", "--database", "postgres://farm"]), 2);
    failure(&run(&["serve", "--data", "none", "--check-share", "2"]), 2);
    failure(&run(&["worker", "--coordinator", "farm:80"]), 2);
    failure(&run(&["jobs", "--coordinator", NOBODY, "--authorities", "a.pem"]), 2);
    let stderr = failure(&run(&["render", "a.xml", "--layers", "radius,detph"]), 2);
    assert!(LAYERS.iter().all(|row| stderr.contains(row.name)), "{stderr}");
}

#[test]
fn methods_are_listed_with_their_parameters() {
    let output = run(&["methods"]);
    assert!(output.status.success());
    assert!(stdout(&output).starts_with("sppm: ") && stdout(&output).contains("alpha"));
    assert!(failure(&run(&["methods", "spppm"]), 3).contains("sppm"));
}

#[test]
fn a_closed_standard_output_is_no_panic() {
    let mut child = program(&["methods"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn compare_measures_and_prints_json() {
    let folder = tempfile::tempdir().expect("a folder");
    let (image, reference) = (folder.path().join("image.exr"), folder.path().join("reference.exr"));
    write_grey(&image, 1.5);
    write_grey(&reference, 1.0);
    let paths = [image.to_str().expect("UTF-8"), reference.to_str().expect("UTF-8")];
    let output = run(&["compare", paths[0], paths[1], "--json"]);
    let metrics: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(metrics["rmse"], 0.5);
    assert_eq!(metrics["bias"], 0.5);
    let text = stdout(&run(&["compare", paths[0], paths[1]]));
    assert!(text.contains("mean bias         +50.000 %"), "{text}");
}

#[test]
fn compare_tells_what_cannot_be_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("image.exr");
    write_grey(&image, 1.0);
    let image = image.to_str().expect("UTF-8");
    assert!(failure(&run(&["compare", image, "no-such.exr"]), 5).contains("no-such.exr"));
    let sizes = failure(&run(&["compare", image, "tests/references/cornell-diffuse/ref.exr"]), 3);
    assert!(sizes.contains("same size"), "{sizes}");
    assert!(failure(&run(&["compare", image, SCENE]), 5).contains("OpenEXR"));
}

#[test]
fn an_unwritable_output_is_told_before_rendering() {
    let stderr = failure(&run(&["render", SCENE, "-o", "no/such/folder/a.exr"]), 5);
    assert!(stderr.contains("no/such/folder/a.exr") && stderr.contains("create the folder"), "{stderr}");
}

/// What is asked for and cannot be is told before anything is rendered, as wrong usage.
#[test]
fn outputs_that_do_not_fit_their_options_are_wrong_usage() {
    let folder = tempfile::tempdir().expect("a folder");
    let [exr, png] = ["a.exr", "a.png"].map(|name| folder.path().join(name).to_string_lossy().into_owned());
    let refused = |options: &[&str]| failure(&run(&[["render", SCENE].as_slice(), options].concat()), 2);
    assert!(refused(&["-o", "a.gif"]).contains(".exr, .png, .jpg or .webp"));
    let layers = refused(&["-o", &png, "--layers", "depth"]);
    assert!(layers.contains("--layers goes into EXR files, and none is written"), "{layers}");
    let exposure = refused(&["-o", &exr, "--exposure", "1"]);
    let expected =
        "--exposure changes pictures to look at, and none is written; give an -o that ends in .png, .jpg or .webp";
    assert!(exposure.contains(expected), "{exposure}");
    assert!(refused(&["-o", &exr, "--tone", "agx"]).contains("--tone changes pictures to look at"));
    assert!(refused(&["-o", &png, "--half"]).contains("--half changes EXR files, and none is written"));
    assert!(refused(&["-o", &exr, "--bits", "16"]).contains("--bits changes PNG files, and none is written"));
    assert!(refused(&["-o", &png, "--quality", "80"]).contains("--quality changes JPEG files, and none is written"));
    assert!(refused(&["-o", &png, "--bits", "12"]).contains("possible values: 8, 16"));
    assert!(refused(&["-o", &png, "--tone", "acid"]).contains("linear, filmic, agx"));
    assert!(refused(&["-o", "a.jpg", "--quality", "0"]).contains("1..=100"));
    assert!(refused(&["-o", &png, "--exposure", "bright"]).contains("give a number of stops, or auto"));
    let fetch = failure(&run(&["fetch", "job", "-o", &png, "--layers", "depth", "--coordinator", NOBODY]), 2);
    assert!(fetch.contains("--layers goes into EXR files"), "{fetch}");
    assert!(!Path::new(&exr).exists() && !Path::new(&png).exists());
}

/// The last one of a name would win without a word.
#[test]
fn what_is_given_twice_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("a.exr").to_string_lossy().into_owned();
    let render = |options: &[&str], code| {
        failure(&run(&[["render", SCENE, "-o", output.as_str()].as_slice(), options].concat()), code)
    };
    for options in [
        ["--set", "length=3", "--set", "length=4"],
        ["--set", "length=3", "--set", "length=3"],
        ["--set", "length=3", "--length", "4"],
        ["--set", "strategy=0,3", "--strategy", "1,2"],
    ] {
        let told = render(&[["--method", "bdpt"].as_slice(), &options].concat(), 2);
        assert!(told.contains("\" is given twice; give it once"), "{told}");
    }
    // Mitsuba refuses the second value of a parameter, too.
    let told = render(&["-D", "size=16", "-D", "size=32"], 2);
    assert!(told.contains("-D \"size\" is given twice; give it once"), "{told}");
    let plan = ["plan", SCENE, "--set", "alpha=0.5", "--set", "alpha=0.6"];
    assert!(failure(&run(&plan), 2).contains("\"alpha\" is given twice"));
    assert!(!Path::new(&output).exists());
}

#[test]
fn layers_become_channels() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = old_scene(folder.path());
    let picture = folder.path().join("picture.exr");
    let output = picture.to_str().expect("UTF-8");
    let run = run(&["render", &scene, "--passes", "1", "-o", output, "--layers", "albedo,depth", "--layers", "normal"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let channels = exr_channels(&std::fs::read(&picture).expect("a picture"));
    let names: Vec<&str> = channels.keys().map(String::as_str).collect();
    let layers = ["albedo.B", "albedo.G", "albedo.R", "depth.Z", "normal.X", "normal.Y", "normal.Z"];
    assert_eq!(names, [["B", "G", "R"].as_slice(), layers.as_slice()].concat());
    // The triangle stands at z = 3 in front of the camera, a grey of 0.5.
    assert!((channels["depth.Z"][4 * 8 + 4] - 3.0).abs() < 0.1);
    assert_eq!(channels["albedo.G"][4 * 8 + 4], 0.5);
}

#[test]
fn a_missing_scene_is_a_file_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = program(&["render", "no-such-scene.xml"]).current_dir(folder.path()).output().expect("starts");
    assert!(failure(&output, 5).contains("no-such-scene.xml"));
    assert_eq!(std::fs::read_dir(folder.path()).expect("lists").count(), 0, "no file is left behind");
}

/// A scene of one file travels without its name.
#[test]
fn what_the_farm_says_of_a_scene_names_the_user_s_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = |light: &str| {
        format!(
            "<scene version='3.0.0'>\n<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='8'/>
            <integer name='height' value='8'/></film></sensor>\n<shape type='sphere'/>{light}</scene>"
        )
    };
    let render = |text: &str, more: &[&str]| {
        std::fs::write(folder.path().join("my.xml"), text).expect("writes");
        let arguments = [&["render", "my.xml", "--passes", "1", "-o", "a.exr"], more].concat();
        program(&arguments).current_dir(folder.path()).output().expect("starts")
    };
    // Small pictures are packed with their size, which gives the scene a name of its own.
    for more in [[].as_slice(), &["--size", "4"]] {
        let stderr =
            failure(&render(&scene("<emitter type='constant'><float name='radiance' value='0'/></emitter>"), more), 3);
        assert!(stderr.contains("my.xml:1 (scene): nothing in the scene emits light"), "{stderr}");
        let unseen = "<emitter type='area'/><emitter type='constant'/>";
        let stderr = String::from_utf8_lossy(&render(&scene(unseen), more).stderr).into_owned();
        assert!(stderr.contains("note: my.xml:"), "{stderr}");
    }
}

#[test]
fn a_malformed_scene_is_bad_input_with_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.xml"), "<scene version='3.0.0'>\n<sensor></scene>").expect("writes");
    let output = program(&["render", "a.xml"]).current_dir(folder.path()).output().expect("starts");
    let stderr = failure(&output, 3);
    assert!(stderr.contains("a.xml:2"), "{stderr}");
}

#[test]
fn an_absent_coordinator_is_told_with_the_remedy() {
    for arguments in [&["jobs"][..], &["cancel", "job"], &["watch", "job"], &["submit", SCENE]] {
        let stderr = failure(&run(&[arguments, &["--coordinator", NOBODY]].concat()), 4);
        assert!(stderr.contains(NOBODY) && stderr.contains("photonfarm serve"), "{stderr}");
    }
    assert!(failure(&run(&["jobs", "--coordinator", "farm:80"]), 2).contains("http://HOST:PORT"));
}

#[test]
fn an_id_that_leads_elsewhere_is_refused() {
    assert!(failure(&run(&["cancel", "../workers", "--coordinator", NOBODY]), 2).contains("not a job's id"));
}

const OLD_SCENE: &str = "<scene version='0.5.0'><mode type='final'/><integrator type='sppm'/>\
    <sensor type='perspective'><film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/>\
    <rfilter type='box'/></film></sensor><shape type='obj'><string name='filename' value='parts/a.obj'/></shape>\
    <emitter type='constant'/></scene>";

fn old_scene(folder: &Path) -> String {
    std::fs::create_dir(folder.join("parts")).expect("creates");
    std::fs::write(folder.join("parts/a.obj"), "v -9 -9 3\nv 9 -9 3\nv 0 9 3\nf 1 3 2\n").expect("writes");
    std::fs::write(folder.join("old.xml"), OLD_SCENE).expect("writes");
    folder.join("old.xml").to_string_lossy().into_owned()
}

#[test]
fn scene_check_tells_what_a_scene_contains_and_what_was_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = old_scene(folder.path());
    let output = run(&["scene", "check", &scene]);
    let text = stdout(&output);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for line in
        ["method     sppm", "picture    8 × 8 pixels", "shapes     1: 1 obj", "primitives 1", "the <mode> is ignored"]
    {
        assert!(text.contains(line), "{line} in {text}");
    }
    let document: serde_json::Value =
        serde_json::from_slice(&run(&["scene", "check", &scene, "--json"]).stdout).expect("JSON");
    assert_eq!(document["contents"]["shapes"]["obj"], 1);
    assert_eq!(document["contents"]["media"], serde_json::json!({}));
    assert_eq!(document["import_report"][0]["treatment"], "ignored");
}

#[test]
fn scene_check_tells_media() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("fog.xml");
    std::fs::write(&scene, FOG).expect("writes");
    let scene = scene.to_string_lossy();
    let text = stdout(&run(&["scene", "check", &scene]));
    assert!(text.contains("media      2: 1 heterogeneous, 1 homogeneous"), "{text}");
    let document: serde_json::Value =
        serde_json::from_slice(&run(&["scene", "check", &scene, "--json"]).stdout).expect("JSON");
    assert_eq!(document["contents"]["media"], serde_json::json!({"heterogeneous": 1, "homogeneous": 1}));
}

/// Three shapes with two media, of which one is shared.
const FOG: &str =
    "<scene version='3.0.0'><integrator type='volpath'/><sensor type='perspective'/><emitter type='constant'/>
    <medium type='homogeneous' id='fog'/>
    <shape type='sphere'><bsdf type='null'/><ref id='fog' name='interior'/></shape>
    <shape type='sphere'><point name='center' x='3'/><bsdf type='null'/><ref id='fog' name='interior'/></shape>
    <shape type='cube'><bsdf type='null'/><medium name='interior' type='heterogeneous'>
    <volume name='albedo' type='constvolume'><float name='value' value='0.5'/></volume></medium></shape></scene>";

#[test]
fn plan_tells_what_a_scene_needs_and_who_is_fastest() {
    let scene = "scenes/cornell-glass-mirror/scene.xml";
    let plan = stdout(&run(&["plan", scene, "-D", "size=16"]));
    for told in ["16 × 16", "mirrors or glass", "\nmethod ", " to ", "processor-seconds to relMSE 0.01", "sppm", "bdpt"]
    {
        assert!(plan.contains(told), "no {told:?} in\n{plan}");
    }
    assert!(plan.lines().count() <= 10, "{plan}");
    let json: serde_json::Value =
        serde_json::from_slice(&run(&["plan", scene, "-D", "size=16", "--json", "--error", "0.1"]).stdout)
            .expect("JSON");
    let seconds: Vec<f64> = json["trials"]
        .as_array()
        .expect("trials")
        .iter()
        .map(|trial| trial["expected_seconds"].as_f64().expect("a number"))
        .collect();
    assert!(seconds.len() > 3 && seconds.is_sorted(), "{json}");
    for trial in json["trials"].as_array().expect("trials") {
        let [low, high] = [0, 1].map(|end| trial["seconds_range"][end].as_f64().expect("a number"));
        assert!(low < trial["expected_seconds"].as_f64().expect("a number"), "{trial}");
        assert!(high > trial["expected_seconds"].as_f64().expect("a number"), "{trial}");
    }
    failure(&run(&["plan", scene, "--error", "0"]), 2);
}

#[test]
fn scene_check_fails_on_what_cannot_be_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = old_scene(folder.path());
    std::fs::remove_file(folder.path().join("parts/a.obj")).expect("removes");
    let stderr = failure(&run(&["scene", "check", &scene]), 3);
    assert!(stderr.contains("parts/a.obj") && stderr.contains("old.xml:1"), "{stderr}");
    assert!(failure(&run(&["scene", "check", "no-such.xml"]), 5).contains("no-such.xml"));
}

#[test]
fn import_writes_the_native_form_and_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = old_scene(folder.path());
    let target = |name: &str| folder.path().join("new").join(name).to_string_lossy().into_owned();
    std::fs::create_dir(folder.path().join("new")).expect("creates");
    let output = run(&["import", &scene, "-o", &target("scene.json"), "--report", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report[0]["subject"], "the <mode>");
    assert!(run(&["scene", "check", &target("scene.json")]).status.success());
    assert!(run(&["import", &scene, "-o", &target("scene.zip")]).status.success());
    assert!(run(&["scene", "check", &target("scene.zip")]).status.success());
    // Once more changes nothing, but a file of the same name is not overwritten.
    assert!(run(&["import", &scene, "-o", &target("scene.json")]).status.success());
    std::fs::write(target("parts/a.obj"), "v 0 0 0\n").expect("writes");
    assert!(failure(&run(&["import", &scene, "-o", &target("scene.json")]), 5).contains("other contents"));
    assert!(failure(&run(&["import", &scene, "-o", "scene.xml"]), 2).contains(".json or .zip"));
    failure(&run(&["import", &scene]), 2);
}
