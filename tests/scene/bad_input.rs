//! What users read when a well-formed scene cannot be rendered, or a method cannot take its parameters: every error has
//! its place and a remedy.

use std::fmt::Write as _;
use std::time::Instant;

use crate::scene_text::prepare;
use photonfarm::import::load_bytes;
use photonfarm::method::{MethodChoice, check};

const LIGHT: &str = "<emitter type='point'><point name='position' value='0, 5, 0'/></emitter>";
const SENSOR: &str = "<sensor type='perspective'/>";
const SHAPE: &str = "<shape type='rectangle'><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></shape>";

/// The errors of `cases`, one below the other. `$` stands for a sensor, a shape and a light.
fn report(cases: &[(&str, &str)], files: &[(&str, String)]) -> String {
    let mut report = String::new();
    for (what, body) in cases {
        let body = body.replace('$', &format!("{SENSOR}{SHAPE}{LIGHT}"));
        match prepare(&body, files) {
            Ok(_) => panic!("{what} is no error"),
            Err(error) => writeln!(report, "{what}\n    {error}").unwrap(),
        }
    }
    report
}

#[test]
fn scenes_that_lack_something() {
    let only = |parts: &[&str]| parts.concat();
    let dark_area =
        "<shape type='rectangle'><emitter type='area'><rgb name='radiance' value='0, 0, 0'/></emitter></shape>";
    let cases = [
        ("empty scene", String::new()),
        ("no sensor", only(&[SHAPE, LIGHT])),
        ("no light", only(&[SENSOR, SHAPE])),
        ("light of radiance 0", only(&[SENSOR, dark_area])),
        (
            "light of intensity 0",
            only(&[SENSOR, SHAPE, "<emitter type='point'><rgb name='intensity' value='0, 0, 0'/></emitter>"]),
        ),
        ("two environments", only(&[SENSOR, SHAPE, "<emitter type='constant'/><emitter type='constant'/>"])),
        ("no light but an area light outside of a shape", only(&[SENSOR, SHAPE, "<emitter type='area'/>"])),
        ("point light in a shape", only(&[SENSOR, LIGHT, "<shape type='cube'><emitter type='point'/></shape>"])),
    ];
    let cases: Vec<(&str, &str)> = cases.iter().map(|(what, body)| (*what, body.as_str())).collect();
    insta::assert_snapshot!(report(&cases, &[]));
}

#[test]
fn shapes_that_cannot_be() {
    let cases = [
        ("radius that is not a number", "$<shape type='sphere'><float name='radius' value='nan'/></shape>"),
        ("infinite radius", "$<shape type='sphere'><float name='radius' value='inf'/></shape>"),
        ("negative radius", "$<shape type='sphere'><float name='radius' value='-1'/></shape>"),
        ("cylinder of radius 0", "$<shape type='cylinder'><float name='radius' value='0'/></shape>"),
        ("cylinder without height", "$<shape type='cylinder'><point name='p1' value='0, 0, 0'/></shape>"),
        (
            "rectangle without area",
            "$<shape type='rectangle'><transform name='to_world'><scale x='0'/></transform></shape>",
        ),
        (
            "cube too large for single precision",
            "$<shape type='cube'><transform name='to_world'><scale value='1e39'/></transform></shape>",
        ),
        (
            "disk that reaches too far",
            "$<shape type='disk'><transform name='to_world'><scale x='1.8e19'/></transform></shape>",
        ),
        (
            "instance that reaches too far",
            "$<shape type='shapegroup' id='g'><shape type='cube'/></shape>\
             <shape type='instance'><ref id='g'/><transform name='to_world'><translate x='-2e18'/></transform></shape>",
        ),
        (
            "perspective as a place",
            "$<shape type='cube'><transform name='to_world'><matrix value='1 0 0 0  0 1 0 0  0 0 1 0  0 0 1 1'/></transform></shape>",
        ),
        ("unknown shape", "$<shape type='shpere'/>"),
        ("unknown parameter", "$<shape type='sphere'><float name='raduis' value='1'/></shape>"),
        ("parameter of another type", "$<shape type='sphere'><string name='radius' value='one'/></shape>"),
    ];
    insta::assert_snapshot!(report(&cases, &[]));
}

