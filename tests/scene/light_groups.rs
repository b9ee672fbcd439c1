//! Light groups: every format and every kind of emitter names them, and names that cannot be are refused.

use serde_json::json;

use crate::gltf_file::GltfFile;
use crate::scene_files::{exr_file, prepare};
use photonfarm::import::load_bytes;
use photonfarm::scene::Scene;

const VIEW: &str = "<sensor type='perspective'><transform name='to_world'><lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/>\
    </transform></sensor><shape type='rectangle'/>";

fn groups(scene: &Scene) -> Vec<&str> {
    scene.lights.groups().names().iter().map(String::as_str).collect()
}

fn named(name: &str) -> String {
    format!("<string name='light_group' value='{name}'/>")
}

#[test]
fn every_kind_of_emitter_names_a_group() {
    let spectrum = "<rgb name='irradiance' value='1'/>";
    let sky = exr_file(8, 4, |_, _| [1.0; 3]);
    let ies = "IESNA:LM-63-1995\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 100\n0 90\n0\n100 50\n";
    let files: [(&str, &[u8]); 2] = [("sky.exr", &sky), ("lamp.ies", ies.as_bytes())];
    let image = "<texture type='bitmap' name='irradiance'><string name='filename' value='sky.exr'/></texture>";
    let standing = [
        ("point", ""),
        ("spot", ""),
        ("projector", image),
        ("ies", "<string name='filename' value='lamp.ies'/>"),
        ("directional", spectrum),
        ("constant", ""),
        ("envmap", "<string name='filename' value='sky.exr'/>"),
        ("sunsky", "<vector name='sun_direction' value='0, 0.6, 0.8'/>"),
        ("timed_sunsky", ""),
    ];
    for (kind, parameters) in standing {
        let scene = prepare(&format!("{VIEW}<emitter type='{kind}'>{parameters}{}</emitter>", named("key")), &files);
        let scene = scene.unwrap_or_else(|error| panic!("{kind}: {error}"));
        assert_eq!(groups(&scene), ["key"], "{kind}");
    }
    for kind in ["area", "directionalarea"] {
        let lamp = format!("{VIEW}<shape type='rectangle'><emitter type='{kind}'>{}</emitter></shape>", named("key"));
        assert_eq!(groups(&prepare(&lamp, &[]).unwrap_or_else(|error| panic!("{kind}: {error}"))), ["key"], "{kind}");
    }
}

#[test]
fn groups_come_as_they_are_named_and_others_last() {
    let point = |group: &str| format!("<emitter type='point'>{group}</emitter>");
    let lights = |names: &[&str]| names.iter().map(|name| point(&named(name))).collect::<String>();
    let found = |body: &str| {
        let scene = prepare(&format!("{VIEW}{body}"), &[]).unwrap_or_else(|error| panic!("{error}"));
        groups(&scene).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(found(&lights(&["rim", "key", "rim"])), ["rim", "key"]);
    assert_eq!(found(&(point("") + &lights(&["rim", "key"]))), ["rim", "key", "others"]);
    assert_eq!(found(&lights(&["others", "rim"])), ["rim", "others"], "lights without a name are others, too");
    assert_eq!(found(&point("")), ["others"]);
}

#[test]
fn names_that_cannot_be_are_refused() {
    let long = "a".repeat(65);
    for name in ["", "key light", "key.R", "schlüssel", "a/b", long.as_str()] {
        let scene = prepare(&format!("{VIEW}\n<emitter type='point'>\n{}</emitter>", named(name)), &[]);
        let error = scene.err().unwrap_or_else(|| panic!("{name:?} is taken")).to_string();
        assert!(error.starts_with("test.xml:3 ("), "{error}");
        assert!(
            error.contains("\"light_group\" is ")
                && error.ends_with("give 1 to 64 letters from a to z, digits, _ or -"),
            "{error}"
        );
    }
    for (one, other) in [("key", "Key"), ("Others", "rim")] {
        let body = format!(
            "{VIEW}<emitter type='point'>{}</emitter>\n<emitter type='spot'>{}</emitter>",
            named(one),
            named(other)
        );
        let error = prepare(&body, &[]).err().expect("they differ only by case").to_string();
        assert!(error.contains("differ only by case; write both alike, or call one something else"), "{error}");
        assert!(error.starts_with(if one == "key" { "test.xml:2 (" } else { "test.xml:1 (" }), "{error}");
    }
    let number = "<emitter type='point'><integer name='light_group' value='3'/></emitter>";
    let error = prepare(&format!("{VIEW}{number}"), &[]).err().expect("a number is no name").to_string();
    assert!(error.contains("\"light_group\" is a integer where a string belongs"), "{error}");
}

#[test]
fn pbrt_lights_name_groups() {
    let text = "Camera \"perspective\"\nWorldBegin\nLightSource \"point\" \"string light_group\" \"key\"\n\
        LightSource \"infinite\" \"string light_group\" \"sky\"\nAreaLightSource \"diffuse\" \"string light_group\" \"lamp\"\nShape \"sphere\"\n";
    let description = load_bytes("scene.pbrt", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = Scene::prepare(&description).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(groups(&scene), ["lamp", "key", "sky"]);
}

#[test]
fn extras_of_gltf_name_groups() {
    let in_extras = |group: &str| json!({"light_group": group});
    let light = |extras: serde_json::Value| json!({"type": "point", "extras": extras});
    let on = |index: usize| json!({"KHR_lights_punctual": {"light": index}});
    let file = GltfFile::with_triangle(json!({
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [light(in_extras("key")), light(json!("a note"))]}},
        "materials": [{"emissiveFactor": [1, 1, 1], "extras": in_extras("glow")}],
        "nodes": [
            {"mesh": 0},
            {"extensions": on(0), "extras": in_extras("passed over")},
            {"extensions": on(1), "extras": in_extras("rim")},
            {"extensions": on(1)},
        ],
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "scene": 0,
    }));
    let mut json: serde_json::Value = serde_json::from_str(&file.text()).expect("JSON");
    json["meshes"][0]["primitives"][0]["material"] = 0.into();
    let description =
        load_bytes("scene.gltf", json.to_string().as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = Scene::prepare(&description).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(groups(&scene), ["glow", "key", "rim", "others"]);
}
