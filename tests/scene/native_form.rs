//! A scene in the native form means what the scene itself means, to the last bit.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::description_tree::tree;
use crate::progressive::{Job, reference_folder, reference_scene};
use photonfarm::import::{load_bytes, load_file, native};
use photonfarm::scene::Scene;
use photonfarm::scene::description::SceneDescription;

fn own_scenes() -> Vec<PathBuf> {
    let folders = std::fs::read_dir("scenes").expect("scenes stands beside the manifest");
    let files = folders.map(|entry| entry.expect("a readable folder").path().join("scene.xml"));
    files.filter(|file| file.exists()).collect()
}

fn load(path: &Path) -> SceneDescription {
    load_file(path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn load_text(text: &str) -> SceneDescription {
    load_bytes("scene.xml", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn read_back(description: &SceneDescription) -> SceneDescription {
    let json = native::to_json(description).unwrap_or_else(|error| panic!("{error}"));
    let again = load_bytes("scene.json", json.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}\n{json}"));
    SceneDescription { bundle: description.bundle.clone(), ..again }
}

#[test]
fn every_scene_of_our_own_reads_back_as_the_same_tree() {
    let files = own_scenes();
    assert!(files.len() >= 6, "only {} scenes were found", files.len());
    for file in files {
        let description = load(&file);
        assert_eq!(tree(&read_back(&description)), tree(&description), "{}", file.display());
        let zip = native::to_zip(&description).unwrap_or_else(|error| panic!("{error}"));
        let unpacked = load_bytes("scene.zip", &zip, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(tree(&unpacked), tree(&description), "{}", file.display());
        assert!(Scene::prepare(&unpacked).is_ok(), "{}", file.display());
    }
}

#[test]
fn numbers_slots_and_shared_plugins_read_back() {
    let description = load_text(
        "<scene version='3.0.0'><shape type='cube'><ref id='both'/></shape>\
         <bsdf type='blendbsdf' id='both'><float name='weight' value='0.1000000000000000055'/>\
         <bsdf type='diffuse' id='grey'><rgb name='reflectance' value='1e-310, 0.30000000000000004, 5e-324'/></bsdf><ref id='grey'/></bsdf>\
         <shape type='sphere'><transform name='to_world'><rotate x='0.3' y='1' z='-7' angle='33.3'/><scale value='1.1'/></transform>\
         <point name='center' value='-0, 123456789.123456789, 2.2250738585072011e-308'/><integer name='count' value='9007199254740993'/>\
         <float name='whole' value='3'/><boolean name='yes' value='true'/><string name='text' value='a &quot;b&quot; \\ ü'/>\
         <bsdf type='twosided'><ref id='grey'/><bsdf type='diffuse'/></bsdf></shape>\
         <shape type='disk'><bsdf type='bumpmap'><texture type='bitmap' name='bump'><string name='filename' value='a.png'/></texture>\
         <bsdf type='diffuse' name='inner'/></bsdf></shape></scene>",
    );
    let again = read_back(&description);
    assert_eq!(tree(&again), tree(&description));
    assert_eq!(native::to_json(&again).expect("writes"), native::to_json(&description).expect("writes"));
}

#[test]
fn what_json_cannot_hold_is_an_error_with_its_place() {
    let cases = [
        ("<shape type='sphere'><float name='radius' value='nan'/></shape>", "not finite"),
        ("<shape type='sphere'><float name='radius' value='1'/><float name='radius' value='2'/></shape>", "twice"),
        ("<shape type='sphere'><string name='type' value='cube'/></shape>", "means something else"),
        ("<shape type='sfere'/>", "no shape \"sfere\""),
    ];
    for (body, part) in cases {
        let description = load_text(&format!("<scene version='3.0.0'>\n{body}</scene>"));
        let error = native::to_json(&description).expect_err(body).to_string();
        assert!(error.contains(part) && error.starts_with("scene.xml:2"), "{error}");
    }
}

#[test]
fn a_scene_read_back_renders_the_same_bits() {
    let description = load(&reference_folder("lantern").join("scene.xml"));
    let again = Arc::new(Scene::prepare(&read_back(&description)).expect("the scene is good"));
    let pictures = [reference_scene("lantern"), again].map(|scene| {
        let estimate = Job::new(&scene, "sppm", r#"{"photons_per_pass": 4096}"#).run(2, 1);
        estimate.picture().radiance.iter().flatten().map(|channel| channel.to_bits()).collect::<Vec<u32>>()
    });
    assert!(pictures[0].iter().any(|bits| *bits != 0), "the picture is black");
    assert!(pictures[0] == pictures[1], "the pictures differ");
}
