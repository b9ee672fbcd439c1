//! Scenes as people write them come out as the tree they mean.

use std::fs;
use std::io::{Cursor, Write};

use glam::{DMat4, DVec3};
use photonfarm::import::{load_bytes, load_file, pack};
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value};
use photonfarm::scene::error::Location;
use photonfarm::scene::geometry::triangle_mesh::TriangleMesh;
use photonfarm::scene::geometry::{obj, ply};

fn load(text: &str) -> SceneDescription {
    load_bytes("scene.xml", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn error(text: &str) -> String {
    load_bytes("scene.xml", text.as_bytes(), &[]).expect_err("the scene is malformed").to_string()
}

fn parameter<'a>(node: &'a Node, name: &str) -> &'a Value {
    &node.parameters.iter().find(|parameter| parameter.name == name).expect(name).value
}

fn transform(steps: &str) -> DMat4 {
    let scene = load(&format!("<scene version='3.0.0'><transform name='to_world'>{steps}</transform></scene>"));
    match parameter(&scene.root, "to_world") {
        Value::Transform(matrix) => *matrix,
        other => panic!("{other:?}"),
    }
}

/// The tree as text, without locations.
fn outline(node: &Node) -> String {
    let parameters: Vec<String> =
        node.parameters.iter().map(|parameter| format!("{}={:?}", parameter.name, parameter.value)).collect();
    let children: Vec<String> =
        node.children.iter().map(|child| format!("{}:{}", child.name, outline(&child.node))).collect();
    format!("{} {} #{} {parameters:?} {children:?}", node.class.tag(), node.plugin, node.id)
}

const XML: &str = r##"<?xml version="1.0" encoding="utf-8"?>
<scene version="3.0.0">
  <!-- a sphere on a floor -->
  <integrator type="sppm" id="method"><integer name="max_depth" value="-1"/><float name="alpha" value="0.7"/></integrator>
  <sensor type="perspective" id="camera">
    <float name="fov" value="40.5"/>
    <transform name="to_world"><lookat origin="0, 1, 4" target="0 0 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="64"/><rfilter type="box"/></film>
  </sensor>
  <bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.6 0.7"/></bsdf></bsdf>
  <bsdf type="diffuse" id="pattern">
    <texture type="bitmap" name="reflectance"><string name="filename" value="floor.png"/><boolean name="raw" value="true"/></texture>
  </bsdf>
  <shape type="sphere" id="ball">
    <point name="center" x="1" z="-2"/>
    <transform name="to_world">
      <scale value="2"/><rotate y="1" angle="90"/><translate x="1" y="2" z="3"/>
      <matrix value="1 0 0 5  0 1 0 6  0 0 1 7  0 0 0 1"/>
    </transform>
    <ref id="white"/>
  </shape>
  <shape type="rectangle" id="floor"><ref id="pattern"/>
    <emitter type="area"><rgb name="radiance" value="#ff8000"/><spectrum name="extra" value="2"/></emitter>
  </shape>
</scene>"##;

const JSON: &str = r##"{
  "type": "scene",
  "method": {"type": "sppm", "max_depth": -1, "alpha": 0.7},
  "camera": {
    "type": "perspective", "fov": 40.5,
    "to_world": [{"look_at": {"origin": [0, 1, 4], "target": [0, 0, 0], "up": [0, 1, 0]}}],
    "film": {"type": "hdrfilm", "width": 64, "rfilter": {"type": "box"}}
  },
  "white": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5, 0.6, 0.7]}}},
  "pattern": {"type": "diffuse", "reflectance": {"type": "bitmap", "filename": "floor.png", "raw": true}},
  "ball": {
    "type": "sphere", "center": [1, 0, -2],
    "to_world": [
      {"scale": 2}, {"rotate": {"axis": [0, 1, 0], "angle": 90}}, {"translate": [1, 2, 3]},
      {"matrix": [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]}
    ],
    "bsdf": {"type": "ref", "id": "white"}
  },
  "floor": {
    "type": "rectangle", "bsdf": {"type": "ref", "id": "pattern"},
    "emitter": {"type": "area", "radiance": {"type": "rgb", "value": "#ff8000"}, "extra": {"type": "spectrum", "value": 2}}
  }
}"##;

