//! What users read when a glTF or GLB file is malformed, truncated or hostile; and that no damage makes the import panic.

use std::fmt::Write as _;

use crate::gltf_file::{GltfFile, Numbers};
use photonfarm::import::load_bytes;
use photonfarm::scene::error::Location;
use photonfarm::scene::geometry::ply;
use proptest::prelude::*;
use serde_json::{Value, json};

/// A good scene that uses most of what is read: JSON, with the buffer inside.
fn good() -> GltfFile {
    let mut file = GltfFile::new(json!({
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [
            {"mesh": 0, "rotation": [0, 0, 0, 1], "children": [3]},
            {"camera": 0, "translation": [0, 0, 5]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]}],
        "materials": [{"alphaMode": "BLEND", "pbrMetallicRoughness": {"roughnessFactor": 0.5, "baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 10497}],
        "images": [{"uri": "wood.png"}],
        "cameras": [{"perspective": {"yfov": 0.8, "aspectRatio": 1.5}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}}]}},
    }));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]));
    file.accessor("SCALAR", Numbers::U16(&[0, 1, 2]));
    let coordinates = file.accessor("VEC2", Numbers::U8(&[0, 0, 255, 0, 0, 255]));
    let [places, values] = [file.view(&[1]), file.view(&[9, 9])];
    let sparse =
        json!({"count": 1, "indices": {"bufferView": places, "componentType": 5121}, "values": {"bufferView": values}});
    file.change_accessor(coordinates, "sparse", sparse);
    file
}

