//! Shapes and materials are called what their files call them.

use photonfarm::import::load_bytes;
use photonfarm::scene::Scene;
use serde_json::json;

use crate::gltf_file::GltfFile;

/// The names of all objects, and those of all materials.
fn names(file: &str, text: &str) -> [Vec<String>; 2] {
    let description = load_bytes(file, text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let names = Scene::prepare(&description).unwrap_or_else(|error| panic!("{error}")).names;
    [names.unique_objects().names, names.unique_materials().names]
}

#[test]
fn gltf_things_have_the_names_of_nodes_and_materials() {
    let file = GltfFile::with_triangle(json!({
        "nodes": [
            {"name": "tür \"1\"", "mesh": 0, "translation": [0, 0, -3]},
            {"name": "leaf", "mesh": 0, "translation": [1, 0, -3]},
            {"name": "leaf", "mesh": 0, "translation": [2, 0, -3]},
            {"mesh": 1, "translation": [3, 0, -3]},
        ],
        "materials": [{"name": "type"}, {}],
    }));
    let text = file.text();
    let mut json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let attributes = json!({"POSITION": 0});
    json["meshes"] = json!([
        {"primitives": [{"attributes": attributes, "material": 0}, {"attributes": attributes, "material": 1}]},
        {"name": "triangle", "primitives": [{"attributes": attributes}]},
    ]);
    let [objects, materials] = names("scene.gltf", &json.to_string());
    assert_eq!(objects, ["tür \"1\"", "leaf", "triangle"]);
    assert_eq!(materials, ["type", "material_1", "default_material"]);
}

#[test]
fn pbrt_things_have_the_names_of_materials_and_objects() {
    let text = "Camera \"perspective\"\nWorldBegin\nLightSource \"point\" \"rgb I\" [ 1 2 3 ]\n\
        MakeNamedMaterial \"gold leaf\" \"string type\" \"conductor\"\nMaterial \"diffuse\"\n\
        ObjectBegin \"ball\"\nNamedMaterial \"gold leaf\"\nShape \"sphere\"\nObjectEnd\n\
        Translate 0 0 5\nShape \"sphere\"\nMaterial \"diffuse\"\nTranslate 3 0 0\nShape \"sphere\"\n\
        Translate 3 0 0\nObjectInstance \"ball\"\nTranslate 3 0 0\nObjectInstance \"ball\"\n";
    let [objects, materials] = names("scene.pbrt", text);
    assert_eq!(objects.iter().filter(|name| *name == "ball").count(), 1, "{objects:?}");
    assert_eq!(objects.iter().filter(|name| name.starts_with("shape ")).count(), 2, "{objects:?}");
    // Materials without names are told apart, also where they are of one kind.
    let made_up = materials.iter().filter(|name| name.ends_with("-diffuse")).count();
    assert!(materials.contains(&"gold leaf".to_owned()) && made_up == 2 && materials.len() == 3, "{materials:?}");
}
