//! Small files of other programs, each with the right value that it once missed. They stand for kinds; `tests/cases` has them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::gltf_file::{GltfFile, Numbers};
use crate::progressive::Job;
use photonfarm::import::changes::{Changes, Crop, Environment, with_changes};
use photonfarm::import::{load_bytes, load_changed, load_file, native};
use photonfarm::math::Vec3;
use photonfarm::scene::Scene;
use photonfarm::scene::description::SceneDescription;
use photonfarm::scene::light::Place;
use serde_json::{Value, json};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name)
}

fn prepared(description: &SceneDescription) -> Arc<Scene> {
    Arc::new(Scene::prepare(description).unwrap_or_else(|error| panic!("{error}")))
}

fn load(name: &str, changes: &Changes) -> SceneDescription {
    load_changed(&case(name), &[], changes).unwrap_or_else(|error| panic!("{error}"))
}

/// A picture of the given width, pixels.
fn wide(width: u32) -> Changes {
    Changes { width: Some(width), ..Changes::default() }
}

struct Picture {
    width: usize,
    pixels: Vec<[f32; 3]>,
}

impl Picture {
    fn of(scene: &Arc<Scene>, method: &str, passes: u32) -> Self {
        let parameters = if method == "sppm" { r#"{"photons_per_pass": 20000}"# } else { "{}" };
        let estimate = Job::new(scene, method, parameters).run(passes, passes);
        Self { width: scene.width as usize, pixels: estimate.picture().radiance }
    }

    fn of_case(name: &str, width: u32, passes: u32) -> Self {
        Self::of(&prepared(&load(name, &wide(width))), "path", passes)
    }

    fn pixel(&self, row: usize, column: usize) -> [f32; 3] {
        self.pixels[row * self.width + column]
    }

    /// The mean over rows and columns, of all channels.
    fn mean(&self, rows: std::ops::Range<usize>, columns: std::ops::Range<usize>) -> f32 {
        let places = rows.flat_map(|row| columns.clone().map(move |column| (row, column)));
        let values: Vec<f32> = places.flat_map(|(row, column)| self.pixel(row, column)).collect();
        values.iter().sum::<f32>() / values.len() as f32
    }

    fn whole_mean(&self) -> f32 {
        self.mean(0..self.pixels.len() / self.width, 0..self.width)
    }
}

fn assert_near(value: f32, right: f32, share: f32, what: &str) {
    assert!((value / right - 1.0).abs() <= share, "{what}: {value} is not {right}");
}

// ---- glTF ---------------------------------------------------------------------------------------------------------

#[test]
fn green_of_a_normal_map_is_up_and_given_tangents_count() {
    for (name, right) in [("gltf-normal-green-up", 0.748), ("gltf-tangent-attribute", 0.2525)] {
        let picture = Picture::of_case(&format!("{name}/scene.gltf"), 48, 16);
        assert_near(picture.mean(22..26, 30..34), right, 0.02, name);
    }
}

/// A square in the xy plane with a normal map that tilts everywhere along `tilt`, under light from there or from across.
fn tilted_square(tilt: [f64; 2], mirrored_coordinates: bool, node: Value) -> f32 {
    use base64::Engine;
    let byte = |number: f64| (127.5 + 127.5 * number).round() as u8;
    let mut png = std::io::Cursor::new(Vec::new());
    let color = image::Rgb([byte(tilt[0]), byte(tilt[1]), byte((1.0 - tilt[0].powi(2) - tilt[1].powi(2)).sqrt())]);
    image::RgbImage::from_pixel(2, 2, color)
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("images can be written");
    let png = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
    let mut node = node;
    node["mesh"] = json!(0);
    let mut file = GltfFile::new(json!({
        "nodes": [node, {"camera": 0, "translation": [0, 0, 4]},
            {"translation": [0, 0, 0], "rotation": [-0.382_683_432, 0, 0, 0.923_879_533],
             "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.3, "znear": 0.1, "aspectRatio": 1}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3.0}]}},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
        "materials": [{"normalTexture": {"index": 0}, "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 1}}],
        "textures": [{"source": 0}], "images": [{"uri": format!("data:image/png;base64,{png}")}],
    }));
    file.accessor("VEC3", Numbers::F32(&[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.]));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.]));
    let [left, right] = if mirrored_coordinates { [1.0, 0.0] } else { [0.0, 1.0] };
    file.accessor("VEC2", Numbers::F32(&[left, 1., right, 1., right, 0., left, 0.]));
    file.accessor("SCALAR", Numbers::U16(&[0, 1, 2, 0, 2, 3]));
    let text = file.text();
    let changed = with_changes(text.as_bytes(), &wide(8)).expect("packs");
    let scene = load_bytes("square", &changed, &[]).unwrap_or_else(|error| panic!("{error}"));
    Picture::of(&prepared(&scene), "path", 8).whole_mean()
}

/// The light comes from above (+y) and from the front: what is tilted upwards is brightest, however coordinates and nodes are
/// mirrored.
#[test]
fn tangent_frames_follow_mirrored_coordinates_and_nodes() {
    let tilt = 0.5;
    let up = tilted_square([0.0, tilt], false, json!({}));
    let level = tilted_square([tilt, 0.0], false, json!({}));
    let down = tilted_square([0.0, -tilt], false, json!({}));
    assert!(up > 1.1 * level && level > 1.1 * down, "{up} {level} {down}");
    for (what, mirrored, node, sign) in [
        ("coordinates mirrored in u", true, json!({}), 1.0),
        ("a node mirrored in x", false, json!({"scale": [-1, 1, 1]}), 1.0),
        ("a node mirrored in y", false, json!({"scale": [1, -1, 1]}), -1.0),
        ("a node turned by half a turn", false, json!({"rotation": [0, 0, 1, 0]}), -1.0),
    ] {
        let mean = tilted_square([0.0, sign * tilt], mirrored, node);
        assert_near(mean, up, 0.02, what);
    }
}

#[test]
fn double_sided_lamps_shine_to_both_sides_in_every_method() {
    let right = 0.0518;
    let scene = prepared(&load("gltf-emissive-double-sided/scene.gltf", &wide(36)));
    let whole = Picture::of(&scene, "path", 64);
    let block = whole.mean(27..28, 23..25);
    assert_near(block, right, 0.05, "below the lamp");
    for (method, passes) in [("bdpt", 32), ("sppm", 32), ("light_tracing", 48), ("vcm", 24)] {
        let mean = Picture::of(&scene, method, passes).whole_mean();
        assert_near(mean, whole.whole_mean(), 0.02, method);
    }
}

#[test]
fn a_speck_of_light_does_not_turn_the_default_environment_off() {
    let name = "gltf-faint-glow/scene.gltf";
    let dark = load(name, &Changes { environment: Some(Environment::Off), ..wide(24) });
    assert!(Picture::of(&prepared(&dark), "path", 4).whole_mean() < 1e-3);
    let scene = load(name, &wide(24));
    assert!(scene.notices.iter().any(|notice| notice.to_string().contains("--environment off leaves it out")));
    let picture = Picture::of(&prepared(&scene), "path", 4);
    let mut values: Vec<f32> = picture.pixels.iter().map(|pixel| pixel[0]).collect();
    values.sort_by(f32::total_cmp);
    assert!(values[values.len() / 2] > 0.3);
    // Lamps that light what is seen are enough.
    let lit = load("gltf-emissive-double-sided/scene.gltf", &wide(24));
    assert!(!lit.notices.iter().any(|notice| notice.subject == "the missing light"));
}

#[test]
fn many_instances_of_a_mesh_are_instances() {
    let description = load("gltf-gpu-instancing-1000/scene.gltf", &wide(24));
    let made = description.bundle.generated().expect("there is a mesh");
    assert_eq!(made.meshes.len(), 1);
    let scene = prepared(&description);
    assert!(scene.geometry.has_instances() && scene.geometry.primitive_count() == 0);
    // The native form has the mesh once, too.
    let zip = native::to_zip(&description).unwrap_or_else(|error| panic!("{error}"));
    let again = prepared(&load_bytes("again.zip", &zip, &[]).unwrap_or_else(|error| panic!("{error}")));
    let bits = |scene: &Arc<Scene>| -> Vec<u32> {
        Picture::of(scene, "path", 1).pixels.iter().flatten().map(|channel| channel.to_bits()).collect()
    };
    assert_eq!(bits(&scene), bits(&again));
}

/// Nodes, not only instances of one node.
#[test]
fn nodes_that_share_a_large_mesh_are_instances() {
    let node = |x: i32| json!({"mesh": 0, "translation": [x, 0, 0]});
    let mut file = GltfFile::new(json!({
        "nodes": (0..11).map(node).collect::<Vec<_>>(),
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    }));
    file.accessor("VEC3", Numbers::F32(&[0., 0., 0., 0.5, 0., 0., 0., 0.5, 0.]));
    file.accessor("SCALAR", Numbers::U16(&[0u16, 1, 2].repeat(3000)));
    let instanced = |file: &GltfFile| {
        let scene = load_bytes("room", file.text().as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
        prepared(&scene).geometry.has_instances()
    };
    assert!(instanced(&file));
}

#[test]
fn a_thin_pane_neither_shifts_nor_darkens() {
    let strip = Changes { crop: Some(Crop { x: 0, y: 48, width: 96, height: 1 }), ..wide(96) };
    let [with, without] = ["scene.gltf", "without.gltf"]
        .map(|file| Picture::of(&prepared(&load(&format!("gltf-thin-pane/{file}"), &strip)), "path", 64));
    for column in (50..80).step_by(2) {
        let share = with.pixel(0, column)[0] / without.pixel(0, column)[0];
        let is_pane = share != 1.0;
        assert!(!is_pane || (0.8..0.99).contains(&share), "column {column}: {share}");
    }
    let changed = (0..96).filter(|column| with.pixel(0, *column) != without.pixel(0, *column)).count();
    assert!(changed > 10, "the pane covers {changed} columns");
}

/// Colors of vertices multiply the base color, of a normal-mapped material too; they are bytes with an alpha here.
#[test]
fn colors_of_vertices_count() {
    use base64::Engine;
    let texture =
        format!("data:image/png;base64,{}", base64::prelude::BASE64_STANDARD.encode(png(2, |_, _| [255, 255, 0])));
    for (more, right) in [(json!({}), [0.5, 0.25, 0.5]), (json!({"baseColorTexture": {"index": 0}}), [0.5, 0.25, 0.0])]
    {
        let mut base = json!({"baseColorFactor": [1, 0.5, 1, 1]});
        base.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        let mut file = GltfFile::new(json!({
            "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.3, "znear": 0.1, "aspectRatio": 1}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2}, "indices": 3, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": base, "normalTexture": {"index": 0}, "extensions": {"KHR_materials_unlit": {}}}],
            "textures": [{"source": 0}], "images": [{"uri": texture}],
        }));
        file.accessor("VEC3", Numbers::F32(&[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.]));
        file.accessor("VEC2", Numbers::F32(&[0., 1., 1., 1., 1., 0., 0., 0.]));
        // Red grows upwards from 0 to 1, green and blue to the right.
        file.accessor("VEC4", Numbers::U8(&[0, 0, 0, 9, 0, 255, 255, 9, 255, 255, 255, 9, 255, 0, 0, 9]));
        file.change_accessor(2, "normalized", json!(true));
        file.accessor("SCALAR", Numbers::U16(&[0, 1, 2, 0, 2, 3]));
        let changed = with_changes(file.text().as_bytes(), &wide(8)).expect("packs");
        let scene = load_bytes("square", &changed, &[]).unwrap_or_else(|error| panic!("{error}"));
        let picture = Picture::of(&prepared(&scene), "path", 4);
        let [lower, upper, left] = [picture.mean(4..8, 0..8), picture.mean(0..4, 0..8), picture.mean(0..8, 0..4)];
        assert!(upper > 1.05 * lower && left < 0.98 * picture.whole_mean(), "{lower} {upper} {left}");
        for (channel, value) in right.into_iter().enumerate() {
            let mean = picture.pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / picture.pixels.len() as f32;
            assert!((mean - value).abs() < 0.01, "{more}: channel {channel} is {mean}");
        }
    }
}

/// A slab of glass, 1 m thick, before an even background.
fn slab(volume: Value) -> [f32; 3] {
    let mut file = GltfFile::new(json!({
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.1, "znear": 0.1, "aspectRatio": 1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume}}],
    }));
    let corners = |z: f32| [[-9., -9., z], [9., -9., z], [9., 9., z], [-9., 9., z]];
    file.accessor("VEC3", Numbers::F32([corners(0.0), corners(-1.0)].as_flattened().as_flattened()));
    file.accessor("SCALAR", Numbers::U16(&[0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6]));
    let changed = with_changes(file.text().as_bytes(), &wide(8)).expect("packs");
    let scene = load_bytes("slab", &changed, &[]).unwrap_or_else(|error| panic!("{error}"));
    let picture = Picture::of(&prepared(&scene), "path", 512);
    [0, 1, 2]
        .map(|channel| picture.pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / picture.pixels.len() as f32)
}

