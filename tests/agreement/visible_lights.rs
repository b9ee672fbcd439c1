//! Picks of lights that know which are seen where: the same picture with less noise, and nothing where nothing is hidden.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::scene::Scene;

use crate::batches::{assert_same, bits_of_threads, mean_and_error, repository_scene};
use crate::progressive::{Job, reference_scene};
use crate::scene_text::prepare;

fn learns_visibility(scene: &Arc<Scene>, method: &str, parameters: &str) -> bool {
    let pilot = Job::new(scene, method, parameters).renderer.pilot(&AtomicBool::new(false)).expect("nobody cancels");
    !pilot.guides().visibility.is_empty()
}

#[test]
fn a_lamp_in_a_sealed_room_takes_no_picks() {
    let scene = repository_scene("sealed-lamp/scene.xml", "32");
    let alone = repository_scene("sealed-lamp/alone.xml", "32");
    let radius = r#", "initial_radius": 0.2, "photons_per_pass": 20000, "emission": "auto""#;
    // The least that noise falls: photons and light subpaths that start by power keep theirs.
    let methods = [("path", "", 10.0), ("sppm", radius, 10.0), ("photon_map", r#", "emission": "auto""#, 5.0)];
    for (method, more, least) in methods {
        let parameters = |picks: &str| format!(r#"{{"light_picks": "{picks}"{more}}}"#);
        let [plain, auto] = ["importance", "auto"].map(|picks| mean_and_error(&scene, method, &parameters(picks), 4));
        assert!(learns_visibility(&scene, method, &parameters("auto")), "{method}: the pilot finds that it helps");
        assert_same(auto, plain, 0.0, &format!("{method}, visible picks and plain ones"));
        let alone = mean_and_error(&alone, method, &parameters("auto"), 4);
        assert_same(auto, alone, 0.01, &format!("{method}, with the lamp and without"));
        let [auto, plain, alone] = [auto, plain, alone].map(|[_, _, noise]| noise);
        assert!(auto * least < plain, "{method}: {auto} with visible picks, {plain} with plain ones");
        assert!(auto < 2.0 * alone, "{method}: {auto} with the lamp, {alone} without");
    }
}

/// A wall between two lamps, with a gap beside it; a glossy ball, a lamp without extent, and a faint sky.
const PARTED_ROOM: &str = "<sensor type='perspective'><float name='fov' value='26'/><transform name='to_world'>\
    <lookat origin='-3, 3.5, 4' target='0.5, 0, 1.2' up='0, 1, 0'/></transform><film type='hdrfilm'>\
    <integer name='width' value='20'/><integer name='height' value='20'/><rfilter type='box'/></film></sensor>\
    <shape type='rectangle'><bsdf type='diffuse'/><transform name='to_world'><scale value='4'/>\
    <rotate x='1' angle='-90'/></transform></shape>\
    <shape type='cube'><bsdf type='diffuse'/><transform name='to_world'><scale x='0.1' y='1' z='1.5'/>\
    <translate y='1' z='-1'/></transform></shape>\
    <shape type='sphere'><point name='center' value='-1, 0.5, 1'/><float name='radius' value='0.5'/>\
    <bsdf type='roughconductor'><float name='alpha' value='0.15'/></bsdf></shape>\
    <shape type='sphere'><point name='center' value='-2, 1.5, 0'/><float name='radius' value='0.3'/>\
    <emitter type='area'><rgb name='radiance' value='2, 3, 4'/></emitter></shape>\
    <shape type='sphere'><point name='center' value='2, 1.2, -1'/><float name='radius' value='0.3'/>\
    <emitter type='area'><rgb name='radiance' value='60, 40, 30'/></emitter></shape>\
    <emitter type='point'><point name='position' value='1, 0.5, -2'/><rgb name='intensity' value='9'/></emitter>\
    <emitter type='constant'><rgb name='radiance' value='0.1'/></emitter>";

/// All lights can be found by sampling, by hits and from both ends: weights must know how picks are made.
#[test]
fn weights_of_all_techniques_know_visible_picks() {
    let scene = Arc::new(prepare(PARTED_ROOM, &[]).expect("the scene is good"));
    let expected = mean_and_error(&scene, "path", r#"{"light_picks": "importance"}"#, 64);
    assert!(expected[1] < 0.006 * expected[0], "the test is blind: {expected:?}");
    for method in ["path", "bdpt", "vcm", "sppm", "ppm", "photon_map"] {
        let found = mean_and_error(&scene, method, r#"{"light_picks": "visible"}"#, 8);
        // The hit points of ppm stay where they are.
        let bias = match method {
            "path" | "bdpt" => 0.0,
            "ppm" => 0.04,
            _ => 0.02,
        };
        assert_same(found, expected, bias, &format!("{method} with visible picks, and path with plain ones"));
    }
}

/// Nothing is paid where nothing is hidden.
#[test]
fn lights_in_an_open_box_are_picked_by_importance() {
    for name in ["cornell-diffuse", "lantern", "furnace-closed"] {
        let scene = reference_scene(name);
        for method in ["path", "sppm"] {
            assert!(!learns_visibility(&scene, method, "{}"), "{name}, {method}");
        }
    }
}

#[test]
fn pictures_with_visible_picks_have_the_same_bits_from_any_number_of_threads() {
    let scene = repository_scene("sealed-lamp/scene.xml", "24");
    let bits = bits_of_threads(&scene, "path", "{}");
    assert!(learns_visibility(&scene, "path", "{}"));
    assert!(bits[0] == bits[1] && bits[1] == bits[2]);
}
