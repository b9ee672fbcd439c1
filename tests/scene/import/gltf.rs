//! glTF and GLB files come out as the tree they mean, and bad ones as errors with their place.

use std::fs;

use crate::gltf_file::{GltfFile, Numbers};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DMat4, DVec3, Vec3};
use photonfarm::import::{load_bytes, load_file, pack};
use photonfarm::math::Vec2;
use photonfarm::scene::Scene;
use photonfarm::scene::camera::{self, Camera};
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value as Plain};
use photonfarm::scene::error::Location;
use photonfarm::scene::fields::Fields;
use photonfarm::scene::geometry::{Ray, ply, triangle_mesh::TriangleMesh};
use serde_json::{Value, json};

fn load(file: &GltfFile) -> SceneDescription {
    load_text(&file.text())
}

fn load_text(text: &str) -> SceneDescription {
    load_bytes("scene.gltf", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn all(scene: &SceneDescription, class: PluginClass) -> Vec<&Node> {
    let nodes = scene.root.children.iter().map(|child| child.node.as_ref());
    nodes.filter(|node| node.class == class).collect()
}

fn parameter<'a>(node: &'a Node, name: &str) -> &'a Plain {
    &node.parameters.iter().find(|parameter| parameter.name == name).expect(name).value
}

fn number(node: &Node, name: &str) -> f64 {
    match parameter(node, name) {
        Plain::Float(number) => *number,
        Plain::Integer(number) => *number as f64,
        other => panic!("{other:?}"),
    }
}

fn to_world(node: &Node) -> DMat4 {
    match node.parameters.iter().find(|parameter| parameter.name == "to_world").map(|parameter| &parameter.value) {
        Some(Plain::Transform(matrix)) => *matrix,
        None => DMat4::IDENTITY,
        other => panic!("{other:?}"),
    }
}

fn file_name(shape: &Node) -> &str {
    match parameter(shape, "filename") {
        Plain::String(name) => name,
        other => panic!("{other:?}"),
    }
}