#[test]
fn xml_and_json_of_one_scene_give_one_tree() {
    assert_eq!(outline(&load(XML).root), outline(&load(JSON).root));
}

#[test]
fn values_and_places_come_out_as_written() {
    let root = load(XML).root;
    assert_eq!((root.class, root.children.len()), (PluginClass::Scene, 6));
    let ball = &root.children[4].node;
    assert_eq!(parameter(ball, "center"), &Value::Vector([1.0, 0.0, -2.0]));
    let emitter = &root.children[5].node.children[1].node;
    let Value::Rgb([red, green, blue]) = parameter(emitter, "radiance") else { panic!("not a color") };
    assert!(*red == 1.0 && *blue == 0.0 && (green - 0.215_860_5).abs() < 1e-6, "{green}");
    assert_eq!(emitter.location.to_string(), "scene.xml:23 (scene/shape[1]/emitter[0])");
    assert_eq!(emitter.parameters[0].location.path, "scene/shape[1]/emitter[0]/radiance");
    let json = load(JSON).root;
    assert_eq!(json.children[4].node.location.to_string(), "scene.xml (scene/ball)");
}

#[test]
fn references_share_one_node_in_either_order() {
    let scene = load(
        "<scene version='3.0.0'><shape type='cube'><ref id='b'/></shape><shape type='cube'><ref name='x' id='a'/></shape>
         <bsdf type='diffuse' id='a'/><alias id='a' as='b'/></scene>",
    );
    let [first, second, bsdf] = [0, 1, 2].map(|index| &scene.root.children[index].node);
    assert!(std::sync::Arc::ptr_eq(&first.children[0].node, bsdf));
    assert!(std::sync::Arc::ptr_eq(&second.children[0].node, bsdf));
    assert_eq!(second.children[0].name, "x");
}

#[test]
fn transform_steps_apply_in_the_order_written() {
    let moved = transform("<translate value='1, 0, 0'/><scale value='2'/>").transform_point3(DVec3::ZERO);
    assert_eq!(moved, DVec3::new(2.0, 0.0, 0.0));
    let scaled = transform("<scale x='3' y='2'/>").transform_point3(DVec3::ONE);
    assert_eq!(scaled, DVec3::new(3.0, 2.0, 1.0));
    let turned = transform("<rotate z='5' angle='90'/>").transform_point3(DVec3::X);
    assert!(turned.distance(DVec3::Y) < 1e-15, "{turned}");
    let upper = transform("<matrix value='0 1 0, 0 0 1, 1 0 0'/>").transform_point3(DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(upper, DVec3::new(2.0, 3.0, 1.0));
}

#[test]
fn lookat_looks_along_z_with_x_to_the_left() {
    let matrix = transform("<lookat origin='0, 0, 5' target='0, 0, 0' up='0, 2, 0'/>");
    assert_eq!(matrix.transform_vector3(DVec3::Z), -DVec3::Z);
    assert_eq!(matrix.transform_vector3(DVec3::Y), DVec3::Y);
    assert_eq!(matrix.transform_vector3(DVec3::X), -DVec3::X);
    assert_eq!(matrix.transform_point3(DVec3::ZERO), DVec3::new(0.0, 0.0, 5.0));
}

#[test]
fn defines_beat_defaults_and_the_first_default_counts() {
    let text = "<scene version='3.0.0'><default name='n' value='4'/><default name='n' value='5'/>
        <default name='name' value='f$n'/><integer name='a' value='$n'/><string name='b' value='$name.png'/></scene>";
    let scene = load(text);
    assert_eq!(parameter(&scene.root, "a"), &Value::Integer(4));
    assert_eq!(parameter(&scene.root, "b"), &Value::String("f4.png".into()));
    let defines = [("n".to_owned(), "9".to_owned())];
    let scene = load_bytes("scene.xml", text.as_bytes(), &defines).unwrap();
    assert_eq!(parameter(&scene.root, "a"), &Value::Integer(9));
    let defines = [("nn".to_owned(), "9".to_owned())];
    let error = load_bytes("scene.xml", text.as_bytes(), &defines).unwrap_err().to_string();
    assert!(error.contains("does not use the defined parameter \"nn\"; did you mean \"n\"?"), "{error}");
}

#[test]
fn not_a_number_is_imported_for_the_reader_to_refuse() {
    let scene = load("<scene version='3.0.0'><float name='a' value='nan'/><rgb name='b' value='0 inf 0'/></scene>");
    assert!(matches!(parameter(&scene.root, "a"), Value::Float(number) if number.is_nan()));
    assert_eq!(parameter(&scene.root, "b"), &Value::Rgb([0.0, f64::INFINITY, 0.0]));
}

/// A scene of several files in a folder.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let main = "<scene version='3.0.0'><default name='mesh' value='a'/><include filename='parts/materials.xml'/>
        <shape type='obj'><string name='filename' value='meshes/$mesh.obj'/><ref id='grey'/></shape></scene>";
    let materials = "<scene version='3.0.0'><include filename='parts/grey.xml'/></scene>";
    fs::create_dir_all(folder.path().join("parts")).unwrap();
    fs::create_dir_all(folder.path().join("meshes")).unwrap();
    fs::write(folder.path().join("room.xml"), main).unwrap();
    fs::write(folder.path().join("parts/materials.xml"), materials).unwrap();
    fs::write(folder.path().join("parts/grey.xml"), "<bsdf type='diffuse' id='grey'/>").unwrap();
    fs::write(folder.path().join("meshes/a.obj"), OBJ).unwrap();
    folder
}

