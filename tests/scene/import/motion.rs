//! Things that move, at a moment: Mitsuba's `<animation>`, glTF's animations, pbrt's two transforms.

use glam::{DMat4, DQuat, DVec3};
use photonfarm::import::changes::{Changes, with_changes};
use photonfarm::import::load_bytes;
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value};
use serde_json::{Value as Json, json};

use crate::gltf_file::{GltfFile, Numbers};

/// A scene at a moment, or without one.
fn at(scene: &[u8], time: Option<f64>) -> SceneDescription {
    let changed = with_changes(scene, &Changes { time, ..Changes::default() }).expect("packs");
    load_bytes("scene", &changed, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Where the only plugin of a class stands.
fn place(scene: &SceneDescription, class: PluginClass) -> DMat4 {
    let is_one = |node: &&Node| node.class == class;
    let node = scene.root.children.iter().map(|child| child.node.as_ref()).find(is_one).expect("there is one");
    match node.parameters.iter().find(|parameter| parameter.name == "to_world").map(|parameter| &parameter.value) {
        Some(Value::Transform(place)) => *place,
        _ => DMat4::IDENTITY,
    }
}

fn assert_place(scene: &SceneDescription, class: PluginClass, expected: DMat4) {
    let found = place(scene, class);
    assert!(found.abs_diff_eq(expected, 1e-6), "{found} instead of {expected}");
}

fn told(scene: &SceneDescription) -> String {
    scene.notices.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

#[test]
fn key_frames_of_mitsuba() {
    let scene = |version: &str, name: &str| {
        format!(
            "<scene version='{version}'><sensor type='perspective'><animation name='{name}'>
            <transform time='1'><translate z='-5'/></transform><transform time='3'><translate z='-9' x='2'/></transform>
            </animation></sensor><shape type='sphere'><emitter type='area'/></shape></scene>"
        )
    };
    for (version, name) in [("3.0.0", "to_world"), ("0.6.0", "toWorld")] {
        let text = scene(version, name);
        let still = at(text.as_bytes(), None);
        assert_eq!(still.moves, Some([1.0, 3.0]));
        assert!(told(&still).contains("the <animation> is approximated"), "{}", told(&still));
        assert_place(&still, PluginClass::Sensor, DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0)));
        for (time, z) in [(0.0, -5.0), (2.0, -7.0), (3.0, -9.0), (4.0, -9.0)] {
            let moved = at(text.as_bytes(), Some(time));
            let expected = DMat4::from_translation(DVec3::new((-5.0 - z) / 2.0, 0.0, z));
            assert_place(&moved, PluginClass::Sensor, expected);
            assert!(!told(&moved).contains("animation"), "{}", told(&moved));
        }
    }
    let nothing = "<scene version='3.0.0'><sensor type='perspective'/><emitter type='constant'/></scene>";
    assert!(told(&at(nothing.as_bytes(), Some(1.0))).contains("the moment 1 is ignored: nothing in the scene moves"));
    let twice = scene("3.0.0", "to_world").replace("time='3'", "time='1'");
    let error = load_bytes("room.xml", twice.as_bytes(), &[]).expect_err("two key frames at one time").to_string();
    assert!(error.contains("the key frame at 1 stands behind that at 1"), "{error}");
}

/// A triangle whose node is moved by one sampler for each path.
fn animated(tracks: &[(&str, &str, &[f32])]) -> Vec<u8> {
    // The accessors below: positions, times, and the values of each track.
    let sampler = |(index, (_, interpolation, _)): (usize, &(&str, &str, &[f32]))| json!({"input": 1, "output": 2 + index, "interpolation": interpolation});
    let channel = |(index, (path, ..)): (usize, &(&str, &str, &[f32]))| json!({"sampler": index, "target": {"node": 0, "path": path}});
    let samplers: Vec<Json> = tracks.iter().enumerate().map(sampler).collect();
    let channels: Vec<Json> = tracks.iter().enumerate().map(channel).collect();
    let mut file = GltfFile::new(json!({
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0, 0, 7]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"channels": channels, "samplers": samplers}],
    }));
    file.accessor("VEC3", Numbers::F32(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    file.accessor("SCALAR", Numbers::F32(&[1.0, 2.0]));
    for (path, _, values) in tracks {
        file.accessor(if *path == "rotation" { "VEC4" } else { "VEC3" }, Numbers::F32(values));
    }
    file.text().into_bytes()
}

#[test]
fn animations_of_gltf() {
    let quarter = DQuat::from_rotation_z(90_f64.to_radians()).to_array().map(|number| number as f32);
    let turns = [[0.0, 0.0, 0.0, 1.0].as_slice(), &quarter].concat();
    let file = animated(&[("translation", "LINEAR", &[0.0, 0.0, 1.0, 4.0, 0.0, 1.0]), ("rotation", "LINEAR", &turns)]);
    let rest = at(&file, None);
    assert_eq!(rest.moves, Some([1.0, 2.0]));
    assert_place(&rest, PluginClass::Shape, DMat4::from_translation(DVec3::new(0.0, 0.0, 7.0)));
    assert!(told(&rest).contains("every node stands where it rests"));
    for (time, share) in [(0.0, 0.0), (1.25, 0.25), (2.0, 1.0), (5.0, 1.0)] {
        let turn = DQuat::from_rotation_z(share * 90_f64.to_radians());
        let expected = DMat4::from_rotation_translation(turn, DVec3::new(4.0 * share, 0.0, 1.0));
        assert_place(&at(&file, Some(time)), PluginClass::Shape, expected);
    }
    let step = animated(&[("translation", "STEP", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0])]);
    for (time, x) in [(1.99, 1.0), (2.0, 2.0)] {
        assert_place(&at(&step, Some(time)), PluginClass::Shape, DMat4::from_translation(DVec3::X * x));
    }
    // Tangents of 3 a second at both ends of a way of 1.
    let tangents =
        [[3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    let cubic = animated(&[("translation", "CUBICSPLINE", tangents.as_flattened())]);
    for time in [1.0, 1.25, 1.5, 2.0] {
        let s: f64 = time - 1.0;
        let x = 3.0 * s - 6.0 * s * s + 4.0 * s * s * s;
        assert_place(&at(&cubic, Some(time)), PluginClass::Shape, DMat4::from_translation(DVec3::X * x));
    }
    let cut = animated(&[("translation", "LINEAR", &[0.0, 0.0, 0.0])]);
    let changed = with_changes(&cut, &Changes { time: Some(1.0), ..Changes::default() }).expect("packs");
    let error = load_bytes("scene", &changed, &[]).expect_err("a value is missing").to_string();
    assert!(error.contains("1 values do not fit 2 times"), "{error}");
}

#[test]
fn motion_of_pbrt() {
    let text = "TransformTimes 2 4\nActiveTransform EndTime\nTranslate 0 -6 0\nActiveTransform All\nCamera \"perspective\"\nWorldBegin\n\
        LightSource \"infinite\"\nAttributeBegin\nActiveTransform StartTime\nTranslate 1 0 3\nActiveTransform EndTime\nTranslate 3 0 3\n\
        ActiveTransform All\nScale 2 2 2\nShape \"sphere\"\nAttributeEnd\n";
    let still = at(text.as_bytes(), None);
    assert_eq!(still.moves, Some([2.0, 4.0]));
    assert!(told(&still).contains("the motion between two keyframes"));
    for (time, x) in [(None, 1.0), (Some(2.0), 1.0), (Some(3.0), 2.0), (Some(4.0), 3.0), (Some(9.0), 3.0)] {
        let scene = at(text.as_bytes(), time);
        let expected = DMat4::from_translation(DVec3::new(x, 0.0, 3.0)) * DMat4::from_scale(DVec3::splat(2.0));
        assert_place(&scene, PluginClass::Shape, expected);
        // The world moves down before the camera: the camera moves up.
        let up = place(&scene, PluginClass::Sensor).w_axis.truncate();
        assert!(up.abs_diff_eq(DVec3::Y * 3.0 * (x - 1.0), 1e-9), "{up}");
        assert_eq!(told(&scene).contains("the motion"), time.is_none());
    }
    let error = load_bytes("a.pbrt", b"TransformTimes 1 1\nWorldBegin\n", &[]).expect_err("no time passes").to_string();
    assert!(error.contains("the motion ends before it starts"), "{error}");
}