/// Of a slab that reflects the share R at each side and lets a pass in between, R + (1 - R)² a/(1 - R a) arrives.
#[test]
fn volumes_attenuate() {
    let clear = slab(json!({"thicknessFactor": 1}));
    let color = slab(json!({"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.81, 0.25, 0.04]}));
    for (channel, passing) in [0.9f32, 0.5, 0.2].into_iter().enumerate() {
        let right = 0.04 + 0.96 * 0.96 * passing / (1.0 - 0.04 * passing);
        assert_near(color[channel], right * clear[channel], 0.02, "a volume");
    }
}

#[test]
fn an_unlit_surface_shows_its_color_and_lights_nothing() {
    let scene = prepared(&load("gltf-unlit/scene.gltf", &wide(32)));
    for method in ["path", "bdpt", "sppm", "vcm", "light_tracing"] {
        let picture = Picture::of(&scene, method, 4);
        let [red, green, blue] = picture.pixel(picture.pixels.len() / picture.width / 2, 16);
        for (value, right) in [(red, 0.2), (green, 0.5), (blue, 0.9)] {
            assert!((value - right).abs() < 1e-4, "{method}: {value} is not {right}");
        }
    }
}

#[test]
fn chunks_without_padding_are_read_and_draco_is_told() {
    let scene = load("glb-unpadded-chunk/scene.glb", &Changes::default());
    assert_eq!(prepared(&scene).geometry.primitive_count(), 1);
    let mut file = GltfFile::with_triangle(json!({
        "extensionsUsed": ["KHR_draco_mesh_compression"], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0},
            "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}}]}],
    }));
    let beside = load_bytes("room", file.text().as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(beside.notices.iter().any(|notice| notice.subject.contains("KHR_draco_mesh_compression")));
    file.change_accessor(0, "bufferView", Value::Null);
    let mut text: Value = serde_json::from_str(&file.text()).expect("JSON");
    text["accessors"][0].as_object_mut().expect("an accessor").remove("bufferView");
    let error = load_bytes("room", text.to_string().as_bytes(), &[]).expect_err("nothing is there").to_string();
    assert!(error.contains("is compressed with Draco"), "{error}");
}

// ---- pbrt ---------------------------------------------------------------------------------------------------------

fn pbrt(text: &str) -> SceneDescription {
    load_bytes("scene.pbrt", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn bits(description: &SceneDescription) -> Vec<u32> {
    let picture = Picture::of(&prepared(description), "path", 2);
    picture.pixels.iter().flatten().map(|channel| channel.to_bits()).collect()
}

fn assert_same_pictures(one: &SceneDescription, other: &SceneDescription, what: &str) {
    let [one, other] = [one, other].map(|scene| Picture::of(&prepared(scene), "path", 4));
    assert_eq!(one.pixels.len(), other.pixels.len());
    assert_near(one.whole_mean(), other.whole_mean(), 1e-4, what);
    for (index, (a, b)) in one.pixels.iter().zip(&other.pixels).enumerate() {
        let same = a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.02 * (a.abs() + b.abs()) + 0.02);
        assert!(same, "{what}: pixel {index} is {a:?} and {b:?}");
    }
}

#[test]
fn pbrt_twins_give_one_picture() {
    for name in ["pbrt-screenwindow-houdini", "pbrt-distant-illuminance"] {
        let [scene, twin] = ["scene.pbrt", "twin.pbrt"].map(|file| load(&format!("{name}/{file}"), &wide(32)));
        assert_same_pictures(&scene, &twin, name);
    }
    bits(&load("pbrt-option/scene.pbrt", &wide(16)));
}

const PBRT_HEAD: &str = "LookAt 0 1.2 4  0 .4 0  0 1 0\n";
const PBRT_WORLD: &str = "PixelFilter \"box\"\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n\
    Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n\
    Shape \"trianglemesh\" \"point3 P\" [-4 0 -4 4 0 -4 4 0 4 -4 0 4] \"integer indices\" [0 2 1 0 3 2]\n\
    Translate -.6 .5 0\nMaterial \"diffuse\" \"rgb reflectance\" [.8 .2 .2]\nShape \"sphere\" \"float radius\" .5\n";

fn viewed(camera: &str, film: &str) -> SceneDescription {
    pbrt(&format!("{PBRT_HEAD}Camera \"perspective\" {camera}\nFilm \"rgb\" {film}\n{PBRT_WORLD}"))
}

/// A window beside the middle is the same part of a larger picture.
#[test]
fn pbrt_screen_windows_beside_the_middle() {
    let whole = "\"integer xresolution\" 40 \"integer yresolution\" 40";
    let quarter = viewed(
        "\"float fov\" 45 \"float screenwindow\" [-1 0 0 1]",
        "\"integer xresolution\" 20 \"integer yresolution\" 20",
    );
    let crop = viewed("\"float fov\" 45", &format!("{whole} \"float cropwindow\" [0 .5 0 .5]"));
    assert_same_pictures(&quarter, &crop, "a quarter");
    let wider = viewed("\"float fov\" 45 \"float screenwindow\" [-2 2 -2 2]", whole);
    let fov = 2.0 * (2.0 * (22.5_f64.to_radians()).tan()).atan().to_degrees();
    assert_same_pictures(&wider, &viewed(&format!("\"float fov\" {fov}"), whole), "twice as wide");
}

fn lit(light: &str) -> SceneDescription {
    let film =
        "Camera \"perspective\" \"float fov\" 45\nFilm \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\n";
    let world = PBRT_WORLD.replace("LightSource \"infinite\" \"rgb L\" [1 1 1]", light);
    pbrt(&format!("{PBRT_HEAD}{film}{world}"))
}

#[test]
fn pbrt_lights_have_their_power() {
    let pi = std::f64::consts::PI;
    let spot_k =
        2.0 * pi * ((1.0 - 15_f64.to_radians().cos()) + 0.5 * (15_f64.to_radians().cos() - 20_f64.to_radians().cos()));
    let spot = "LightSource \"spot\" \"point3 from\" [0 4 1] \"point3 to\" [0 0 0] \"float coneangle\" 20 \"float conedeltaangle\" 5";
    let lamp = |rest: &str| {
        format!(
            "AttributeBegin\nTranslate 0 3 0\nAreaLightSource \"diffuse\" {rest}\n\
            Shape \"sphere\" \"float radius\" .25\nAttributeEnd"
        )
    };
    let sphere = 4.0 * pi * 0.25 * 0.25;
    let twins = [
        (
            "LightSource \"point\" \"point3 from\" [0 3 1] \"rgb I\" [1 .5 1] \"float power\" 100".to_owned(),
            format!(
                "LightSource \"point\" \"point3 from\" [0 3 1] \"rgb I\" [1 .5 1] \"float scale\" {}",
                100.0 / (4.0 * pi)
            ),
        ),
        (format!("{spot} \"float power\" 20"), format!("{spot} \"float scale\" {}", 20.0 / spot_k)),
        (
            "LightSource \"infinite\" \"rgb L\" [1 1 .5] \"float illuminance\" 2".to_owned(),
            format!("LightSource \"infinite\" \"rgb L\" [1 1 .5] \"float scale\" {}", 2.0 / pi),
        ),
        (
            lamp("\"rgb L\" [1 1 1] \"float power\" 30"),
            lamp(&format!("\"rgb L\" [1 1 1] \"float scale\" {}", 30.0 / (pi * sphere))),
        ),
        (
            lamp("\"rgb L\" [1 1 1] \"float power\" 30 \"bool twosided\" true"),
            lamp(&format!("\"rgb L\" [1 1 1] \"float scale\" {} \"bool twosided\" true", 15.0 / (pi * sphere))),
        ),
    ];
    for (scene, twin) in &twins {
        assert_same_pictures(&lit(scene), &lit(twin), scene);
    }
    // A light of the Planckian color 2700 K has luminance 1.
    let black_body = Picture::of(&prepared(&lit("LightSource \"infinite\" \"blackbody L\" 2700")), "path", 4);
    let white = Picture::of(&prepared(&lit("LightSource \"infinite\" \"rgb L\" [1 1 1]")), "path", 4);
    let luminance = |picture: &Picture| {
        let [r, g, b] = picture.pixel(0, 8);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    assert_near(luminance(&black_body), luminance(&white), 0.01, "a black body");
}

#[test]
fn pbrt_area_lights_shine_from_both_sides() {
    let quad = |sides: &str, order: &str| {
        lit(&format!(
            "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 3 3] {sides}\n\
             Shape \"bilinearmesh\" \"point3 P\" [-1 3 -1 1 3 -1 -1 3 1 1 3 1] \"integer indices\" [{order}]\nAttributeEnd"
        ))
    };
    let [down, up] =
        ["0 1 2 3", "1 0 3 2"].map(|order| Picture::of(&prepared(&quad("", order)), "path", 4).whole_mean());
    let right = down.max(up);
    assert!(down.min(up) < 0.01 * right, "one of them shines away: {down} {up}");
    for order in ["0 1 2 3", "1 0 3 2"] {
        let both = Picture::of(&prepared(&quad("\"bool twosided\" true", order)), "path", 16).whole_mean();
        assert_near(both, right, 0.03, "two-sided");
    }
}

#[test]
fn pbrt_images_are_inverted_and_shares_above_1_count_as_1() {
    let picture = Picture::of_case("pbrt-imagemap-invert/scene.pbrt", 32, 64);
    assert_near(picture.mean(8..12, 14..18), 0.497, 0.01, "upper half");
    assert_near(picture.mean(20..24, 14..18), 1.0, 0.01, "lower half");
    let world = |share: &str| {
        format!(
            "Camera \"perspective\"\nFilm \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\nWorldBegin\n\
            LightSource \"infinite\"\nTranslate 0 0 3\nMaterial \"diffuse\" {share}\nShape \"sphere\"\n"
        )
    };
    let bright = pbrt(&world("\"rgb reflectance\" [1.02 .5 .5]"));
    assert!(bright.notices.iter().any(|notice| notice.to_string().contains("counts as 1")));
    assert_eq!(bits(&bright), bits(&pbrt(&world("\"rgb reflectance\" [1 .5 .5]"))));
    bits(&pbrt(&world("\"blackbody reflectance\" 3000")));
}

#[test]
fn pbrt_directives_of_real_files() {
    let text = "Option \"disablewavelengthjitter\" true\nOption \"string filename\" [\"a\" \"b\"]\n\
        TransformTimes 0 1\nActiveTransform EndTime\nTranslate 0 9 0\nActiveTransform All\n\
        Camera \"perspective\" \"float frameaspectratio\" 1\nFilm \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
        WorldBegin\nLightSource \"goniometric\" \"float power\" 10\nTranslate 0 0 3\nShape \"sphere\"\n";
    let scene = pbrt(text);
    assert!(scene.notices.iter().any(|notice| notice.subject == "the motion between two keyframes"));
    prepared(&scene);
}

/// A scene file with files beside it, in a folder of its own.
fn in_folder(name: &str, text: &str, files: &[(&str, &[u8])]) -> SceneDescription {
    let folder = tempfile::tempdir().expect("a folder");
    for (file, content) in files.iter().copied().chain([(name, text.as_bytes())]) {
        std::fs::write(folder.path().join(file), content).expect("writes");
    }
    // Packed, so that what has to travel does.
    let packed = photonfarm::import::pack(&folder.path().join(name), &[]).unwrap_or_else(|error| panic!("{error}"));
    load_bytes("packed", &packed, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn png(size: u32, color: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let image = image::RgbImage::from_fn(size, size, |column, row| image::Rgb(color(column, row)));
    image.write_to(&mut file, image::ImageFormat::Png).expect("images can be written");
    file.into_inner()
}

fn gzip(content: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(content).expect("writes");
    packed.finish().expect("writes")
}

const PBRT_VIEW: &str = "LookAt 0 1.2 4  0 .4 0  0 1 0\nCamera \"perspective\" \"float fov\" 45\n\
    Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\nPixelFilter \"box\"\nWorldBegin\n";

/// The image of an infinite light is red towards its own +x, green towards +y and blue towards +z, which stands upright here.
#[test]
fn pbrt_skies_have_their_directions() {
    let diamond = |column: u32, row: u32| {
        column.abs_diff(31).min(column.abs_diff(32)) + row.abs_diff(31).min(row.abs_diff(32)) < 31
    };
    let on = |lit: bool| if lit { 255 } else { 0 };
    let octants = png(64, |column, row| [on(column > 31), on(row > 31), on(diamond(column, row))]);
    let sky = |light: &str| {
        let world = format!(
            "{PBRT_VIEW}AttributeBegin\nRotate -90 1 0 0\nLightSource \"infinite\" \"string filename\" \"sky.png\" {light}\n\
             AttributeEnd\nShape \"sphere\"\n"
        );
        prepared(&in_folder("scene.pbrt", &world, &[("sky.png", &octants)]))
    };
    let scene = sky("\"float scale\" 2");
    for index in 0..8 {
        let sign = |bit: u32| if index >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let own = Vec3::new(0.5 * sign(0), 0.4 * sign(1), 0.6 * sign(2)).normalize();
        let world = Vec3::new(own.x, own.z, -own.y);
        let (radiance, _) = scene.lights.environment(&Place::from(Vec3::ZERO), world).expect("a sky");
        let right = [0, 1, 2].map(|bit| 1.0 + sign(bit));
        assert!(radiance.abs_diff_eq(right.into(), 0.02), "{own}: {radiance} is not {right:?}");
    }
    // Blue is the upper half, of irradiance π times its radiance; red and green are half of that each.
    let scene = sky("\"float illuminance\" 10");
    let (radiance, _) = scene.lights.environment(&Place::from(Vec3::ZERO), Vec3::Y).expect("a sky");
    let luminance = 0.2126 / 2.0 + 0.7152 / 2.0 + 0.0722;
    assert_near(radiance.z, 10.0 / (std::f32::consts::PI * luminance), 0.01, "illuminance");
}

/// The faces of this PLY file come before its vertices, too.
#[test]
fn compressed_meshes_of_pbrt_are_unpacked() {
    let ply = b"ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\nelement vertex 4\n\
        property float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n3 0 2 3\n\
        -1 0 0\n1 0 0\n1 1 0\n-1 1 0\n";
    let world =
        |name: &str| format!("{PBRT_VIEW}LightSource \"infinite\"\nShape \"plymesh\" \"string filename\" \"{name}\"\n");
    let plain = in_folder("scene.pbrt", &world("wall.ply"), &[("wall.ply", ply)]);
    let packed = in_folder("scene.pbrt", &world("wall.ply.gz"), &[("wall.ply.gz", &gzip(ply))]);
    assert_eq!(bits(&plain), bits(&packed));
    let included = gzip(b"Shape \"sphere\" \"float radius\" .5\n");
    let scene = format!("{PBRT_VIEW}LightSource \"infinite\"\nInclude \"ball.pbrt.gz\"\n");
    prepared(&in_folder("scene.pbrt", &scene, &[("ball.pbrt.gz", &included)]));
}

#[test]
fn pbrt_images_shine() {
    let quad = "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\nShape \"bilinearmesh\" \"point3 P\" [-1 0 0 1 0 0 -1 1 0 1 1 0] \
        \"point2 uv\" [0 0 1 0 0 1 1 1]\n";
    let upper = png(2, |_, row| if row == 0 { [255; 3] } else { [0; 3] });
    let scene = format!(
        "{PBRT_VIEW}AreaLightSource \"diffuse\" \"string filename\" \"i.png\" \"float scale\" 2 \"bool twosided\" true\n{quad}"
    );
    let picture = Picture::of(&prepared(&in_folder("scene.pbrt", &scene, &[("i.png", &upper)])), "path", 16);
    // The top of the image is where v is 1.
    assert!(picture.mean(6..7, 6..10) > 1.5 && picture.mean(8..9, 6..10) < 0.5, "{:?}", picture.pixels);
    let floor = "Shape \"trianglemesh\" \"point3 P\" [-4 0 -4 4 0 -4 4 0 4 -4 0 4] \"integer indices\" [0 2 1 0 3 2]\n";
    // A white image is a point light, and its power that of the picture.
    let lamp =
        |light: &str| format!("{PBRT_VIEW}AttributeBegin\nTranslate 0 2 1\nLightSource {light}\nAttributeEnd\n{floor}");
    let white = png(4, |_, _| [255; 3]);
    let round = in_folder(
        "scene.pbrt",
        &lamp("\"goniometric\" \"string filename\" \"i.png\" \"float power\" 20"),
        &[("i.png", &white)],
    );
    let point = pbrt(&lamp("\"point\" \"float power\" 20"));
    assert_same_pictures(&round, &point, "a white image");
    let projection = lamp("\"projection\" \"string filename\" \"i.png\" \"float fov\" 40");
    prepared(&in_folder("scene.pbrt", &projection, &[("i.png", &white)]));
}

// ---- OBJ, MGF, Mitsuba 0.6 ----------------------------------------------------------------------------------------

#[test]
fn odd_obj_files_load() {
    let odd = prepared(&load("obj-oddities/scene.xml", &Changes::default()));
    assert_eq!(odd.geometry.primitive_count(), 6);
    let unknown = prepared(&load("obj-unknown-statements/scene.xml", &Changes::default()));
    assert_eq!(unknown.geometry.primitive_count(), 1);
    let told: Vec<&String> = unknown.notices.iter().filter(|notice| notice.contains("\"vw\"")).collect();
    assert_eq!(told.len(), 1, "{:?}", unknown.notices);
}

#[test]
fn obj_files_of_mitsuba_0_6_have_their_materials() {
    let picture = Picture::of_case("old-obj-mtl/scene.xml", 64, 32);
    for (column, right) in [(20, [0.8, 0.1, 0.1]), (44, [0.1, 0.1, 0.8])] {
        let found = picture.pixel(32, column);
        assert!(found.iter().zip(right).all(|(value, right)| (value - right).abs() < 0.01), "{column}: {found:?}");
    }
    // Named bsdfs of the shape come before the library.
    let text = std::fs::read_to_string(case("old-obj-mtl/scene.xml")).expect("the case is there");
    let own = "<bsdf type=\"diffuse\" name=\"left\"><rgb name=\"reflectance\" value=\"0.2,0.6,0.2\"/></bsdf></shape>";
    let folder = tempfile::tempdir().expect("a folder");
    for file in ["m.obj", "m.mtl"] {
        std::fs::copy(case("old-obj-mtl").join(file), folder.path().join(file)).expect("copies");
    }
    std::fs::write(folder.path().join("scene.xml"), text.replace("</shape>", own)).expect("writes");
    let scene = load_file(&folder.path().join("scene.xml"), &[]).unwrap_or_else(|error| panic!("{error}"));
    let picture = Picture::of(&prepared(&scene), "path", 32);
    assert!((picture.pixel(32, 20)[1] - 0.6).abs() < 0.01 && (picture.pixel(32, 44)[2] - 0.8).abs() < 0.01);
}

#[test]
fn components_of_mgf_colors_may_be_negative() {
    prepared(&load("mgf-cspec-negative/scene.mgf", &Changes::default()));
}

fn mgf(text: &str) -> SceneDescription {
    let changed = with_changes(text.as_bytes(), &wide(32)).expect("packs");
    load_bytes("scene.mgf", &changed, &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

const MGF_START: &str = "m floor =\n sides 2\n rd .5\nm lamp =\n sides 2\n ed 20000\nm ball =\n sides 2\n rd .7\n\
    v a =\n p -1 -1 0\nv b =\n p 40 -1 0\nv c =\n p 40 40 0\nv d =\n p -1 40 0\nm floor\nf a b c d\n";

/// An array that becomes instances looks like its copies, of which some shine.
#[test]
fn mgf_arrays_are_instances() {
    let body = "m ball\nv o =\n p 0 0 .6\n n 0 0 1\ntorus o .1 .4\nsph o .2\nm lamp\nv u =\n p 0 0 1.6\nsph u .05\n";
    let array = format!("{MGF_START}xf -rz 3 -a 10 -t 3 0 0 -a 9 -t 0 4 0\n{body}xf\n");
    let mut spelled = MGF_START.to_owned();
    for (x, y) in (0..10).flat_map(|x| (0..9).map(move |y| (x, y))) {
        spelled.push_str(&format!("xf -rz 3 -t {} {} 0\n{body}xf\n", 3 * x, 4 * y));
    }
    let [array, spelled] = [array, spelled].map(|text| prepared(&mgf(&text)));
    assert!(array.geometry.has_instances() && !spelled.geometry.has_instances());
    assert_eq!(array.lights.lights().len(), spelled.lights.lights().len());
    let [one, other] = [&array, &spelled].map(|scene| Picture::of(scene, "path", 32));
    assert_near(one.whole_mean(), other.whole_mean(), 0.01, "the mean");
    // Arrays in arrays keep their instances.
    let nested = format!(
        "{MGF_START}xf -a 10 -t 4 0 0\nxf -a 10 -t 0 4 0\nm ball\nv o =\n p 0 0 .6\n n 0 0 1\ntorus o .1 .4\nxf\nxf\n"
    );
    assert!(prepared(&with_light(mgf(&nested))).geometry.has_instances());
}

/// A white environment, for scenes without light.
fn with_light(mut description: SceneDescription) -> SceneDescription {
    let light = "<scene version='3.0.0'><emitter type='constant'/></scene>";
    let light = load_bytes("light.xml", light.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    description.root.children.extend(light.root.children);
    description
}

#[test]
fn a_closed_mgf_room_is_seen_from_inside() {
    let mut room =
        "m wall =\n sides 2\n rd .6\nm lamp =\n sides 1\n ed 2000\nv e =\n p 1.5 2 2.49\nv f1 =\n p 1.5 3 2.49\n\
        v g =\n p 2.5 3 2.49\nv h =\n p 2.5 2 2.49\nm lamp\nf e f1 g h\nm wall\n"
            .to_owned();
    for corner in 0..8 {
        let [x, y, z] = [(0, 4.0), (1, 5.0), (2, 2.5)].map(|(axis, side)| side * f64::from(corner >> axis & 1));
        room.push_str(&format!("v c{corner} =\n p {x} {y} {z}\n"));
    }
    for [a, b, c, d] in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
        room.push_str(&format!("f c{a} c{b} c{c} c{d}\n"));
    }
    let scene = mgf(&room);
    assert!(scene.notices.iter().any(|notice| notice.explanation.starts_with("everything is dark from outside")));
    let picture = Picture::of(&prepared(&scene), "path", 16);
    let black = picture.pixels.iter().filter(|pixel| **pixel == [0.0; 3]).count();
    assert!(4 * black < picture.pixels.len(), "{black} pixels are black");
}

// ---- Changes of a scene -------------------------------------------------------------------------------------------

#[test]
fn changes_travel_with_the_scene() {
    let path = case("pbrt-option/scene.pbrt");
    let bytes = photonfarm::import::pack(&path, &[]).expect("packs");
    let crop = Crop { x: 8, y: 4, width: 16, height: 20 };
    let changes = Changes { crop: Some(crop), ..wide(32) };
    let packed = with_changes(&bytes, &changes).expect("packs");
    let scene = prepared(&load_bytes("scene", &packed, &[]).unwrap_or_else(|error| panic!("{error}")));
    assert_eq!((scene.width, scene.height, scene.film.whole), (16, 20, [32, 32]));
    // Later changes count before earlier ones, and what they do not say stays.
    let again = with_changes(&packed, &wide(64)).expect("packs");
    let error = load_bytes("scene", &again, &[]).map(|scene| prepared(&scene).width);
    assert_eq!(error.expect("loads"), 16);
    let outside = Changes { crop: Some(Crop { x: 30, ..crop }), ..wide(32) };
    assert!(
        load_changed(&path, &[], &outside).expect_err("leaves the picture").to_string().contains("leaves a picture")
    );
    let nobody = Changes { camera: Some("front".to_owned()), ..Changes::default() };
    assert!(load_changed(&path, &[], &nobody).expect_err("no such camera").to_string().contains("there is no camera"));
}

/// Cameras without names are told by their indices alone.
#[test]
fn cameras_without_names_are_listed_by_index() {
    let told = |cameras: &str, wanted: &str| {
        let text = format!("<scene version='3.0.0'>{cameras}<shape type='sphere'/><emitter type='constant'/></scene>");
        let changes = Changes { camera: Some(wanted.to_owned()), ..Changes::default() };
        let packed = with_changes(text.as_bytes(), &changes).expect("packs");
        load_bytes("a.xml", &packed, &[]).expect_err("no such camera").to_string()
    };
    let (plain, named) = ("<sensor type='perspective'/>", "<sensor type='perspective' id='front'/>");
    for (cameras, expected) in [
        ([plain, plain].concat(), "there is no camera \"2\"; there are 0, 1"),
        ([plain, named].concat(), "there is no camera \"2\"; there are 0, 1 \"front\""),
        (plain.to_owned(), "there is no camera \"2\"; the only one is 0"),
        (
            plain.repeat(25),
            "there is no camera \"25\"; there are 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, … (25 in all)",
        ),
    ] {
        let wanted = if cameras.len() > 200 { "25" } else { "2" };
        let found = told(&cameras, wanted);
        assert!(found.ends_with(expected), "{found}");
    }
}

#[test]
fn cameras_are_chosen_by_name_and_index() {
    let camera = |name: &str, x: i32| json!({"name": name, "camera": 0, "translation": [x, 0, 0]});
    let file = GltfFile::with_triangle(json!({
        "nodes": [{"mesh": 0}, camera("front", 1), camera("side", 2)],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
    }));
    let place = |camera: Option<&str>| {
        let changes = Changes { camera: camera.map(str::to_owned), ..Changes::default() };
        let bytes = with_changes(file.text().as_bytes(), &changes).expect("packs");
        let scene = load_bytes("room", &bytes, &[]).unwrap_or_else(|error| panic!("{error}"));
        format!("{:?}", scene.root.children[0].node.parameters).contains("2.0, 0.0, 0.0, 1.0")
    };
    assert!(!place(None) && !place(Some("front")) && !place(Some("0")));
    assert!(place(Some("side")) && place(Some("1")));
}

#[test]
fn the_tables_of_formats_are_those_of_the_page() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/COMPATIBILITY.md");
    let text = std::fs::read_to_string(&page).expect("the page is there");
    let (begin, end) = ("<!-- formats: begin -->\n\n", "<!-- formats: end -->");
    let (head, rest) = text.split_once(begin).expect("the page has the section");
    let (tables, tail) = rest.split_once(end).expect("the section ends");
    let made = photonfarm::import::compatibility::markdown();
    if std::env::var_os("PHOTONFARM_RENEW_COMPATIBILITY").is_some() {
        std::fs::write(&page, format!("{head}{begin}{made}{end}{tail}")).expect("writes");
        return;
    }
    assert!(tables == made, "renew it with PHOTONFARM_RENEW_COMPATIBILITY=1 cargo test --test scene cases_of_formats");
}