#[test]
fn a_scene_of_several_files_travels_as_one_archive() {
    let folder = folder();
    let path = folder.path().join("room.xml");
    let here = load_file(&path, &[]).unwrap();
    let bytes = pack(&path, &[]).unwrap();
    assert_eq!(bytes, pack(&path, &[]).unwrap(), "packing is deterministic");
    let there = load_bytes("upload", &bytes, &[]).unwrap();
    assert_eq!(outline(&here.root), outline(&there.root));
    assert_eq!(there.root.location.file, "room.xml");
    let names: Vec<String> = there.bundle.names().into_iter().collect();
    assert_eq!(names, ["meshes/a.obj", "parts/grey.xml", "parts/materials.xml", "room.xml"]);
    let content = there.bundle.read("./meshes/a.obj", &Location::default()).unwrap();
    assert_eq!(&content[..], OBJ.as_bytes());

    fs::write(folder.path().join("room.zip"), &bytes).unwrap();
    assert_eq!(pack(&folder.path().join("room.zip"), &[]).unwrap(), bytes);
    let error = pack(&path, &[("mesh".to_owned(), "b".to_owned())]).unwrap_err().to_string();
    assert!(error.contains("there is no file \"meshes/b.obj\"; did you mean \"meshes/a.obj\"?"), "{error}");
}

#[test]
fn a_scene_that_refers_to_nothing_travels_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alone.xml");
    fs::write(&path, "<scene version='3.0.0'/>").unwrap();
    assert_eq!(pack(&path, &[]).unwrap(), b"<scene version='3.0.0'/>");
}

#[test]
fn the_scene_file_is_renamed_when_archives_would_not_find_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("part.xml"), "<bsdf type='diffuse' id='grey'/>").unwrap();
    fs::write(folder.path().join("main.xml"), "<scene version='3.0.0'><include filename='part.xml'/></scene>").unwrap();
    let bytes = pack(&folder.path().join("main.xml"), &[]).unwrap();
    let scene = load_bytes("upload", &bytes, &[]).unwrap();
    assert_eq!((scene.root.location.file.as_str(), scene.root.children.len()), ("scene.xml", 1));
}

fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn a_folder_round_everything_in_an_archive_is_taken_off() {
    let bytes = zip(&[("room/scene.json", JSON.as_bytes()), ("room/floor.png", b"pixels")]);
    let scene = load_bytes("room.zip", &bytes, &[]).unwrap();
    assert!(scene.bundle.read("floor.png", &Location::default()).is_ok());
}