fn mesh(scene: &SceneDescription, shape: &Node) -> TriangleMesh {
    let bytes = scene.bundle.read(file_name(shape), &Location::default()).expect("the file is in the bundle");
    ply::read(&bytes, &Location::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn notices(scene: &SceneDescription) -> String {
    scene.notices.iter().map(|notice| format!("{notice}\n")).collect()
}

/// The tree as indented text.
fn outline(node: &Node, slot: &str, depth: usize, text: &mut String) {
    let indent = "  ".repeat(depth);
    let id = if node.id.is_empty() { String::new() } else { format!(" #{}", node.id) };
    let slot = if slot.is_empty() { String::new() } else { format!("{slot}: ") };
    text.push_str(&format!("{indent}{slot}{} {}{id}\n", node.class.tag(), node.plugin));
    for parameter in &node.parameters {
        text.push_str(&format!("{indent}  {} = {:?}\n", parameter.name, parameter.value));
    }
    for child in &node.children {
        outline(&child.node, &child.name, depth + 1, text);
    }
}

#[test]
fn a_glb_with_one_triangle_and_a_camera() {
    let file = GltfFile::with_triangle(json!({
        "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0.0, 0.0, 5.0]}],
        "cameras": [{"type": "perspective", "perspective":
            {"yfov": 1.0, "aspectRatio": 2.0, "znear": 0.1, "zfar": 100.0}}],
    }));
    let scene = load_bytes("room.glb", &file.glb(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut text = String::new();
    outline(&scene.root, "", 0, &mut text);
    insta::assert_snapshot!(format!("{text}\n{}", notices(&scene)));
    let read = mesh(&scene, all(&scene, PluginClass::Shape)[0]);
    assert_eq!(read.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(read.triangles, [[0, 1, 2]]);
}

fn prepared_camera(scene: &SceneDescription, width: u32, height: u32) -> Camera {
    let sensors = all(scene, PluginClass::Sensor);
    let mut fields = Fields::new(sensors[0]);
    camera::read(&mut fields, [width, height]).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn known_points_stand_at_the_expected_pixels() {
    let camera = |node: Value| {
        let file = GltfFile::with_triangle(json!({
            "nodes": [{"mesh": 0}, node],
            "cameras": [{"perspective": {"yfov": std::f64::consts::FRAC_PI_2, "aspectRatio": 4.0 / 3.0}}],
        }));
        let scene = load(&file);
        let film = &all(&scene, PluginClass::Sensor)[0].children[0].node;
        assert_eq!((number(film, "width"), number(film, "height")), (768.0, 576.0));
        prepared_camera(&scene, 768, 576)
    };
    // From (0, 0, 5) along -z, (1, 2, 0) is 1/(4/3·5) of the half width to the right and 2/5 of the half height up.
    let straight = camera(json!({"camera": 0, "translation": [0, 0, 5]}));
    let ray = straight.ray(Vec2::new(0.5 + 0.5 * 0.15, 0.5 - 0.5 * 0.4), [0.5; 2]);
    assert!(ray.direction.distance(Vec3::new(1.0, 2.0, -5.0).normalize()) < 1e-6, "{:?}", ray.direction);
    assert!(straight.position().distance(Vec3::new(0.0, 0.0, 5.0)) < 1e-6);
    // A quarter turn about y (and a scale, which cameras ignore): it looks along -x, and -z is to its right.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = camera(json!({"camera": 0, "rotation": [0, half, 0, half], "scale": [2, 2, 2]}));
    let ray = turned.ray(Vec2::new(0.5 + 0.5 * 0.15, 0.5 - 0.5 * 0.4), [0.5; 2]);
    assert!(ray.direction.distance(Vec3::new(-5.0, 2.0, -1.0).normalize()) < 1e-6, "{:?}", ray.direction);
}

#[test]
fn a_missing_camera_frames_everything() {
    let file = GltfFile::with_triangle(json!({
        "nodes": [{"mesh": 0, "translation": [10, 0, 0]}, {"mesh": 0, "scale": [3, 7, 1]}],
    }));
    let scene = load(&file);
    assert!(notices(&scene).contains("the missing camera is approximated"));
    let sensor = all(&scene, PluginClass::Sensor)[0];
    let to_camera = to_world(sensor).inverse();
    let most = (0.5 * number(sensor, "fov")).to_radians().tan();
    for shape in all(&scene, PluginClass::Shape) {
        for position in mesh(&scene, shape).positions {
            let world = to_world(shape).transform_point3(Vec3::from_array(position).as_dvec3());
            let seen = to_camera.transform_point3(world);
            assert!(seen.z > number(sensor, "near_clip") && seen.z < number(sensor, "far_clip"));
            assert!(seen.x.abs().max(seen.y.abs()) < most * seen.z, "{world} is at {seen}");
        }
    }
}

#[test]
fn punctual_lights_shine_along_minus_z() {
    let file = GltfFile::with_triangle(json!({
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "color": [1.0, 0.5, 0.25], "intensity": 8.0, "range": 3.0},
            {"type": "spot", "intensity": 2.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
            {"type": "directional", "intensity": 3.0},
        ]}},
        "nodes": [
            {"mesh": 0},
            {"translation": [1, 2, 3], "children": [2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"translation": [1, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"rotation": [0, 1, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 2}}},
        ],
    }));
    let scene = load(&file);
    let lights = all(&scene, PluginClass::Emitter);
    let [point, spot, sun] = lights[..] else { panic!("{} lights", lights.len()) };
    assert_eq!(point.plugin, "point");
    assert_eq!(*parameter(point, "position"), Plain::Vector([1.0, 2.0, 3.0]));
    assert_eq!(*parameter(point, "intensity"), Plain::Rgb([8.0, 4.0, 2.0]));
    assert_eq!(spot.plugin, "spot");
    assert_eq!(to_world(spot).transform_point3(DVec3::ZERO), DVec3::new(2.0, 2.0, 3.0));
    assert_eq!(to_world(spot).transform_vector3(DVec3::Z), DVec3::NEG_Z);
    assert!((number(spot, "beam_width") - 0.1_f64.to_degrees()).abs() < 1e-9);
    assert!((number(spot, "cutoff_angle") - 0.2_f64.to_degrees()).abs() < 1e-9);
    assert_eq!(sun.plugin, "directional");
    assert_eq!(*parameter(sun, "irradiance"), Plain::Rgb([3.0; 3]));
    // Turned half about y, minus z is plus z.
    assert!(to_world(sun).transform_vector3(DVec3::Z).distance(DVec3::Z) < 1e-12);
    for subject in ["the unit of lights", "the range of a light", "the edge of a spot light"] {
        assert!(notices(&scene).contains(subject), "{subject}");
    }
}

/// A scene of the triangle with one material, and the images and textures that it may use.
fn with_material(material: &Value) -> GltfFile {
    GltfFile::with_triangle(json!({
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [material],
        "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33071}],
        "images": [{"uri": "maps/wood%20grain.png"}, {"uri": "rough.jpg"}],
        "textures": [{"source": 0}, {"source": 1, "sampler": 0}],
    }))
}

fn bsdf_of(material: &Value) -> (String, String) {
    let scene = load(&with_material(material));
    let mut text = String::new();
    outline(all(&scene, PluginClass::Bsdf)[0], "", 0, &mut text);
    for child in &all(&scene, PluginClass::Shape)[0].children {
        if [PluginClass::Emitter, PluginClass::Medium].contains(&child.node.class) {
            outline(&child.node, "", 0, &mut text);
        }
    }
    // The camera is another test's.
    let notices =
        notices(&scene).lines().filter(|line| !line.contains("camera")).map(|line| format!("{line}\n")).collect();
    (text, notices)
}

#[test]
fn materials() {
    let cases = [
        ("default", json!({})),
        (
            "textured and two-sided",
            json!({"doubleSided": true, "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.6, 0.7, 1.0], "baseColorTexture": {"index": 0},
                "metallicFactor": 0.0, "roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 1}},
                "normalTexture": {"index": 1, "scale": 0.5}, "occlusionTexture": {"index": 0}}),
        ),
        ("mask", json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})),
        (
            "blend",
            json!({"alphaMode": "BLEND", "doubleSided": true,
                "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25], "metallicFactor": 0}}),
        ),
        (
            "glass",
            json!({"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1.0},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0, 0]},
                "KHR_materials_ior": {"ior": 1.7}}}),
        ),
        (
            "thin wall",
            json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": {"index": 1}}}}),
        ),
        (
            "coat and specular",
            json!({"extensions": {
                "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.1, "clearcoatTexture": {"index": 1}},
                "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 1, 1]},
                "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0]}}}),
        ),
        (
            "light",
            json!({"doubleSided": true, "emissiveFactor": [1, 0.5, 0], "emissiveTexture": {"index": 0},
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}}}),
        ),
        ("unlit", json!({"extensions": {"KHR_materials_unlit": {}}})),
        (
            "mirror of specular and glossiness",
            json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"specularFactor": [1, 1, 1], "glossinessFactor": 1}}}),
        ),
        (
            "matte of specular and glossiness",
            json!({"extensions": {"KHR_materials_pbrSpecularGlossiness":
                {"diffuseFactor": [0.5, 0.25, 0.125, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0}}}),
        ),
    ];
    let mut report = String::new();
    for (what, material) in &cases {
        let (text, notices) = bsdf_of(material);
        report.push_str(&format!("== {what}\n{text}{notices}\n"));
    }
    insta::assert_snapshot!(report);
}

#[test]
fn thick_glass_is_a_dielectric() {
    let mut file = json!({
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "extensions": {"NV_materials_mdl": {"shaders": [{"definition": "mdl::core::thick_glass"}]}},
        "materials": [{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.05]},
            "extensions": {"NV_materials_mdl": {"mdl_shader": 0}}}],
    });
    let scene = load(&GltfFile::with_triangle(file.clone()));
    let glass = all(&scene, PluginClass::Bsdf)[0];
    assert_eq!((glass.plugin.as_str(), number(glass, "int_ior")), ("dielectric", 1.5));
    assert!(notices(&scene).contains("MDL's thick_glass is approximated"));
    file["extensions"]["NV_materials_mdl"]["shaders"][0]["definition"] = json!("mdl::core::flex_material");
    let scene = load(&GltfFile::with_triangle(file));
    assert_eq!(all(&scene, PluginClass::Bsdf)[0].plugin, "mask");
    assert!(notices(&scene).contains("an MDL shader is ignored"));
}