/// Where all neighbours look alike, a tree that is built from below has nothing to choose by.
#[test]
fn equal_triangles_do_not_take_forever() {
    let mesh = |step: usize| {
        let mut text = String::new();
        for index in 0..40_000 {
            let x = 2 * step * index;
            writeln!(text, "v {x} 0 0\nv {} 0 0\nv {x} 1 0\nf -3 -2 -1", x + 1).unwrap();
        }
        text
    };
    for step in [0, 1] {
        let began = Instant::now();
        let shape = "<shape type='obj'><string name='filename' value='a.obj'/></shape>";
        let scene = prepare(&format!("{SENSOR}{LIGHT}{shape}"), &[("a.obj", mesh(step))]);
        assert!(scene.is_ok(), "{:?}", scene.err());
        // It takes half a second; it took minutes.
        assert!(began.elapsed().as_secs() < 30, "{:?}", began.elapsed());
    }
}

#[test]
fn meshes_that_cannot_be() {
    let files = [
        ("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"),
        ("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
        ("flats.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n"),
        ("empty.obj", "v 0 0 0\n"),
        (
            "range.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
        ),
        (
            "nan.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
        ),
    ];
    let mesh = |name: &str| {
        let kind = &name[name.len() - 3..];
        format!("$<shape type='{kind}'><string name='filename' value='{name}'/></shape>")
    };
    let bodies: Vec<(&str, String)> =
        files.iter().map(|(name, _)| *name).chain(["missing.obj"]).map(|name| (name, mesh(name))).collect();
    let mut cases: Vec<(&str, &str)> = bodies.iter().map(|(name, body)| (*name, body.as_str())).collect();
    cases.push(("no file name", "$<shape type='obj'/>"));
    let files: Vec<(&str, String)> = files.iter().map(|(name, text)| (*name, (*text).to_owned())).collect();
    insta::assert_snapshot!(report(&cases, &files));
}

#[test]
fn instances_that_cannot_be() {
    let group = |shapes: &str| format!("$<shape type='shapegroup' id='g'>{shapes}</shape>");
    let place = "<shape type='instance'><ref id='g'/></shape>";
    let nested = "<shape type='shapegroup' id='g'><shape type='cube'/></shape>";
    let glow = "<shape type='cube'><emitter type='area'/></shape>";
    let flat = "<transform name='to_world'><scale z='0'/></transform>";
    let tiny = "<transform name='to_world'><scale value='1e-39'/></transform>";
    let cases = [
        ("group in a group", format!("$<shape type='shapegroup'>{nested}</shape>")),
        ("instance in a group", format!("$<shape type='shapegroup'>{nested}{place}</shape>")),
        (
            "instance alone in a group",
            format!("{}<shape type='shapegroup'>{place}</shape>", group("<shape type='cube'/>")),
        ),
        ("light in a group", group(glow)),
        ("empty group", group("")),
        ("place of a group", group("<transform name='to_world'/><shape type='cube'/>")),
        ("instance of nothing", "$<shape type='instance'/>".to_owned()),
        ("instance of a shape", "$<shape type='cube' id='g'/><shape type='instance'><ref id='g'/></shape>".to_owned()),
        (
            "instance with a material",
            format!(
                "{}<shape type='instance'><ref id='g'/><bsdf type='diffuse'/></shape>",
                group("<shape type='cube'/>")
            ),
        ),
        (
            "flat instance",
            format!("{}<shape type='instance'><ref id='g'/>{flat}</shape>", group("<shape type='cube'/>")),
        ),
        (
            "tiny instance",
            format!("{}<shape type='instance'><ref id='g'/>{tiny}</shape>", group("<shape type='cube'/>")),
        ),
    ];
    let cases: Vec<(&str, &str)> = cases.iter().map(|(what, body)| (*what, body.as_str())).collect();
    insta::assert_snapshot!(report(&cases, &[]));
}

#[test]
fn materials_and_lights_that_cannot_be() {
    let cases = [
        ("unknown bsdf", "$<bsdf type='difuse'/>"),
        ("reflectance above 1", "$<bsdf type='diffuse'><rgb name='reflectance' value='0.5, 1.5, 0.5'/></bsdf>"),
        ("reflectance below 0", "$<bsdf type='diffuse'><rgb name='reflectance' value='0.5, -0.5, 0.5'/></bsdf>"),
        ("two-sided glass", "$<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>"),
        ("empty twosided", "$<bsdf type='twosided'/>"),
        ("unknown medium", "$<bsdf type='dielectric'><string name='int_ior' value='dimond'/></bsdf>"),
        ("index of refraction 0", "$<bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf>"),
        ("unknown metal", "$<bsdf type='conductor'><string name='material' value='Agg'/></bsdf>"),
        ("eta without k", "$<bsdf type='conductor'><float name='eta' value='1'/></bsdf>"),
        ("unknown emitter", "$<emitter type='sunskies'/>"),
        ("negative intensity", "$<emitter type='point'><rgb name='intensity' value='-1, 0, 0'/></emitter>"),
        (
            "intensity that is not a number",
            "$<emitter type='point'><rgb name='intensity' value='nan, 0, 0'/></emitter>",
        ),
        ("spot without a cone", "$<emitter type='spot'><float name='cutoff_angle' value='0'/></emitter>"),
        ("beam wider than the cone", "$<emitter type='spot'><float name='beam_width' value='30'/></emitter>"),
        (
            "sun without a direction",
            "$<emitter type='directional'><vector name='direction' value='0, 0, 0'/></emitter>",
        ),
    ];
    insta::assert_snapshot!(report(&cases, &[]));
}

#[test]
fn rough_and_mixed_materials_that_cannot_be() {
    let cases = [
        ("roughness 0", "$<bsdf type='roughconductor'><float name='alpha' value='0'/></bsdf>"),
        (
            "alpha and alpha_u",
            "$<bsdf type='roughconductor'><float name='alpha' value='0.1'/><float name='alpha_u' value='0.1'/></bsdf>",
        ),
        ("alpha_v without alpha_u", "$<bsdf type='ward'><float name='alpha_v' value='0.1'/></bsdf>"),
        ("anisotropic plastic", "$<bsdf type='roughplastic'><float name='alpha_u' value='0.1'/></bsdf>"),
        ("unknown distribution", "$<bsdf type='roughdielectric'><string name='distribution' value='gxx'/></bsdf>"),
        (
            "boundary between equal media",
            "$<bsdf type='plastic'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1.5'/></bsdf>",
        ),
        ("unknown variant", "$<bsdf type='ward'><string name='variant' value='ward-dur'/></bsdf>"),
        (
            "matte and glossy shares above 1",
            "$<bsdf type='ward'><rgb name='specular_reflectance' value='0.75'/></bsdf>",
        ),
        ("blend without a weight", "$<bsdf type='blendbsdf'><bsdf type='diffuse'/><bsdf type='diffuse'/></bsdf>"),
        ("blend of one", "$<bsdf type='blendbsdf'><float name='weight' value='0.5'/><bsdf type='diffuse'/></bsdf>"),
        (
            "weight above 1",
            "$<bsdf type='blendbsdf'><float name='weight' value='1.5'/><bsdf type='diffuse'/><bsdf type='diffuse'/></bsdf>",
        ),
        ("empty mask", "$<bsdf type='mask'/>"),
        ("two-sided hole", "$<bsdf type='twosided'><bsdf type='mask'><bsdf type='diffuse'/></bsdf></bsdf>"),
        (
            "eta and specular",
            "$<bsdf type='principled'><float name='eta' value='1.5'/><float name='specular' value='0.5'/></bsdf>",
        ),
        ("metallic above 1", "$<bsdf type='principled'><float name='metallic' value='2'/></bsdf>"),
        ("unknown principled parameter", "$<bsdf type='principled'><float name='clear_coat' value='1'/></bsdf>"),
    ];
    insta::assert_snapshot!(report(&cases, &[]));
}

#[test]
fn pictures_that_cannot_be() {
    let film =
        |film: &str| format!("<sensor type='perspective'><film type='hdrfilm'>{film}</film></sensor>{SHAPE}{LIGHT}");
    let sensor = |sensor: &str| format!("<sensor type='perspective'>{sensor}</sensor>{SHAPE}{LIGHT}");
    let inside = |bsdf: &str| {
        format!(
            "<sensor type='perspective'/><shape type='sphere'><float name='radius' value='4'/>{bsdf}</shape>{LIGHT}"
        )
    };
    let cases = [
        ("0 pixels", film("<integer name='width' value='0'/>")),
        ("a negative width", film("<integer name='width' value='-5'/>")),
        ("10⁹ pixels", film("<integer name='width' value='40000'/><integer name='height' value='25000'/>")),
        ("unknown film", format!("<sensor type='perspective'><film type='hdrflim'/></sensor>{SHAPE}{LIGHT}")),
        ("fov of 180", sensor("<float name='fov' value='180'/>")),
        ("near behind far", sensor("<float name='near_clip' value='5'/><float name='far_clip' value='1'/>")),
        ("unknown sensor", format!("<sensor type='perspctive'/>{SHAPE}{LIGHT}")),
        ("lens without aperture", format!("<sensor type='thinlens'/>{SHAPE}{LIGHT}")),
        ("camera inside a solid", inside("<bsdf type='diffuse'/>")),
    ];
    let cases: Vec<(&str, &str)> = cases.iter().map(|(what, body)| (*what, body.as_str())).collect();
    insta::assert_snapshot!(report(&cases, &[]));
    // Inside glass, or a room whose inside is not black, is a good place.
    for bsdf in ["<bsdf type='dielectric'/>", "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>", ""] {
        assert!(prepare(&inside(bsdf), &[]).is_ok(), "a camera inside {bsdf}");
    }
}

#[test]
fn parameters_that_cannot_be() {
    let cases = [
        ("pth", "{}"),
        ("spppm", "{}"),
        ("sppm", r#"{"alpha": 0}"#),
        ("sppm", r#"{"alpha": 1}"#),
        ("sppm", r#"{"alpha": -0.5}"#),
        ("sppm", r#"{"alpha": "much"}"#),
        ("sppm", r#"{"photons_per_pass": 0}"#),
        ("sppm", r#"{"photons_per_pass": 1e9}"#),
        ("sppm", r#"{"photons_per_pass": "many"}"#),
        ("sppm", r#"{"initial_radius": 0}"#),
        ("sppm", r#"{"initial_radius": -1}"#),
        ("sppm", r#"{"initial_radius": 1e-30}"#),
        ("sppm", r#"{"radius_rule": "statistic"}"#),
        ("sppm", r#"{"direct": "none"}"#),
        ("sppm", r#"{"max_depth": 0}"#),
        ("sppm", r#"{"rr_depth": 0}"#),
        ("sppm", r#"{"passes": 0}"#),
        ("sppm", r#"{"photon_per_pass": 1000}"#),
        ("sppm", r#"{"samples_per_pixel": 4}"#),
        ("ppm", r#"{"samples_per_pixel": 0}"#),
        ("path", r#"{"light_sampling": "maybe"}"#),
        ("path", r#"{"alpha": 0.5}"#),
        ("bdpt", r#"{"strategy": "2"}"#),
        ("bdpt", r#"{"length": 0}"#),
        ("bdpm", r#"{"weights": "good"}"#),
        ("pbdpm", r#"{"alpha": 1.5}"#),
        ("vcm", r#"{"heuristic": "maximum"}"#),
    ];
    let mut report = String::new();
    for (method, text) in cases {
        let parameters = serde_json::from_str(text).expect("the test's JSON is good");
        match check(&MethodChoice { name: method.to_owned(), parameters }, 100) {
            Ok(_) => panic!("{method} {text} is no error"),
            Err(error) => writeln!(report, "{method} {text}\n    {error}").unwrap(),
        }
    }
    insta::assert_snapshot!(report);
}

/// Old scenes that would need more memory or stack than there is, if they were taken at their word.
#[test]
fn hostile_old_scenes_are_refused() {
    let nested = |tag: &str, inner: &str| {
        let (open, close) = (format!("<bsdf type='{tag}'>").repeat(100_000), "</bsdf>".repeat(100_000));
        format!("<scene version='0.5.0'>{open}{inner}{close}</scene>")
    };
    let doubling: String = (1..40)
        .map(|level| format!("<bsdf type='coating' id='b{level}'><bsdf type='twosided'><ref id='b{0}'/><ref id='b{0}'/></bsdf></bsdf>", level - 1))
        .collect();
    let cases = [
        ("deep nesting", nested("twosided", "")),
        ("deep coatings", nested("coating", "<bsdf type='diffuse'/>")),
        (
            "entity bomb",
            "<!DOCTYPE s [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]><scene version='0.5.0'>&b;</scene>".to_owned(),
        ),
        ("references that double", format!("<scene version='0.5.0'><bsdf type='diffuse' id='b0'/>{doubling}</scene>")),
        ("an include of itself", "<scene version='0.5.0'><include filename='room.xml'/></scene>".to_owned()),
        ("cut short", "<scene version='0.5.0'><shape type='cu".to_owned()),
    ];
    let mut report = String::new();
    for (what, text) in cases {
        match load_bytes("room.xml", text.as_bytes(), &[]) {
            Ok(_) => panic!("{what} is no error"),
            Err(error) => writeln!(report, "{what}\n    {error}").unwrap(),
        }
    }
    insta::assert_snapshot!(report);
    // What is passed over may be deep.
    let hidden = format!("<scene version='0.5.0'>{}{}</scene>", "<hide>".repeat(100_000), "</hide>".repeat(100_000));
    assert!(load_bytes("room.xml", hidden.as_bytes(), &[]).is_ok_and(|scene| scene.notices.len() == 1));
}

/// Whatever is cut out of an old scene or repeated in it, reading ends, with a scene or an error.
#[test]
fn damaged_old_scenes_never_panic() {
    const SCENE: &str = "<scene version='0.4.0'><integrator type='irrcache'><integrator type='mlt'/></integrator>\
        <bsdf type='mixturebsdf' id='m'><string name='weights' value='0.5 0.2'/><bsdf type='coating'><bsdf type='hk'/></bsdf>\
        <bsdf type='phong'/></bsdf><texture type='gridtexture' id='g'/><bsdf type='diffuse' id='d'><ref id='g' name='reflectance'/></bsdf>\
        <shape type='cube'><ref id='m'/><medium type='homogeneous' id='f'/></shape><shape type='hair' id='h'/><emitter type='sky'/>\
        <sensor type='perspective'><animation name='toWorld'><transform time='0'><lookat origin='1,2,3' target='0,0,0'/></transform>\
        </animation><film type='ldrfilm'/></sensor><shape type='sphere'><spectrum name='x' value='400:1,500:2'/></shape></scene>";
    assert!(load_bytes("room.xml", SCENE.as_bytes(), &[]).is_ok());
    let words: Vec<&str> = SCENE.split_inclusive(['<', '>', ' ', '\'']).collect();
    for start in 0..words.len() {
        for length in [1, 2, 5, 9] {
            let end = words.len().min(start + length);
            let without = [&words[..start], &words[end..]].concat().concat();
            let twice = [&words[..end], &words[start..]].concat().concat();
            for text in [without, twice] {
                // Either is fine; a panic is not.
                let _ = load_bytes("room.xml", text.as_bytes(), &[]);
            }
        }
    }
}