#[test]
fn no_path_leads_out_of_a_bundle() {
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("secret"), "secret").unwrap();
    let folder = folder();
    #[cfg(unix)]
    std::os::unix::fs::symlink(outside.path().join("secret"), folder.path().join("link")).unwrap();
    let bundle = load_file(&folder.path().join("room.xml"), &[]).unwrap().bundle;
    let absolute = outside.path().join("secret").display().to_string();
    for name in ["../secret", "parts/../../secret", &absolute, "C:/secret", "..\\secret", "link", "parts", "", "."] {
        assert!(bundle.read(name, &Location::default()).is_err(), "{name}");
    }
    for name in ["../scene.xml", "/scene.xml", "a/../../scene.xml"] {
        let bytes = zip(&[(name, XML.as_bytes()), ("scene.xml", XML.as_bytes())]);
        assert!(load_bytes("a.zip", &bytes, &[]).is_err(), "{name}");
    }
}

/// A scene whose meshes lie beside its folder, and in a folder that it searches.
fn scattered() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    };
    let triangle = |z: f32| format!("v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf 1 2 3\n");
    write("rooms/kitchen/a.obj", &triangle(1.0));
    write("shared/meshes/a.obj", &triangle(2.0));
    write("shared/meshes/b.obj", &triangle(3.0));
    write("shared/parts/lamp.xml", "<emitter type='constant'/>");
    write("rooms/c.obj", &triangle(4.0));
    let mesh = |name: &str| format!("<shape type='obj'><string name='filename' value='{name}'/></shape>");
    let scene = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><path value='../../shared'/><path value='meshes'/>{}{}{}{}\
         <include filename='parts/lamp.xml'/></scene>",
        mesh("a.obj"),
        mesh("b.obj"),
        mesh("../c.obj"),
        mesh("meshes/$mesh.obj")
    );
    write("rooms/kitchen/kitchen.xml", &scene);
    folder
}

/// The heights of the scene's meshes.
fn heights(description: &photonfarm::scene::description::SceneDescription) -> Vec<f32> {
    let scene = photonfarm::scene::Scene::prepare(description).unwrap();
    (0..4).map(|index| scene.geometry.primitive(index).bounds().0.z).collect()
}

/// A scene from elsewhere must not carry off keys and settings of whoever sends it.
#[test]
fn hidden_files_above_a_scene_are_not_packed() {
    let folder = tempfile::tempdir().expect("a folder");
    for (place, text) in [
        (".keys/mesh.ply", "secret"),
        (
            "downloads/scene.xml",
            "<scene version='3.0.0'><shape type='ply'>\
        <string name='filename' value='../.keys/mesh.ply'/></shape></scene>",
        ),
    ] {
        let path = folder.path().join(place);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(path, text).expect("written");
    }
    let refused = pack(&folder.path().join("downloads/scene.xml"), &[]).expect_err("it is refused").to_string();
    assert!(refused.contains("hidden"), "{refused}");
}

#[test]
fn search_folders_and_files_above_the_scene_work_here_and_in_the_archive() {
    let folder = scattered();
    let path = folder.path().join("rooms/kitchen/kitchen.xml");
    let defines = [("mesh".to_owned(), "b".to_owned())];
    let mut here = heights(&load_file(&path, &defines).unwrap());
    here.sort_by(f32::total_cmp);
    // The folder that was named last counts first, and the scene's own at the end.
    assert_eq!(here, [2.0, 3.0, 3.0, 4.0]);
    let bytes = pack(&path, &defines).unwrap();
    assert_eq!(bytes, pack(&path, &defines).unwrap());
    let mut sent = heights(&load_bytes("upload", &bytes, &defines).unwrap());
    sent.sort_by(f32::total_cmp);
    assert_eq!(sent, here);
    // Native files know of no folders above.
    let native = photonfarm::import::native::to_zip(&load_file(&path, &defines).unwrap()).unwrap();
    let mut native = heights(&load_bytes("native", &native, &[]).unwrap());
    native.sort_by(f32::total_cmp);
    assert_eq!(native, here);
}