#[test]
fn a_texture_transform_is_the_one_of_the_specification() {
    // The example of KHR_texture_transform: "only the lower left quadrant of the source image, rotated clockwise 90°".
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {
        "KHR_texture_transform": {"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]}}}}});
    let scene = load(&with_material(&material));
    let bitmap = &all(&scene, PluginClass::Bsdf)[0].children[0].node;
    let Plain::Transform(to_uv) = parameter(bitmap, "to_uv") else { panic!("no transform") };
    // v grows downwards: the lower left quadrant has u from 0 to 0.5 and v from 0.5 to 1.
    for (from, to) in
        [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0]), ([1.0, 1.0], [0.5, 0.5])]
    {
        let uv = to_uv.transform_point3(DVec3::new(from[0], from[1], 0.0));
        assert!(uv.distance(DVec3::new(to[0], to[1], 0.0)) < 1e-12, "{from:?} becomes {uv}");
    }
}

#[test]
fn images_in_buffers_become_files() {
    let png = b"\x89PNG\r\n\x1a\nnot really";
    let mut file = GltfFile::with_triangle(json!({
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 1}}],
        "images": [{"bufferView": 1, "mimeType": "image/png"}, {"uri": "data:image/png;base64,iVBORw=="}],
        "textures": [{"source": 0}, {"source": 1}],
    }));
    assert_eq!(file.view(png), 1);
    let scene = load_bytes("scene.glb", &file.glb(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let read = |node: &Node| scene.bundle.read(file_name(node), &Location::default()).expect("the image is there");
    let bitmap = &all(&scene, PluginClass::Bsdf)[0].children[0].node;
    assert_eq!(*read(bitmap), *png);
    let shape = all(&scene, PluginClass::Shape)[0];
    let emitter = shape.children.iter().find(|child| child.node.class == PluginClass::Emitter).expect("it shines");
    assert_eq!(*read(&emitter.node.children[0].node), *b"\x89PNG");
}

/// The mesh of one primitive made of the square (0,0), (1,0), (0,1), (1,1) in the plane z = 0.
fn primitive(change: impl FnOnce(&mut GltfFile) -> Value) -> TriangleMesh {
    let mut file = GltfFile::new(json!({"nodes": [{"mesh": 0}]}));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]));
    let primitive = change(&mut file);
    let text = file.text();
    let mut json: Value = serde_json::from_str(&text).expect("just written");
    json["meshes"] = json!([{"primitives": [primitive]}]);
    let scene = load_text(&json.to_string());
    mesh(&scene, all(&scene, PluginClass::Shape)[0])
}

