//! Scenes of pbrt-v4 come out as the pictures that they mean: cameras, shapes, materials, textures, lights.

use std::f32::consts::PI;
use std::fs;

use photonfarm::import::{load_bytes, load_file, pack};
use photonfarm::math::{Vec2, Vec3};
use photonfarm::scene::Scene;
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value};
use photonfarm::scene::geometry::{Interaction, Ray};
use photonfarm::scene::material::{TransportMode, View};

/// A lamp, so that scenes can be prepared.
const LAMP: &str = "LightSource \"point\" \"rgb I\" [ 1 2 3 ]\n";

fn load(text: &str) -> SceneDescription {
    load_bytes("scene.pbrt", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// A world behind a default camera.
fn world(text: &str) -> SceneDescription {
    load(&format!("Camera \"perspective\"\nWorldBegin\n{text}"))
}

fn prepared(text: &str) -> Scene {
    Scene::prepare(&world(&format!("{LAMP}{text}"))).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn hit(scene: &Scene, origin: [f32; 3], direction: [f32; 3]) -> Option<Interaction> {
    scene.intersect(&Ray::new(Vec3::from_array(origin), Vec3::from_array(direction).normalize()))
}

fn error(text: &str) -> String {
    match load_bytes("scene.pbrt", text.as_bytes(), &[]) {
        Ok(_) => "no error".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// A plugin in one line: numbers rounded, without places.
fn outline(node: &Node) -> String {
    let rounded = |numbers: &[f64]| numbers.iter().map(|number| format!("{number:.3}")).collect::<Vec<_>>().join(" ");
    let value = |value: &Value| match value {
        Value::Float(number) => rounded(&[*number]),
        Value::Rgb(rgb) | Value::Vector(rgb) => rounded(rgb),
        Value::String(text) => text.clone(),
        Value::Integer(number) => number.to_string(),
        Value::Boolean(flag) => flag.to_string(),
        Value::Transform(_) => "…".to_owned(),
    };
    let parameters = node.parameters.iter().map(|parameter| format!("{}={}", parameter.name, value(&parameter.value)));
    let children = node.children.iter().map(|child| match child.name.as_str() {
        "" => outline(&child.node),
        name => format!("{name}:{}", outline(&child.node)),
    });
    format!("{}({})", node.plugin, parameters.chain(children).collect::<Vec<_>>().join(", "))
}

fn of_class(scene: &SceneDescription, class: PluginClass) -> Vec<String> {
    scene.root.children.iter().map(|child| &*child.node).filter(|node| node.class == class).map(outline).collect()
}

fn notices(scene: &SceneDescription) -> String {
    scene.notices.iter().map(|notice| format!("{notice}\n")).collect()
}

#[test]
fn pbrt_cameras_see_points_where_pbrt_does() {
    // Half a unit of y is half the picture's height at depth 1; x is to the right, y upwards.
    let film = "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100\n";
    let cases = [
        ("", [1.0, 0.5, 4.0], [0.5625, 0.4375]),
        ("Scale -1 1 1\n", [1.0, 0.5, 4.0], [0.4375, 0.4375]),
        ("LookAt 0 0 10  0 0 0  0 1 0\n", [-1.0, 0.5, 6.0], [0.5625, 0.4375]),
        ("LookAt 0 0 10  0 0 0  0 1 0\nTranslate 0 0 1\n", [-1.0, 0.5, 5.0], [0.5625, 0.4375]),
        // Columns: the camera stands at z = 8 and looks along -z.
        ("Transform [ 1 0 0 0  0 1 0 0  0 0 -1 0  0 0 8 1 ]\n", [1.0, 0.5, 4.0], [0.5625, 0.4375]),
        ("LookAt 3 1.7 4.1  .5 .2 .3  .1 1 .2\n", [0.5, 0.2, 0.3], [0.5, 0.5]),
        ("Rotate 90 0 1 0\n", [-4.0, 0.5, 1.0], [0.5625, 0.4375]),
    ];
    for (transform, point, expected) in cases {
        let text =
            format!("{film}{transform}Camera \"perspective\" \"float fov\" 90\nWorldBegin\n{LAMP}Shape \"sphere\"");
        let scene = Scene::prepare(&load(&text)).unwrap_or_else(|error| panic!("{error}"));
        let ray = scene.camera.ray(Vec2::from_array(expected), [0.5; 2]);
        let towards = (Vec3::from_array(point) - scene.camera.position()).normalize();
        assert!(ray.direction.distance(towards) < 1e-5, "{transform}: {} is not {towards}", ray.direction);
    }
}

#[test]
fn pbrt_options_have_counterparts() {
    let scene = load(
        "# a comment\nFilm \"rgb\" \"integer xresolution\" [ 40 ] \"integer yresolution\" 20\n\
         \"float cropwindow\" [ .25 .75 0 .5 ] \"string filename\" \"a#b.exr\"\nPixelFilter \"triangle\"\n\
         Integrator \"sppm\" \"integer maxdepth\" 9 \"float radius\" .01 \"integer photonsperiteration\" 500\n\
         Sampler \"halton\"\nScale 2 2 2\nCamera \"perspective\" \"float lensradius\" 1 \"float focaldistance\" 8\n\
         WorldBegin\nShape \"sphere\"",
    );
    assert_eq!(
        of_class(&scene, PluginClass::Sensor),
        ["thinlens(fov=90.000, fov_axis=smaller, near_clip=0.000, far_clip=10000000000.000, to_world=…, \
          aperture_radius=0.500, focus_distance=4.000, hdrfilm(width=40, height=20, crop_offset_x=10, crop_width=20, \
          crop_offset_y=0, crop_height=10, sample_border=true, tent(radius=2.000)))"]
    );
    // pbrt counts bounces, photonfarm segments.
    assert_eq!(
        of_class(&scene, PluginClass::Integrator),
        ["sppm(max_depth=10, photons_per_pass=500, initial_radius=0.010)"]
    );
    let scene = world("");
    assert_eq!(of_class(&scene, PluginClass::Integrator), ["path(max_depth=6)"]);
}

#[test]
fn pbrt_materials_have_counterparts() {
    let cases = [
        ("\"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ]", "twosided(diffuse(reflectance=0.100 0.200 0.300))"),
        (
            "\"coateddiffuse\" \"float roughness\" .25",
            "twosided(roughplastic(distribution=ggx, alpha=0.500, int_ior=1.500, ext_ior=1.000, \
             diffuse_reflectance=0.500 0.500 0.500, nonlinear=true))",
        ),
        (
            "\"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"",
            "twosided(conductor(eta=0.143 0.375 1.442, k=3.983 2.386 1.603))",
        ),
        (
            "\"conductor\" \"rgb eta\" [ 1 2 3 ] \"rgb k\" [ 4 5 6 ] \"float uroughness\" .2 \"float vroughness\" .3 \
             \"bool remaproughness\" false",
            "twosided(roughconductor(distribution=ggx, alpha_u=0.200, alpha_v=0.300, eta=1.000 2.000 3.000, \
             k=4.000 5.000 6.000))",
        ),
        (
            "\"conductor\" \"rgb reflectance\" [ .5 .5 .5 ]",
            "twosided(conductor(eta=1.000 1.000 1.000, k=2.000 2.000 2.000))",
        ),
        ("\"dielectric\" \"spectrum eta\" \"glass-BK7\"", "dielectric(int_ior=1.517, ext_ior=1.000)"),
        (
            "\"dielectric\" \"float roughness\" [ 0.04 ] \"float eta\" 1.8",
            "roughdielectric(distribution=ggx, alpha=0.200, int_ior=1.800, ext_ior=1.000)",
        ),
        ("\"thindielectric\"", "thindielectric(int_ior=1.500, ext_ior=1.000)"),
        ("\"interface\"", "null()"),
        (
            "\"diffusetransmission\" \"rgb reflectance\" [ .6 .3 0 ] \"rgb transmittance\" [ .2 .2 .2 ]",
            "blendbsdf(weight=0.250, twosided(diffuse(reflectance=0.800 0.400 0.000)), \
             difftrans(transmittance=0.800 0.800 0.800))",
        ),
    ];
    for (material, expected) in cases {
        let scene = world(&format!("{LAMP}Material {material}\nShape \"sphere\""));
        assert_eq!(of_class(&scene, PluginClass::Shape), [format!("sphere(radius=1.000, {expected})")], "{material}");
        Scene::prepare(&scene).unwrap_or_else(|error| panic!("{material}: {error}"));
    }
    let mix = world(
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"b\" \"string type\" \"dielectric\"\n\
         Material \"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" .25\nShape \"sphere\" \"float alpha\" .5",
    );
    assert_eq!(
        of_class(&mix, PluginClass::Shape),
        ["sphere(radius=1.000, mask(opacity=0.500, blendbsdf(weight=0.250, \
          twosided(diffuse(reflectance=0.500 0.500 0.500)), dielectric(int_ior=1.500, ext_ior=1.000))))"]
    );
}

#[test]
fn pbrt_lights_have_counterparts() {
    let scene = world(
        "Translate 0 1 0\nLightSource \"point\" \"rgb I\" [ 1 2 3 ] \"float scale\" 2 \"point3 from\" [ 0 0 4 ]\n\
         LightSource \"distant\" \"blackbody L\" 6500 \"point3 to\" [ 0 -1 0 ]\n\
         LightSource \"infinite\" \"rgb L\" [ .5 .5 .5 ]\nLightSource \"spot\"",
    );
    assert_eq!(
        of_class(&scene, PluginClass::Emitter)[..],
        [
            "point(intensity=2.000 4.000 6.000, position=0.000 1.000 4.000)",
            "directional(irradiance=1.043 0.984 1.035, direction=0.000 -1.000 0.000)",
            "constant(radiance=0.500 0.500 0.500)",
            "spot(intensity=1.000 1.000 1.000, cutoff_angle=30.000, beam_width=25.000, to_world=…)",
        ]
    );
}

/// It only hides what is outside of it, and openings without one.
#[test]
fn portals_are_told() {
    let portal = "\"point3 portal\" [0 0 0 1 0 0 1 1 0 0 1 0]";
    let scene = world(&format!("LightSource \"infinite\" \"rgb L\" [ .5 .5 .5 ] {portal}"));
    assert_eq!(of_class(&scene, PluginClass::Emitter), ["constant(radiance=0.500 0.500 0.500)"]);
    assert!(
        scene.notices.iter().any(|notice| notice.subject == "the portal of an infinite light"),
        "{:?}",
        scene.notices
    );
}

const QUAD: &str = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  1 1 0  0 1 0 ] \
    \"point2 uv\" [ 0 0 1 0 1 1 0 1 ] \"integer indices\" [ 0 1 2 0 2 3 ]";

#[test]
fn pbrt_outsides_are_where_pbrt_has_them() {
    let toward_viewer = |shape: &str| {
        let scene = prepared(&format!("AreaLightSource \"diffuse\"\n{shape}"));
        hit(&scene, [0.5, 0.4, 9.0], [0.0, 0.0, -1.0])
            .unwrap_or_else(|| panic!("{shape} is not hit"))
            .geometric_normal
            .z
            > 0.0
    };
    let normals = |z: i32| format!("{QUAD} \"normal N\" [ 0 0 {z} 0 0 {z} 0 0 {z} 0 0 {z} ]");
    let mirror = "Translate 1 0 0\nScale -1 1 1\n";
    let cases = [
        (QUAD.to_owned(), true),
        (format!("ReverseOrientation\n{QUAD}"), false),
        (format!("{mirror}{QUAD}"), true),
        (format!("{mirror}ReverseOrientation\n{QUAD}"), false),
        (normals(1), true),
        (normals(-1), false),
        (format!("ReverseOrientation\n{}", normals(-1)), true),
        (format!("{mirror}{}", normals(-1)), false),
        ("Shape \"sphere\"".to_owned(), true),
        (format!("{mirror}Shape \"sphere\""), true),
        ("ReverseOrientation\nShape \"sphere\"".to_owned(), false),
        ("Shape \"sphere\" \"float phimax\" 350".to_owned(), true),
        ("Scale 1 .75 1\nShape \"sphere\"".to_owned(), true),
        ("Shape \"disk\" \"float height\" 2".to_owned(), true),
        ("Shape \"disk\" \"float innerradius\" .1".to_owned(), true),
        ("Rotate 90 0 1 0\nShape \"cylinder\"".to_owned(), true),
        ("Rotate 90 0 1 0\nShape \"cylinder\" \"float phimax\" 359".to_owned(), true),
        ("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]".to_owned(), true),
    ];
    for (shape, expected) in cases {
        assert_eq!(toward_viewer(&shape), expected, "{shape}");
    }
}

#[test]
fn pbrt_images_stand_upright() {
    let folder = tempfile::tempdir().expect("a folder");
    // 1 × 2, uncompressed, the first row on top: red over green, as blue, green, red.
    let mut image = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 2, 0, 24, 0x20];
    image.extend([0, 0, 255, 0, 255, 0]);
    fs::write(folder.path().join("flag.tga"), image).expect("written");
    let path = folder.path().join("flag.pbrt");
    let color = |texture: &str, shape: &str, place: [f32; 2]| {
        let text = format!(
            "Camera \"perspective\"\nWorldBegin\n{LAMP}Texture \"t\" \"spectrum\" {texture}\n\
             Material \"diffuse\" \"texture reflectance\" \"t\"\n{shape}"
        );
        fs::write(&path, text).expect("written");
        let scene = load_file(&path, &[]).and_then(|description| Scene::prepare(&description));
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        let hit = hit(&scene, [place[0], place[1], 9.0], [0.0, 0.0, -1.0]).expect("the shape is hit");
        let material = scene.material(hit.shape);
        (material.evaluate(&View::new(hit.uv, Vec3::Z, TransportMode::Radiance), Vec3::Z) * PI).to_array()
    };
    let image = "\"imagemap\" \"string filename\" \"flag.tga\" \"string filter\" \"point\"";
    let near = |color: [f32; 3], expected: [f32; 3]| {
        assert!(Vec3::from_array(color).distance(Vec3::from_array(expected)) < 1e-5, "{color:?} is not {expected:?}");
    };
    let (red, green) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    near(color(image, QUAD, [0.5, 0.9]), red);
    near(color(image, QUAD, [0.5, 0.1]), green);
    // Twice as dense and moved up by a tenth of the image: v = 0.2 looks at 2·0.2 + 0.2 = 0.6.
    let dense = format!("{image} \"float vscale\" 2 \"float vdelta\" .2 \"float scale\" .5");
    near(color(&dense, QUAD, [0.5, 0.2]), [0.5, 0.0, 0.0]);
    near(color(&dense, QUAD, [0.5, 0.1]), [0.0, 0.5, 0.0]);
    // Upright on a sphere whose pole is up.
    let sphere = "Rotate -90 1 0 0\nShape \"sphere\"";
    near(color(image, sphere, [0.0, 0.5]), red);
    near(color(image, sphere, [0.0, -0.5]), green);
    let board = "\"checkerboard\" \"float uscale\" 2 \"float vscale\" 4 \"rgb tex1\" [ 1 0 0 ] \"rgb tex2\" [ 0 1 0 ]";
    near(color(board, QUAD, [0.1, 0.1]), red);
    near(color(board, QUAD, [0.6, 0.1]), green);
    near(color(board, QUAD, [0.1, 0.3]), green);
    near(color(board, QUAD, [0.6, 0.3]), red);
}

#[test]
fn pbrt_objects_stand_where_both_transforms_put_them() {
    let scene = prepared(
        "AttributeBegin\nTranslate 0 0 5\nObjectBegin \"ball\"\nMaterial \"diffuse\"\nScale .5 .5 .5\nShape \"sphere\"\n\
         ObjectEnd\nAttributeEnd\nTranslate 10 0 0\nScale 2 1 1\nObjectInstance \"ball\"\n\
         CoordSysTransform \"camera\"\nObjectInstance \"ball\"\nShape \"sphere\" \"float radius\" .1",
    );
    let depth = |x: f32| hit(&scene, [x, 0.0, 20.0], [0.0, 0.0, -1.0]).map(|hit| hit.position.z);
    assert!(depth(10.0).is_some_and(|z| (z - 5.5).abs() < 1e-4), "{:?}", depth(10.0));
    assert!(depth(10.9).is_some() && depth(11.1).is_none());
    assert!(depth(0.0).is_some_and(|z| (z - 5.5).abs() < 1e-4), "{:?}", depth(0.0));
}

#[test]
fn pbrt_scenes_travel_with_their_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    fs::create_dir(folder.path().join("parts")).expect("made");
    write("parts/world.pbrt", &format!("{LAMP}Shape \"plymesh\" \"string filename\" \"parts/mesh.ply\"\n{QUAD}"));
    write(
        "parts/mesh.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    write("lot.pbrt", "Camera \"perspective\"\nWorldBegin\nInclude \"parts/world.pbrt\"\n");
    let path = folder.path().join("lot.pbrt");
    let own = load_file(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
    let packed = load_bytes("lot", &pack(&path, &[]).expect("packed"), &[]).unwrap_or_else(|error| panic!("{error}"));
    let expected = [
        "ply(filename=parts/mesh.ply, flip_tex_coords=true, face_normals=true)",
        "ply(filename=pbrt-0.ply, face_normals=true)",
    ];
    assert_eq!(of_class(&own, PluginClass::Shape), expected);
    assert_eq!(of_class(&packed, PluginClass::Shape), expected);
    Scene::prepare(&packed).unwrap_or_else(|error| panic!("{error}"));
    write("lot.pbrt", "Include \"lot.pbrt\"");
    let error = load_file(&path, &[]).expect_err("a circle").to_string();
    assert!(error.starts_with("lot.pbrt:1 (Include): files include files more than 32 deep"), "{error}");
}

#[test]
fn pbrt_errors_name_file_line_and_remedy() {
    let world = |text: &str| format!("Camera \"perspective\"\nWorldBegin\n{text}");
    let cases = [
        (world("Shap \"sphere\""), "scene.pbrt:3 (Shap): there is no directive \"Shap\"; did you mean \"Shape\"?"),
        (world("Shape \"spere\""), "scene.pbrt:3 (Shape): there is no shape \"spere\"; did you mean \"sphere\"?"),
        (world("\n[ 3 ]"), "scene.pbrt:4: \"[\" stands where a directive is expected; check the lines before it"),
        (world("Shape \"sphere\" \"float radius\" [ 1"), "parameter \"radius\": the file ends here"),
        (world("Shape \"sphere\" \"flot radius\" 1"), "there is no parameter type \"flot\"; did you mean \"float\"?"),
        (world("Shape \"sphere\" \"float radius\" nan"), "\"nan\" is not a finite number"),
        (world("Shape \"sphere\" \"float radius\" -1"), "\"radius\" is -1; give a number above 0"),
        (world("Shape \"sphere"), "scene.pbrt:3: the string \"sphere\" has no end"),
        (world("NamedMaterial \"gold\""), "no material \"gold\" was made before; make it with MakeNamedMaterial first"),
        (
            world("MakeNamedMaterial \"gold\" \"string type\" \"conductor\"\nNamedMaterial \"golf\""),
            "no material \"golf\" was made before; did you mean \"gold\"?",
        ),
        (world("MediumInterface \"fog\" \"\""), "there is no medium \"fog\"; make it with MakeNamedMedium first"),
        (world("ObjectInstance \"tree\""), "there is no object \"tree\""),
        (world("AttributeEnd"), "scene.pbrt:3 (AttributeEnd): nothing is open that it ends; remove it"),
        (world("AttributeBegin\nTransformEnd"), "scene.pbrt:4 (TransformEnd): AttributeEnd must come before it"),
        (world("AttributeBegin"), "the file ends before an AttributeBegin"),
        (world("Scale 1 0 1"), "scene.pbrt:3 (Scale): the transform flattens"),
        (world("Transform [ 1 2 3 ]"), "scene.pbrt:3 (Transform): \"]\" is not a number; write 16 numbers"),
        (world("Shape \"trianglemesh\" \"point3 P\" [ 1 2 ]"), "parameter \"P\": 2 numbers are not a multiple of 3"),
        (
            world("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 3 ]"),
            "index 3 in a mesh of 3 points",
        ),
        (
            world("Material \"diffuse\" \"texture reflectance\" \"wood\""),
            "there is no texture \"wood\" of this type; define it with Texture first",
        ),
        (world("Shape \"plymesh\" \"string filename\" \"../a.ply\""), "leads upwards"),
        (world("Shape \"plymesh\" \"string filename\" \"a.ply.gz\""), "there is no file \"a.ply.gz\""),
        (world("Film \"rgb\""), "scene.pbrt:3 (Film): it stands after WorldBegin"),
        ("WorldBegin".to_owned(), "the scene has no Camera"),
        ("Camera \"spherical\"".to_owned(), "has the mapping \"equalarea\""),
        ("Camera \"perspective\" \"float screenwindow\" [ 1 0 0 1 ]".to_owned(), "the screenwindow is empty"),
    ];
    for (text, expected) in cases {
        let error = error(&text);
        assert!(error.contains(expected), "{text}\n{error}\ndoes not contain\n{expected}");
    }
}

#[test]
fn pbrt_losses_are_told() {
    let scene = world(
        "MakeNamedMedium \"fog\" \"string type\" \"cloud\"\nMaterial \"diffuse\" \"string normalmap\" \"n.png\"\nShape \"sphere\" \"float fuzz\" 3\n\
         Shape \"curve\"\nAreaLightSource \"diffuse\" \"float fuzz\" 3\n",
    );
    let expected = [
        "scene.pbrt:3 (MakeNamedMedium): a medium \"cloud\" is ignored",
        "scene.pbrt:4 (Material): parameter \"normalmap\" of material \"diffuse\" is ignored",
        "scene.pbrt:5 (Shape): parameter \"fuzz\" of shape \"sphere\" is ignored",
        "scene.pbrt:6 (Shape): shape \"curve\" is ignored",
        "scene.pbrt:7 (AreaLightSource): parameter \"fuzz\" of area light \"diffuse\" is ignored",
    ];
    let told = notices(&scene);
    for notice in expected {
        assert!(told.contains(notice), "{told}");
    }
}

#[test]
fn pbrt_parameters_that_nobody_asked_for_are_told_with_what_was_meant() {
    let text = "Material \"diffuse\" \"rgb reflectanse\" [ 0.1 0.2 0.3 ]\nShape \"sphere\" \"float radios\" 3 \"float zmix\" 1\n\
        LightSource \"point\" \"rgb L\" 3\nAreaLightSource \"diffuse\" \"bool twosidet\" true\n";
    let told = notices(&world(text));
    for notice in [
        "parameter \"reflectanse\" of material \"diffuse\" is ignored: did you mean \"reflectance\"?",
        "parameter \"radios\" of shape \"sphere\" is ignored: did you mean \"radius\"?",
        "parameter \"twosidet\" of area light \"diffuse\" is ignored: did you mean \"twosided\"?",
    ] {
        assert!(told.contains(notice), "no {notice} in {told}");
    }
}

/// pbrt looks from the last parameter on.
#[test]
fn the_last_pbrt_parameter_of_a_name_counts() {
    let scene = world("Shape \"sphere\" \"float radius\" 3 \"float radius\" 2");
    assert!(
        of_class(&scene, PluginClass::Shape)[0].contains("radius=2.000"),
        "{:?}",
        of_class(&scene, PluginClass::Shape)
    );
    let told = notices(&scene);
    let expected = "parameter \"radius\" of shape \"sphere\" is ignored: a later one of this name counts";
    assert!(told.contains(expected), "{told}");
}

/// pbrt's equirectangular mapping: column x of the picture looks towards longitude 2π x from +x to +z, row y to the polar angle π y from +y.
#[test]
fn pbrt_spherical_cameras_see_points_where_pbrt_does() {
    let text = "LookAt 1 2 3  1 2 4  0 1 0\nCamera \"spherical\" \"string mapping\" \"equirectangular\"\nWorldBegin\n";
    let scene = Scene::prepare(&load(&format!("{text}{LAMP}"))).expect("a good scene");
    for (x, y) in [(0.1f32, 0.2f32), (0.4, 0.5), (0.8, 0.7), (0.99, 0.4)] {
        let (longitude, polar) = (2.0 * PI * x, PI * y);
        let seen = Vec3::new(polar.sin() * longitude.cos(), polar.cos(), polar.sin() * longitude.sin());
        let ray = scene.camera.ray(Vec2::new(x, y), [0.5; 2]);
        assert!(ray.direction.abs_diff_eq(seen, 1e-5), "{} is not {seen}", ray.direction);
        let back = scene.camera.look_at(Vec3::new(1.0, 2.0, 3.0) + seen * 5.0, [0.5; 2]).expect("it is seen");
        assert!(back.film.abs_diff_eq(Vec2::new(x, y), 1e-5), "{} is not {x}, {y}", back.film);
    }
}

#[test]
fn pbrt_media_lie_between_shapes() {
    let medium = "MakeNamedMedium \"tea\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [3 2 0] \"float g\" .5\n\
                  MediumInterface \"tea\" \"\"\nShape \"sphere\"\nMediumInterface \"\" \"\"\nShape \"sphere\"\n";
    let scene = world(medium);
    let media = of_class(&scene, PluginClass::Medium);
    assert_eq!(media, ["homogeneous(sigma_t=4.000 4.000 3.000, albedo=0.750 0.500 0.000, scale=1.000, hg(g=0.500))"]);
    let shapes = of_class(&scene, PluginClass::Shape);
    assert!(shapes[0].contains("interior:homogeneous") && !shapes[1].contains("homogeneous"), "{shapes:?}");
    assert!(of_class(&scene, PluginClass::Integrator)[0].starts_with("volpath"));
    assert!(error("WorldBegin\nMediumInterface \"tee\" \"\"").contains("there is no medium \"tee\""));
}

#[test]
fn no_damage_makes_the_pbrt_import_panic() {
    let good = format!(
        "LookAt 0 0 9 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" [ 40 ]\nFilm \"rgb\" \"integer xresolution\" [ 8 ]\n\
         WorldBegin\nTexture \"c\" \"float\" \"constant\" \"float value\" .5\nMakeNamedMaterial \"m\" \"string type\" \
         \"conductor\" \"texture roughness\" \"c\"\nNamedMaterial \"m\"\nAttributeBegin\nRotate 30 0 1 0\n\
         AreaLightSource \"diffuse\" \"blackbody L\" [ 3000 ]\n{QUAD}\nAttributeEnd\nShape \"disk\" \"float phimax\" 90\n\
         ObjectBegin \"o\"\nShape \"sphere\"\nObjectEnd\nObjectInstance \"o\"\n"
    );
    assert_eq!(error(&good), "no error");
    for place in 0..good.len() {
        let damages: [&[u8]; 7] = [b"\"", b"[", b"]", b"-", b"9999999999", b"\n", b"\xff"];
        for damage in damages {
            let mut bytes = good.as_bytes().to_vec();
            bytes.splice(place..place + 1, damage.iter().copied());
            let _ = load_bytes("scene.pbrt", &bytes, &[]);
        }
        let _ = load_bytes("scene.pbrt", &good.as_bytes()[..place], &[]);
    }
}

#[test]
fn pbrt_is_told_by_its_first_directive() {
    let text = format!("# a scene\n\nCamera \"perspective\"\nWorldBegin\n{LAMP}");
    assert!(load_bytes("upload", text.as_bytes(), &[]).is_ok());
    assert!(load_bytes("upload", b"Hello \"perspective\"", &[]).is_err());
}