#[test]
fn names_in_an_archive_stay_inside_of_it() {
    let scene = "<scene version='3.0.0'><path value='../..'/><shape type='obj'><string name='filename' value='a.obj'/></shape>\
                 <shape type='obj'><string name='filename' value='../../../b.obj'/></shape></scene>";
    let bytes = zip(&[("scene.xml", scene.as_bytes())]);
    let description = load_bytes("a.zip", &bytes, &[]).unwrap();
    for name in ["a.obj", "../../../b.obj", "../../a.obj"] {
        assert!(description.bundle.read(name, &Location::default()).is_err(), "{name}");
    }
    let missing = "<scene version='3.0.0'><path value='nowhere'/></scene>";
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.xml"), missing).unwrap();
    let error = load_file(&folder.path().join("a.xml"), &[]).unwrap_err().to_string();
    assert!(error.contains("there is no folder \"nowhere\""), "{error}");
}

#[test]
fn what_mitsuba_passes_over_is_passed_over() {
    for extra in [
        "<sampler type='independent'/>",
        "<film type='hdrfilm'/>",
        "<rfilter type='box'/>",
        "<emitter type='area'/>",
        "<bsdf type='diffuse' id='a'/><ref id='a'/>",
        "<sensor type='perspective'/>",
        "<texture type='checkerboard' id='t'/>",
    ] {
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere'/><emitter type='constant'/>{extra}</scene>"
        );
        let description = load_bytes("a.xml", text.as_bytes(), &[]).unwrap();
        assert!(photonfarm::scene::Scene::prepare(&description).is_ok(), "{extra}");
    }
}

#[test]
fn integrators_hand_their_parameters_on() {
    let integrator = |text: &str| {
        let text = format!(
            "<scene version='3.0.0'>{text}<sensor type='perspective'/><shape type='sphere'/><emitter type='constant'/></scene>"
        );
        let scene = photonfarm::scene::Scene::prepare(&load_bytes("a.xml", text.as_bytes(), &[]).unwrap()).unwrap();
        let own = scene.integrator.map(|own| (own.name, serde_json::Value::Object(own.parameters).to_string()));
        (own, scene.hides_lights)
    };
    let own = |name: &str, parameters: &str| Some((name.to_owned(), parameters.to_owned()));
    let inner = "<integrator type='path'><integer name='max_depth' value='3'/></integrator>";
    for wrapper in ["moment", "stokes"] {
        let found = integrator(&format!("<integrator type='{wrapper}'>{inner}</integrator>"));
        assert_eq!(found, (own("path", "{\"max_depth\":3}"), false));
    }
    let aov = "<string name='aovs' value='dd.y:depth'/>";
    assert_eq!(
        integrator(&format!("<integrator type='aov'>{aov}{inner}</integrator>")).0,
        own("path", "{\"max_depth\":3}")
    );
    assert_eq!(integrator(&format!("<integrator type='aov'>{aov}</integrator>")).0, None);
    let hides = "<boolean name='hide_emitters' value='true'/>";
    let direct = format!("<integrator type='direct'><integer name='bsdf_samples' value='0'/>{hides}</integrator>");
    assert_eq!(integrator(&direct), (own("direct", "{\"material_sampling\":\"off\",\"max_depth\":2}"), true));
    assert_eq!(integrator("<integrator type='prb'/>").0, own("prb", "{\"max_depth\":6}"));
}