#[test]
fn indices_strips_and_fans() {
    let triangles = |mode: usize, numbers: Numbers<'_>| {
        primitive(|file| {
            let indices = file.accessor("SCALAR", numbers);
            json!({"attributes": {"POSITION": 0}, "indices": indices, "mode": mode})
        })
        .triangles
    };
    let square = [[0, 1, 2], [2, 1, 3]];
    assert_eq!(triangles(4, Numbers::U8(&[0, 1, 2, 2, 1, 3])), square);
    assert_eq!(triangles(4, Numbers::U16(&[0, 1, 2, 2, 1, 3])), square);
    assert_eq!(triangles(4, Numbers::U32(&[0, 1, 2, 2, 1, 3])), square);
    assert_eq!(triangles(5, Numbers::U8(&[0, 1, 2, 3])), square);
    // A corner that is given twice makes two triangles without area.
    assert_eq!(triangles(5, Numbers::U8(&[0, 1, 2, 2, 3])).len(), 1);
    // Vertices are numbered in the order of their first use: here 1, 3, 0, 2.
    let fan = triangles(6, Numbers::U8(&[0, 1, 3, 2]));
    assert_eq!(fan, [[0, 1, 2], [1, 3, 2]]);
    let bare = primitive(|_| json!({"attributes": {"POSITION": 0}, "mode": 5}));
    assert_eq!((bare.triangles.len(), bare.positions.len()), (2, 4));
}

