//! What is said of scenes that cannot be rendered as they are: short, and with a remedy that fits.

use std::path::Path;

use photonfarm::import::formats::{self, FORMATS};
use photonfarm::import::load_bytes;
use photonfarm::scene::Scene;
use photonfarm::scene::bundle::{Bundle, Files};
use serde_json::{Value, json};

use crate::gltf_file::{GltfFile, Numbers};

fn error(name: &str, text: &str, files: Files) -> String {
    let prepared = load_bytes(name, text.as_bytes(), &[]).and_then(|mut scene| {
        if !files.is_empty() {
            scene.bundle = Bundle::Archive(files.into());
        }
        Scene::prepare(&scene)
    });
    prepared.err().unwrap_or_else(|| panic!("{text} is no error")).to_string()
}

/// A triangle with these colors and this material.
fn triangle(colors: &[f32], material: Value) -> GltfFile {
    let mut file = GltfFile::new(json!({
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.3, "znear": 0.1, "aspectRatio": 1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [material],
    }));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]));
    file.accessor("VEC3", Numbers::F32(colors));
    file.accessor("SCALAR", Numbers::U16(&[0, 1, 2]));
    file
}

#[test]
fn numbers_in_messages_are_short() {
    let volume = |distance: f64| {
        json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": distance, "attenuationColor": [0.5, 1, 1]}}})
    };
    let message = |distance| error("a.gltf", &triangle(&[1.0; 9], volume(distance)).text(), Files::new());
    assert!(message(0.0).contains("\"attenuationDistance\" is 0; give a length above 0"), "{}", message(0.0));
    let sphere = |number: &str| {
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere'/>
            <emitter type='constant'><rgb name='radiance' value='{number}'/></emitter></scene>"
        );
        error("a.xml", &text, Files::new())
    };
    assert!(sphere("-1e300").contains("\"radiance\" is -1e300, -1e300, -1e300"), "{}", sphere("-1e300"));
    assert!(sphere("-1e-300").contains("is -1e-300"), "{}", sphere("-1e-300"));
    assert!(sphere("-12").contains("is -12, -12, -12"), "{}", sphere("-12"));
}

/// Help, errors and pages tell the same formats.
#[test]
fn all_formats_are_told() {
    let page = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name);
        std::fs::read_to_string(path).expect("the page is there")
    };
    let (rest, scenes) = (page("REST.md"), page("SCENES.md"));
    let told = formats::told();
    let refused = error("a.txt", "What is this?", Files::new());
    assert!(refused.ends_with(&format!("; give {told}")), "{refused}");
    for format in FORMATS {
        assert!(told.contains(format.name) && rest.contains(format.name), "{}", format.name);
        assert!(scenes.contains(&format!("`{}`", format.standard_name)), "{}", format.name);
    }
}

/// Only what is a number is shortened: names stand as their owner wrote them.
#[test]
fn names_of_digits_stay_as_they_are() {
    let digits = "1234567890123456789012345678901234567890";
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><emitter type='constant'/>
        <shape type='ply'><string name='filename' value='{digits}.ply'/></shape></scene>"
    );
    let found = error("a.xml", &text, Files::from([("other".to_owned(), b"".as_slice().into())]));
    assert!(found.contains(&format!("\"{digits}.ply\"")), "{found}");
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><emitter type='constant'/>
        <shape type='sphere'><float name='r{digits}' value='1'/></shape></scene>"
    );
    let found = error("a.xml", &text, Files::new());
    assert!(found.contains(&format!("\"r{digits}\"")), "{found}");
}

#[test]
fn lights_beyond_single_precision_are_named() {
    let text = "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere'/><emitter type='point'/>\n\
        <emitter type='constant'><rgb name='radiance' value='1e40'/></emitter></scene>";
    let found = error("a.xml", text, Files::new());
    assert!(
        found.starts_with("a.xml:2") && found.contains("sends more light than a number of 32 bits holds"),
        "{found}"
    );
}

#[test]
fn a_medium_that_is_too_dense_is_told_in_words_of_its_format() {
    let text = "LookAt 0 0 9  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nLightSource \"point\"\n\
        MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ SIGMA 1 1 ] \"rgb sigma_s\" [ 1 1 1 ]\n\
        MediumInterface \"fog\" \"\"\nMaterial \"interface\"\nShape \"sphere\"\n";
    for (sigma, expected) in
        [("1e29", "\"sigma_a\" and \"sigma_s\""), ("1e30", "is 1e30; give numbers of at least 0 and below 1e30")]
    {
        let found = error("a.pbrt", &text.replace("SIGMA", sigma), Files::new());
        assert!(found.starts_with("a.pbrt:5") && found.contains(expected), "{found}");
    }
}

#[test]
fn attributes_that_a_ply_file_cannot_have_are_told() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float heat_1\nproperty float heat_2\nproperty float heat_3\nproperty float heat_4\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n";
    let text = "<scene version='3.0.0'><sensor type='perspective'/><emitter type='constant'/><shape type='ply'>
        <string name='filename' value='a.ply'/><bsdf type='diffuse'><texture name='reflectance' type='mesh_attribute'>
        <string name='name' value='vertex_heat'/></texture></bsdf></shape></scene>";
    let found = error("a.xml", text, [("a.ply".to_owned(), ply.as_bytes().into())].into());
    assert!(found.contains("one property or three in a row") && found.contains("heat_1 to heat_3"), "{found}");
}

/// glTF 2.0, section 3.7.2.1: the components of colors are held to 0 to 1.
#[test]
fn vertex_colors_beyond_white_are_told() {
    for (colors, told) in [([0.5; 9], false), ([1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0], true)] {
        let file = triangle(&colors, json!({}));
        let scene = load_bytes("a.gltf", file.text().as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
        let found = scene.notices.iter().any(|notice| notice.subject == "a vertex color beyond 0 to 1");
        assert_eq!(found, told, "{:?}", scene.notices);
    }
}