fn error(bytes: &[u8]) -> String {
    match load_bytes("room", bytes, &[]) {
        Ok(_) => "no error".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// The errors of the good scene with the value at each JSON pointer replaced (or added).
fn report(changes: &[(&str, Value)]) -> String {
    let good: Value = serde_json::from_str(&good().text()).expect("just written");
    let mut report = String::new();
    for (pointer, value) in changes {
        let mut json = good.clone();
        let (parent, key) = pointer.rsplit_once('/').expect("a JSON pointer");
        match json.pointer_mut(parent).unwrap_or_else(|| panic!("{parent}")) {
            Value::Array(items) => items[key.parse::<usize>().expect("an index")] = value.clone(),
            object => object[key] = value.clone(),
        }
        let shown: String = value.to_string().chars().take(60).collect();
        writeln!(report, "{pointer} = {shown}\n    {}", error(json.to_string().as_bytes())).expect("a string grows");
    }
    report
}

#[test]
fn the_good_scene_is_good() {
    assert_eq!(error(good().text().as_bytes()), "no error");
    assert_eq!(error(&good().glb()), "no error");
}

#[test]
fn buffers_and_accessors_that_cannot_be() {
    insta::assert_snapshot!(report(&[
        ("/buffers/0/byteLength", json!(1000)),
        ("/buffers/0/byteLength", json!(9_000_000_000_000_000_u64)),
        ("/buffers/0/byteLength", json!(-1)),
        ("/buffers/0/byteLength", json!(1e300)),
        ("/buffers/0/uri", json!("data:application/octet-stream;base64,*")),
        ("/buffers/0/uri", json!("data:application/octet-stream,abc")),
        ("/buffers/0/uri", json!("missing.bin")),
        ("/buffers/0/uri", json!("../secret.bin")),
        ("/buffers/0/uri", json!("/etc/passwd")),
        ("/buffers/0/uri", json!("https://example.org/mesh.bin")),
        ("/buffers/0/uri", json!("generated/mesh.bin")),
        ("/buffers/0/uri", json!("100%.bin")),
        ("/buffers/0/uri", json!(5)),
        ("/bufferViews/0/byteLength", json!(35)),
        ("/bufferViews/0/byteLength", json!(9_000_000_000_000_000_u64)),
        ("/bufferViews/0/byteOffset", json!(9_000_000_000_000_000_u64)),
        ("/bufferViews/0/buffer", json!(1)),
        ("/bufferViews/0/byteStride", json!(0)),
        ("/bufferViews/0/byteStride", json!(9_000_000_000_000_000_u64)),
        ("/accessors/0/bufferView", json!(99)),
        ("/accessors/0/byteOffset", json!(4)),
        ("/accessors/0/count", json!(0)),
        ("/accessors/0/count", json!(-3)),
        ("/accessors/0/count", json!(2.5)),
        ("/accessors/0/count", json!(4_000_000_000_u64)),
        ("/accessors/0/count", json!(9_000_000_000_000_000_u64)),
        ("/accessors/0/componentType", json!(5124)),
        ("/accessors/0/type", json!("VEC4")),
        ("/accessors/1/componentType", json!(5122)),
        ("/accessors/0", json!({"count": 1_000_000_000, "componentType": 5126, "type": "VEC3"})),
        ("/accessors/2/sparse/count", json!(9_000_000_000_000_000_u64)),
        ("/accessors/2/sparse/indices/bufferView", json!(4)),
    ]));
}

#[test]
fn trees_that_cannot_be() {
    insta::assert_snapshot!(report(&[
        ("/asset/version", json!("1.0")),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"])),
        ("/extensionsRequired", json!(["ACME_everything"])),
        ("/scene", json!(1)),
        ("/scenes/0/nodes", json!([0, 0])),
        ("/scenes/0/nodes", json!([7])),
        ("/nodes/0/children", json!([0])),
        ("/nodes/3/children", json!([0])),
        ("/nodes/3/children", json!([1])),
        ("/nodes/0/mesh", json!(1)),
        ("/nodes/0/rotation", json!([0, 0, 0, 0])),
        ("/nodes/0/rotation", json!([0, 0, 1])),
        ("/nodes/0/matrix", json!([1, 0, 0])),
        ("/nodes/0/scale", json!("big")),
        ("/nodes/0", json!(5)),
        ("/nodes/1/camera", json!(1)),
        ("/nodes/2/extensions/KHR_lights_punctual/light", json!(1)),
        ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION", json!(1)),
        ("/meshes", json!(5)),
        ("/meshes/0/primitives", json!([5])),
        ("/meshes/0/primitives/0/mode", json!(7)),
        ("/meshes/0/primitives/0/material", json!(1)),
        ("/meshes/0/primitives/0/indices", json!(0)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(1)),
        ("/meshes/0/primitives/0/attributes/NORMAL", json!(99)),
        ("/cameras/0/perspective", json!({"aspectRatio": 1})),
        ("/cameras/0/perspective/aspectRatio", json!(0)),
        ("/cameras/0/perspective/yfov", json!("wide")),
        ("/extensions/KHR_lights_punctual/lights/0/type", json!("laser")),
        ("/extensions/KHR_lights_punctual/lights/0/intensity", json!(-1)),
        ("/extensions/KHR_lights_punctual/lights/0/color", json!([1, -1, 1])),
        ("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", json!(3)),
    ]));
}

#[test]
fn materials_that_cannot_be() {
    insta::assert_snapshot!(report(&[
        ("/materials/0/alphaMode", json!("GLASS")),
        ("/materials/0/doubleSided", json!(1)),
        ("/materials/0/emissiveFactor", json!([1, 1])),
        ("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(2)),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", json!([1, 1, 1])),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({})),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(1)),
        ("/textures/0/source", json!(1)),
        ("/textures/0/sampler", json!(1)),
        ("/samplers/0/wrapS", json!(1)),
        ("/images/0/uri", json!("../../wood.png")),
        ("/images/0/uri", json!("data:image/png;base64,???")),
        ("/materials/0/extensions", json!({"KHR_materials_ior": {"ior": -1}})),
        ("/materials/0/extensions", json!({"KHR_materials_transmission": {"transmissionFactor": 2}})),
        ("/materials/0/extensions", json!([1])),
    ]));
}

#[test]
fn meshes_that_cannot_be() {
    let mut report = String::new();
    for (what, position, bytes) in [
        ("a position that is not a number", 4, f32::NAN.to_le_bytes().to_vec()),
        ("a position that is infinite", 8, f32::INFINITY.to_le_bytes().to_vec()),
        ("an index out of range", 38, 3_u16.to_le_bytes().to_vec()),
        ("a sparse index out of range", 52, vec![3]),
    ] {
        let mut file = good();
        file.buffer[position..position + bytes.len()].copy_from_slice(&bytes);
        writeln!(report, "{what}\n    {}", error(file.text().as_bytes())).expect("a string grows");
    }
    insta::assert_snapshot!(report);
}