#[test]
fn only_the_vertices_in_use_are_kept() {
    let part = primitive(|file| {
        let indices = file.accessor("SCALAR", Numbers::U8(&[3, 2, 1]));
        json!({"attributes": {"POSITION": 0}, "indices": indices})
    });
    assert_eq!(part.positions, [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_eq!(part.triangles, [[0, 1, 2]]);
}

#[test]
fn normalized_strided_and_sparse_elements() {
    let coordinates = |kind: fn(&mut GltfFile) -> usize| {
        primitive(|file| {
            let accessor = kind(file);
            json!({"attributes": {"POSITION": 0, "TEXCOORD_0": accessor}, "mode": 5})
        })
        .texture_coordinates
    };
    let normalized = coordinates(|file| {
        let accessor = file.accessor("VEC2", Numbers::U8(&[0, 255, 51, 0, 0, 0, 255, 255]));
        file.change_accessor(accessor, "normalized", json!(true));
        accessor
    });
    assert_eq!(normalized, [[0.0, 1.0], [0.2, 0.0], [0.0, 0.0], [1.0, 1.0]]);
    let signed = coordinates(|file| {
        let accessor = file.accessor("VEC2", Numbers::I8(&[-128, 127, 0, 0, 0, 0, 0, 0]));
        file.change_accessor(accessor, "normalized", json!(true));
        accessor
    });
    assert_eq!(signed[0], [-1.0, 1.0]);
    let sparse = coordinates(|file| {
        let accessor = file.accessor("VEC2", Numbers::F32(&[0.0; 8]));
        let [places, values] = [file.view(&[1, 3]), file.view(&[[0, 0, 0, 63]; 4].concat())];
        let sparse = json!({"count": 2, "indices": {"bufferView": places, "componentType": 5121}, "values": {"bufferView": values}});
        file.change_accessor(accessor, "sparse", sparse);
        accessor
    });
    assert_eq!(sparse, [[0.0, 0.0], [0.5, 0.5], [0.0, 0.0], [0.5, 0.5]]);
}

#[test]
fn nodes_share_their_mesh() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let file = GltfFile::with_triangle(json!({
        "scene": 0, "scenes": [{"nodes": [0, 3]}],
        "nodes": [
            {"mesh": 0, "translation": [1, 0, 0], "rotation": [0, 0, half, half], "scale": [2, 2, 2], "children": [1, 2]},
            {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1]},
            {"mesh": 0, "scale": [-1, 1, 1]},
            {"mesh": 0, "skin": 0, "translation": [9, 9, 9]},
        ],
    }));
    let scene = load(&file);
    let shapes = all(&scene, PluginClass::Shape);
    let names: Vec<&str> = shapes.iter().map(|shape| file_name(shape)).collect();
    assert_eq!(names, ["generated/mesh_0.ply"; 4]);
    // Scaled by 2, turned by a quarter about z, moved by 1 along x.
    let corner = to_world(shapes[0]).transform_point3(DVec3::X);
    assert!(corner.distance(DVec3::new(1.0, 2.0, 0.0)) < 1e-12, "{corner}");
    let corner = to_world(shapes[1]).transform_point3(DVec3::ZERO);
    assert!(corner.distance(DVec3::new(-5.0, 0.0, 0.0)) < 1e-12, "{corner}");
    assert_eq!(to_world(shapes[3]), DMat4::IDENTITY, "joints place a skinned mesh");
    assert!(notices(&scene).contains("the skin of a node is ignored"));
    assert_eq!(scene.bundle.generated().map(|made| made.meshes.len()), Some(1));
}

#[test]
fn instances_of_a_mesh() {
    let mut file = GltfFile::with_triangle(json!({
        "nodes": [{"mesh": 0, "translation": [1, 0, 0], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}}],
    }));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 0., 5., 0.]));
    let scene = load(&file);
    let places: Vec<DVec3> =
        all(&scene, PluginClass::Shape).iter().map(|shape| to_world(shape).transform_point3(DVec3::ZERO)).collect();
    assert_eq!(places, [DVec3::X, DVec3::new(1.0, 5.0, 0.0)]);
}

#[test]
fn a_mirrored_mesh_keeps_its_outside() {
    let scene = |scale: [f64; 3], normals: bool| {
        let mut file = GltfFile::new(json!({
            "nodes": [{"mesh": 0, "scale": scale}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
            "materials": [{"extensions": {"NV_materials_mdl": {"mdl_shader": 0}}}],
            "extensions": {
                "NV_materials_mdl": {"shaders": [{"definition": "mdl::thick_glass"}]},
                "KHR_lights_punctual": {"lights": [{"type": "point"}]},
            },
        }));
        file.accessor("VEC3", Numbers::F32(&[-1., -1., 0., 1., -1., 0., 0., 1., 0.]));
        file.accessor("VEC3", Numbers::F32(&[0., 0., 1., 0., 0., 1., 0., 0., 1.]));
        let mut json: Value = serde_json::from_str(&file.text()).expect("just written");
        let attributes = if normals { json!({"POSITION": 0, "NORMAL": 1}) } else { json!({"POSITION": 0}) };
        json["meshes"] = json!([{"primitives": [{"attributes": attributes, "material": 0}]}]);
        Scene::prepare(&load_text(&json.to_string())).unwrap_or_else(|error| panic!("{error}"))
    };
    for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -2.0, 1.0], [-1.0, -1.0, 1.0]] {
        for normals in [false, true] {
            let scene = scene(scale, normals);
            let ray = Ray { origin: Vec3::new(0.0, 0.0, 2.0), direction: Vec3::NEG_Z, length: 10.0 };
            let hit = scene.geometry.intersect(&ray).expect("the triangle is there");
            assert!(hit.geometric_normal.distance(Vec3::Z) < 1e-6, "{scale:?} {normals}");
            assert!(hit.frame.normal.distance(Vec3::Z) < 1e-6, "{scale:?} {normals}");
        }
    }
}