#[test]
fn spectra_are_the_colors_of_mitsuba() {
    let color = |place: &str, spectrum: &str| {
        let text = format!(
            "<scene version='3.0.0'><emitter type='constant'><rgb name='radiance' value='1'/></emitter>{place}</scene>"
        );
        let root = load(&text.replace("SPECTRUM", spectrum)).root;
        let shape = &root.children[1].node.children[0].node;
        let Value::Rgb(rgb) = shape.parameters[0].value else { panic!("not a color: {spectrum}") };
        rgb
    };
    let surface = "<shape type='sphere'><bsdf type='diffuse'>SPECTRUM</bsdf></shape>";
    let lamp = "<shape type='sphere'><emitter type='area'>SPECTRUM</emitter></shape>";
    let points = "<spectrum name='x_reflectance' value='400:0.1, 500:0.5, 700:0.9'/>";
    for (place, spectrum, expected) in [
        (surface, points, [0.7754, 0.5935, 0.2770]),
        (lamp, points, [0.9179, 0.5655, 0.2416]),
        (lamp, "<spectrum name='radiance' value='0.5'/>", [0.6024, 0.4741, 0.4545]),
        (surface, "<spectrum name='reflectance' value='0.5'/>", [0.5; 3]),
        (lamp, "<spectrum name='radiance' type='d65'><float name='scale' value='2'/></spectrum>", [2.0; 3]),
        (surface, "<spectrum name='reflectance' type='uniform'><float name='value' value='0.3'/></spectrum>", [0.3; 3]),
        (
            lamp,
            "<spectrum name='radiance' type='irregular'><string name='wavelengths' value='400, 500, 700'/>\
             <string name='values' value='0.1, 0.5, 0.9'/></spectrum>",
            [0.9179, 0.5655, 0.2416],
        ),
        (
            surface,
            "<texture name='reflectance' type='srgb'><rgb name='color' value='0.1, 0.2, 0.3'/></texture>",
            [0.1, 0.2, 0.3],
        ),
    ] {
        let found = color(place, spectrum);
        assert!(found.iter().zip(expected).all(|(one, other)| (one - other).abs() < 5e-4), "{spectrum}: {found:?}");
    }
}

#[test]
fn an_archive_that_expands_too_far_is_refused() {
    let zeros = vec![0; 80 << 20];
    let bytes = zip(&[("scene.xml", XML.as_bytes()), ("floor.png", &zeros)]);
    let error = load_bytes("bomb.zip", &bytes, &[]).unwrap_err().to_string();
    assert!(error.contains("expands too far"), "{error}");
}

#[test]
fn scenes_that_grow_without_bound_are_refused() {
    let deep =
        format!("<scene version='3.0.0'>{}{}</scene>", "<bsdf type='twosided'>".repeat(5000), "</bsdf>".repeat(5000));
    assert!(error(&deep).contains("nest more than 64 deep"));
    let deep = format!("{{\"type\": \"scene\"{}{}", ", \"a\": {\"type\": \"twosided\"".repeat(5000), "}".repeat(5001));
    assert!(error(&deep).contains("malformed JSON: recursion limit"), "{}", error(&deep));
    let chain: String =
        (0..1000).map(|i| format!("<bsdf type='twosided' id='b{i}'><ref id='b{}'/></bsdf>", i + 1)).collect();
    assert!(
        error(&format!("<scene version='3.0.0'>{chain}<bsdf type='diffuse' id='b1000'/></scene>")).contains("deep")
    );
    let doubled: String = (0..40)
        .map(|i| format!("<bsdf type='blendbsdf' id='b{i}'><ref id='b{0}'/><ref id='b{0}'/></bsdf>", i + 1))
        .collect();
    let doubled = format!("<scene version='3.0.0'>{doubled}<bsdf type='diffuse' id='b40'/></scene>");
    assert!(error(&doubled).contains("more than 10000000 plugins"));
    let laughs: String = (0..60).map(|i| format!("<default name='p{}' value='$p{i}$p{i}'/>", i + 1)).collect();
    let laughs = format!("<scene version='3.0.0'><default name='p0' value='ha'/>{laughs}</scene>");
    assert!(error(&laughs).contains("16 MiB"));
}

const OBJ: &str = "# a roof\nmtllib roof.mtl\no roof\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nv 0.5 0.5 1\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nusemtl tiles\ns off\n\
    f 1/1/1 2/2/1 3/3/1 4/1/1\nf -5//1 -4//1 -1//1 # a gable\n";

fn place() -> Location {
    Location { file: "mesh".to_owned(), line: 0, path: "scene/shape[0]".to_owned() }
}

#[test]
fn obj_faces_are_fanned_and_share_vertices() {
    let mesh = obj::read(OBJ.as_bytes(), None, &place()).unwrap().mesh;
    // The second face has no texture coordinates: its corners are vertices of their own.
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
    assert_eq!(mesh.positions[4..], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5, 1.0]]);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 7]);
    assert_eq!(mesh.texture_coordinates[2..5], [[1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]);
    let plain = obj::read(b"v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\nf 3 2 1", None, &place()).unwrap().mesh;
    assert_eq!((plain.positions.len(), plain.normals.len(), plain.texture_coordinates.len()), (3, 0, 0));
    assert_eq!(plain.triangles, [[0, 1, 2], [2, 1, 0]]);
}