#[test]
fn containers_that_cannot_be() {
    let glb = good().glb();
    let changed = |position: usize, value: u8| {
        let mut bytes = glb.clone();
        bytes[position] = value;
        bytes
    };
    let mut report = String::new();
    for (what, bytes) in [
        ("version 1", changed(4, 1)),
        ("longer than the file", changed(10, 1)),
        ("a chunk longer than the file", changed(14, 255)),
        ("no JSON", changed(16, b'X')),
        ("broken JSON", changed(20, b'[')),
        ("no binary chunk", glb[..glb.len() - 8 - good().buffer.len().next_multiple_of(4)].to_vec()),
        ("only the magic", b"glTF".to_vec()),
        ("a key twice", b"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [], \"nodes\": []}".to_vec()),
        ("numbers out of range", b"{\"asset\": {\"version\": \"2.0\"}, \"scene\": 1e999}".to_vec()),
        ("deep", format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"extras\": {}", "[".repeat(100_000)).into_bytes()),
    ] {
        writeln!(report, "{what}\n    {}", error(&bytes)).expect("a string grows");
    }
    insta::assert_snapshot!(report);
    // The padding of the last chunk may be missing.
    for length in 4..glb.len() - 3 {
        assert_ne!(error(&glb[..length]), "no error", "cut off after {length} bytes");
    }
}

#[test]
fn a_bomb_of_nodes_is_refused() {
    // Two hundred nodes of a thousand and one primitives each: a small file, many shapes.
    let primitive = json!({"attributes": {"POSITION": 0}});
    let mut file = GltfFile::new(json!({
        "nodes": vec![json!({"mesh": 0}); 200],
        "meshes": [{"primitives": vec![primitive; 1001]}],
    }));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]));
    let message = error(file.text().as_bytes());
    assert_eq!(
        message,
        "room (nodes[199]): from here on the scene has more than 200000 shapes; join meshes, or split the scene"
    );
}

#[test]
fn endless_lists_are_refused() {
    let head = "{\"asset\": {\"version\": \"2.0\"}";
    let twice = format!("{head}, \"nodes\": [{{}}], \"scenes\": [{{\"nodes\": [0{}]}}]}}", ",0".repeat(1_000_000));
    let message = "room (scenes[0].nodes): the list has 1000001 items; split the scene: at most 1000000 are read";
    assert_eq!(error(twice.as_bytes()), message);
    let nodes = format!("{head}, \"nodes\": [0{}]}}", ",0".repeat(1_000_000));
    let message = "room (nodes): the list has 1000001 items; split the scene: at most 1000000 are read";
    assert_eq!(error(nodes.as_bytes()), message);
}

/// What an import promises of a file that it accepts: every mesh that it made can be read.
fn check(bytes: &[u8]) {
    let Ok(scene) = load_bytes("room", bytes, &[]) else { return };
    for (name, mesh) in scene.bundle.generated().into_iter().flat_map(|made| &made.meshes) {
        let location = Location { file: name.clone(), ..Location::default() };
        let read = ply::read(&ply::write(mesh), &location).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read, **mesh);
    }
}

proptest! {
    #[test]
    fn damaged_files_never_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)) {
        let (mut binary, mut text) = (good().glb(), good().text().into_bytes());
        for (position, value) in &edits {
            *position.get_mut(&mut binary[..]) = *value;
            *position.get_mut(&mut text[..]) = *value;
        }
        check(&binary);
        check(&text);
    }

    #[test]
    fn numbers_in_the_wrong_place_never_panic(place in any::<prop::sample::Index>(), value in prop::sample::select(
        vec!["0", "1", "-1", "3", "255", "65536", "4294967296", "9007199254740993", "1e300", "null", "\"2\"", "[]", "{}"],
    )) {
        // Each run of digits in the JSON outside of strings gets the value in its turn.
        let text = good().text();
        let starts: Vec<usize> = (1..text.len())
            .filter(|at| text.as_bytes()[*at].is_ascii_digit() && b":,[".contains(&text.as_bytes()[at - 1]))
            .collect();
        let start = *place.get(&starts);
        let length = text[start..].find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(0);
        check(format!("{}{value}{}", &text[..start], &text[start + length..]).as_bytes());
    }
}