#[test]
fn packing_takes_buffers_and_images_along() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let write = |name: &str, content: &[u8]| fs::write(folder.path().join(name), content).expect("it can be written");
    let file = with_material(&json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    fs::create_dir(folder.path().join("maps")).expect("a folder can be made");
    write("maps/wood grain.png", b"\x89PNG");
    write("the mesh.bin", &file.buffer);
    write("room.gltf", file.gltf("the%20mesh.bin").as_bytes());
    let path = folder.path().join("room.gltf");
    let (here, packed) = (load_file(&path, &[]).expect("loads"), pack(&path, &[]).expect("packs"));
    let there = load_bytes("job", &packed, &[]).expect("loads again");
    let outlined = |scene: &SceneDescription| {
        let mut text = String::new();
        outline(&scene.root, "", 0, &mut text);
        text
    };
    assert_eq!(outlined(&here), outlined(&there));
    assert_eq!(mesh(&there, all(&there, PluginClass::Shape)[0]).triangles, [[0, 1, 2]]);
    assert!(there.bundle.read("maps/wood grain.png", &Location::default()).is_ok());
    // A file that needs no other stays as it is.
    let glb = GltfFile::with_triangle(json!({"nodes": [{"mesh": 0}]})).glb();
    write("alone.glb", &glb);
    assert_eq!(pack(&folder.path().join("alone.glb"), &[]).expect("packs"), glb);
}

#[test]
fn a_scene_without_light_gets_white_surroundings() {
    let emitters = |content: Value| {
        let scene = load(&GltfFile::with_triangle(content));
        let emitters: Vec<String> =
            all(&scene, PluginClass::Emitter).iter().map(|emitter| emitter.plugin.clone()).collect();
        (emitters, notices(&scene).contains("the missing light is approximated"))
    };
    let dark = json!({"nodes": [{"mesh": 0}]});
    assert_eq!(emitters(dark.clone()), (vec!["constant".to_owned()], true));
    Scene::prepare(&load(&GltfFile::with_triangle(dark))).unwrap_or_else(|error| panic!("{error}"));
    let lit = json!({
        "nodes": [{"mesh": 0}, {"translation": [0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
    });
    assert_eq!(emitters(lit), (vec!["point".to_owned()], false));
    let scene = load(&with_material(&json!({"emissiveFactor": [1, 1, 1]})));
    assert!(all(&scene, PluginClass::Emitter).is_empty(), "the triangle itself emits");
}

/// Blender writes an image that was never painted, for example.
#[test]
fn black_lights_are_no_lights() {
    let image = |shade: u8| {
        let mut file = std::io::Cursor::new(Vec::new());
        let pixels = image::RgbImage::from_pixel(2, 2, image::Rgb([shade; 3]));
        pixels.write_to(&mut file, image::ImageFormat::Png).expect("images can be written");
        format!("data:image/png;base64,{}", STANDARD.encode(file.into_inner()))
    };
    let light = |material: Value, shade: u8, intensity: f64| {
        let mut file = GltfFile::new(json!({
            "nodes": [{"mesh": 0}, {"mesh": 0}, {"translation": [0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
            "materials": [material], "textures": [{"source": 0}], "images": [{"uri": image(shade)}],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": intensity}]}},
        }));
        file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]));
        file.accessor("VEC2", Numbers::F32(&[0., 0., 1., 0., 0., 1.]));
        let scene = load(&file);
        Scene::prepare(&scene).unwrap_or_else(|error| panic!("{error}"));
        match notices(&scene).contains("the missing light is approximated") {
            true => "the surroundings",
            false => "the file",
        }
    };
    let shining = json!({"emissiveFactor": [0.4, 0.5, 0.6], "emissiveTexture": {"index": 0}});
    assert_eq!(light(shining.clone(), 0, 0.0), "the surroundings", "its image is black");
    assert_eq!(light(shining.clone(), 1, 0.0), "the surroundings", "its image is all but black");
    assert_eq!(light(shining.clone(), 128, 0.0), "the file");
    assert_eq!(light(shining, 0, 1.0), "the file");
    assert_eq!(light(json!({}), 0, 0.0), "the surroundings", "the point light has no intensity");
    assert_eq!(light(json!({"emissiveFactor": [0, 0, 1]}), 0, 0.0), "the file");
}