const PLY: &str = "ply\nformat ascii 1.0\ncomment a square\nelement camera 1\nproperty float near\nelement vertex 4\n\
    property float x\nproperty float y\nproperty double z\nproperty uchar red\nproperty float s\nproperty float t\n\
    element face 2\nproperty uchar material\nproperty list uchar int vertex_indices\nproperty list uchar float other\n\
    end_header\n0.5\n0 0 0 255 0 0\n1 0 0 255 1 0\n1 1 0 255 1 1\n0 1 0.5 255 0 1\n7 4 0 1 2 3 2 0.5 0.5\n7 3 0 2 1 0\n";

/// The mesh of [`PLY`] in a binary file.
fn binary_ply(big_endian: bool) -> Vec<u8> {
    let encoding = if big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let (header, _) = PLY.split_at(PLY.find("end_header\n").unwrap() + "end_header\n".len());
    let mut bytes = header.replace("ascii", encoding).into_bytes();
    let mut put = |number: &[u8]| match big_endian {
        true => bytes.extend(number.iter().rev()),
        false => bytes.extend(number),
    };
    put(&0.5_f32.to_le_bytes());
    for (x, y, z) in [(0.0_f32, 0.0_f32, 0.0_f64), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.5)] {
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
        put(&z.to_le_bytes());
        put(&[255]);
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
    }
    for (corners, others) in [(&[0_i32, 1, 2, 3][..], 2), (&[0, 2, 1], 0)] {
        put(&[7]);
        put(&[corners.len() as u8]);
        corners.iter().for_each(|corner| put(&corner.to_le_bytes()));
        put(&[others]);
        (0..others).for_each(|_| put(&0.5_f32.to_le_bytes()));
    }
    bytes
}

#[test]
fn ply_encodings_give_one_mesh() {
    let mesh = ply::read(PLY.as_bytes(), &place()).unwrap();
    let expected = TriangleMesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]],
        normals: vec![],
        texture_coordinates: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 2, 1]],
        ..TriangleMesh::default()
    };
    assert_eq!(mesh, expected);
    for big_endian in [false, true] {
        assert_eq!(ply::read(&binary_ply(big_endian), &place()).unwrap(), expected);
    }
}

/// Numbers that are the same in every run (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % bound as u64) as usize
    }

    /// A copy with a few bytes changed, removed or repeated, or cut short.
    fn mutate(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        for _ in 0..=self.below(4) {
            let position = self.below(bytes.len().max(1));
            match self.below(6) {
                _ if bytes.is_empty() => {}
                0 => bytes.truncate(position),
                1 => drop(bytes.remove(position)),
                2 => bytes[position] = b"0-9$.\"<>{}[]/#\n "[self.below(16)],
                3 => {
                    let end = (position + self.below(40)).min(bytes.len());
                    let repeated = bytes[position..end].to_vec();
                    bytes.splice(position..position, repeated);
                }
                4 => bytes[position] = self.below(256) as u8,
                _ => bytes[position] ^= 1 << self.below(8),
            }
        }
        bytes
    }
}

#[test]
fn damaged_files_are_errors_and_never_panics() {
    let archive = zip(&[("scene.xml", XML.as_bytes()), ("floor.png", b"pixels")]);
    let mut numbers = Numbers(1);
    let mut refused = 0;
    for _ in 0..3000 {
        for scene in [XML.as_bytes(), JSON.as_bytes(), &archive] {
            refused += usize::from(load_bytes("scene", &numbers.mutate(scene), &[]).is_err());
        }
        refused += usize::from(obj::read(&numbers.mutate(OBJ.as_bytes()), None, &place()).is_err());
        for mesh in [PLY.as_bytes(), &binary_ply(false), &binary_ply(true)] {
            refused += usize::from(ply::read(&numbers.mutate(mesh), &place()).is_err());
        }
    }
    assert!((3000..21_000).contains(&refused), "{refused}");
}
