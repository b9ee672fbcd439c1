//! Scenes in the Materials and Geometry Format come out as the surfaces, materials and lights that they mean.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;

use crate::chi_square::numbers;
use photonfarm::import::{load_bytes, load_file, pack};
use photonfarm::math::Vec3;
use photonfarm::scene::Scene;
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value};

fn load(text: &str) -> SceneDescription {
    load_bytes("scene.mgf", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn parameter<'a>(node: &'a Node, name: &str) -> &'a Value {
    &node.parameters.iter().find(|parameter| parameter.name == name).expect(name).value
}

fn of_class(scene: &SceneDescription, class: PluginClass) -> Vec<&Node> {
    scene.root.children.iter().map(|child| &*child.node).filter(|node| node.class == class).collect()
}

/// A plugin in one line: numbers rounded, without places.
fn outline(node: &Node) -> String {
    let rounded = |numbers: &[f64]| numbers.iter().map(|number| format!("{number:.4}")).collect::<Vec<_>>().join(" ");
    let value = |value: &Value| match value {
        Value::Float(number) => rounded(&[*number]),
        Value::Rgb(rgb) | Value::Vector(rgb) => rounded(rgb),
        Value::String(text) => text.clone(),
        other => format!("{other:?}"),
    };
    let parameters = node.parameters.iter().map(|parameter| format!("{}={}", parameter.name, value(&parameter.value)));
    let children = node.children.iter().map(|child| outline(&child.node));
    format!("{}({})", node.plugin, parameters.chain(children).collect::<Vec<_>>().join(", "))
}

/// Area and enclosed volume of all that emits in a scene of one radiance: a closed surface with its outside outwards has
/// the volume ⅓∮x·n dA, and photons that leave by the cosine law have the mean direction ⅔n.
fn area_and_volume(scene: &Scene, radiance: f64) -> (f64, f64) {
    const PHOTONS: u32 = 20_000;
    let area = scene.lights.lights().iter().map(|light| f64::from(light.power().x) / (PI * radiance)).sum::<f64>();
    let moment = |photon: u32| {
        let (u, v) = (numbers(1, photon), numbers(2, photon));
        let photon = scene.lights.emit(&scene.geometry, [u[0], u[1], u[2]], [v[0], v[1]]).expect("lights emit");
        f64::from(photon.origin.dot(photon.direction))
    };
    let mean = (0..PHOTONS).map(moment).sum::<f64>() / f64::from(PHOTONS);
    (area, 0.5 * area * mean)
}

const VERTICES: &str = "v o =\n p 0 0 0\n n 0 0 1\nv low =\n p 0 0 0\n n 0 0 -1\nv z =\n p 0 0 1\n n 0 0 1\n\
    v a =\n p 0 0 0\nv b =\n p 1 0 0\nv c =\n p 1 1 0\nv d =\n p 0 1 0\nv e =\n p .25 .25 0\nv g =\n p .75 .25 0\n\
    v h =\n p .75 .75 0\nv k =\n p .25 .75 0\nv notch =\n p .5 .25 0\nm lamp =\n sides 1\n ed 1790\n";

#[test]
fn mgf_solids_have_their_area_and_their_outside() {
    let slant = |r1: f64, r2: f64, h: f64| PI * (r1 + r2) * ((r1 - r2).powi(2) + h * h).sqrt();
    let cases = [
        ("sph o 0.5", PI, Some(PI / 6.0)),
        ("sph o -0.5", PI, Some(-PI / 6.0)),
        ("xf -s 2 -t 3 4 5\nsph o .5\nxf", 4.0 * PI, Some(4.0 * PI / 3.0)),
        ("xf -s 2 -mx\nsph o .5\nxf", 4.0 * PI, Some(4.0 * PI / 3.0)),
        ("cyl o .5 z", PI, None),
        ("cyl o .5 z\nring low 0 .5\nring z 0 .5", 1.5 * PI, Some(PI / 4.0)),
        ("cone o 1 z .5", slant(1.0, 0.5, 1.0), None),
        ("cone o 1 z 0\nring low 0 1", slant(1.0, 0.0, 1.0) + PI, Some(PI / 3.0)),
        ("cone z 0 o 1\nring low 0 1", slant(1.0, 0.0, 1.0) + PI, Some(PI / 3.0)),
        ("xf -rx 30 -mz\ncone o 1 z 0\nring low 0 1\nxf", slant(1.0, 0.0, 1.0) + PI, Some(PI / 3.0)),
        ("cone o -1 z -.5", slant(1.0, 0.5, 1.0), None),
        ("ring o .5 1", 0.75 * PI, None),
        ("torus o .5 1.5", 2.0 * PI * PI, Some(0.5 * PI * PI)),
        ("torus o -.5 -1.5", 2.0 * PI * PI, Some(-0.5 * PI * PI)),
        ("xf -my\ntorus o .5 1.5\nxf", 2.0 * PI * PI, Some(0.5 * PI * PI)),
        ("prism a b c d 2", 10.0, Some(2.0)),
        ("prism a b c d -2", 10.0, Some(-2.0)),
        ("xf -mx -s 2\nprism a b c d 2\nxf", 40.0, Some(16.0)),
        ("prism a b notch c d 1", 1.5 + 3.0 + f64::sqrt(0.3125) + f64::sqrt(0.8125), Some(0.75)),
        ("f a b c d", 1.0, None),
        ("f a b notch d", 0.375, None),
        ("fh a b c d - e g h k", 0.75, None),
        ("fh a b c d - k h g e", 0.75, None),
        ("f a b c d e k h g e d", 0.75, None),
        ("xf -a 3 -t 2 0 0 -a 4 -t 0 2 0 -i 1 -t 9 9 9\nf a b c d\nxf", 12.0, None),
        ("xf -a 3 -t 2 0 0\nxf -a 2 -rz 45\nf a b c d\nxf\nxf", 6.0, None),
    ];
    for (entities, area, volume) in cases {
        let text = format!("{VERTICES}{entities}\n");
        let scene = Scene::prepare(&load(&text)).unwrap_or_else(|error| panic!("{entities}: {error}"));
        let (own_area, own_volume) = area_and_volume(&scene, 10.0 / PI);
        assert!((own_area / area - 1.0).abs() < 4e-3, "{entities}: {own_area} m² is not {area} m²");
        if let Some(volume) = volume {
            assert!((own_volume / volume - 1.0).abs() < 0.1, "{entities}: {own_volume} m³ is not {volume} m³");
        }
    }
}

#[test]
fn mgf_transforms_apply_where_geometry_is_made() {
    // The example of the specification: the ring's center is (5, -10, 0), and it faces downwards.
    let text = "m\n rd .5\nxf -t 5 0 0\nv v1 =\n p 0 10 0\n n 0 0 1\nxf -rx 180\nring v1 0 2\nxf\nxf\n";
    let scene = load(text);
    let [disk] = of_class(&scene, PluginClass::Shape)[..] else { panic!("one shape is expected") };
    let Value::Transform(matrix) = parameter(disk, "to_world") else { panic!("a transform is expected") };
    assert!(matrix.w_axis.truncate().distance(glam::DVec3::new(5.0, -10.0, 0.0)) < 1e-9);
    assert!(matrix.z_axis.truncate().normalize().distance(glam::DVec3::NEG_Z) < 1e-9);
    // 60 spheres in an array, moved as a whole.
    let text =
        "m\n rd .5\nv v0 =\n p 0 0 0\nxf -a 3 -t 1 0 0 -a 4 -t 0 1 0 -a 5 -t 0 0 1 -i 1 -t 15 30 45\nsph v0 0.1\nxf\n";
    let scene = load(text);
    let centers: Vec<[f64; 3]> = of_class(&scene, PluginClass::Shape)
        .iter()
        .map(|sphere| match parameter(sphere, "center") {
            Value::Vector(center) => *center,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(centers.len(), 60);
    assert_eq!((centers[0], centers[1], centers[59]), ([15.0, 30.0, 45.0], [15.0, 30.0, 46.0], [17.0, 33.0, 49.0]));
    // -i repeats.
    let scene = load("m\n rd .5\nv v0 =\n p 1 0 0\nxf -i 3 -s 2 -t 1 0 0\nsph v0 1\nxf\n");
    let [sphere] = of_class(&scene, PluginClass::Shape)[..] else { panic!("one shape is expected") };
    assert_eq!(*parameter(sphere, "center"), Value::Vector([15.0, 0.0, 0.0]));
    assert_eq!(*parameter(sphere, "radius"), Value::Float(8.0));
}

#[test]
fn mgf_contexts_keep_what_was_written_into_them() {
    let text = "c red =\n cxy .64 .33\nm wall =\n c red\n rd .2\nm pale = wall\n rd .4\nv at =\n p 0 0 0\n\
        m wall\nsph at 1\nm pale\nsph at 2\nm wall\n c\n rd .5\nsph at 3\nm\nsph at 4\n";
    let scene = load(text);
    let report: Vec<String> = of_class(&scene, PluginClass::Bsdf).iter().map(|node| outline(node)).collect();
    insta::assert_snapshot!(report.join("\n"));
}

#[test]
fn mgf_materials_find_the_nearest_bsdf() {
    let materials = [
        ("black", ""),
        ("matte", "rd .5"),
        ("matte, one-sided", "sides 1\n rd .5"),
        ("mirror", "rs .9 0"),
        ("rough metal", "rs .75 .08"),
        ("rough metal over paint", "rs .3 .08\n rd .09"),
        ("gloss over paint", "rs .1 0\n rd .3"),
        ("lacquer", "ir 1.5 0\n rs .04 0\n rd .3"),
        ("rough lacquer", "ir 1.5 0\n rs .04 .1\n rd .3"),
        ("aluminum", "ir .770058 6.08351\n rs .75 0"),
        ("rough aluminum", "ir .770058 6.08351\n rs .75 .2"),
        ("pane", "ir 1.52 0\n rs .0725 0\n c\n cxy .23 .38\n ts .5815 0"),
        ("crystal ball", "sides 1\n ir 1.65 0\n rs .0602 0\n c\n cxy .3127 .2881\n ts .6425 0"),
        ("frosted ball", "sides 1\n ir 1.5 0\n rs .04 .1\n ts .9 .1"),
        ("frosted pane", "ir 1.5 0\n rs .06 .1\n ts .9 .1"),
        ("lamp shade", "rd .5\n td .4"),
        ("colored film", "c\n cxy .5 .4\n ts .6 0"),
        ("too bright", "rd .8\n rs .4 0"),
        ("violet that cannot be so bright", "c\n cxy .2 .1\n rd .8"),
        ("spectral green", "c\n cspec 500 540 0 1 0\n rd .1"),
        ("incandescent", "c\n cct 3000\n ed 1790"),
        ("fluorescent, one-sided", "sides 1\n c\n cxy .373 .385\n ed 44700\n rd .6"),
        (
            "mixed",
            "c r =\n cxy .64 .33\n c g =\n cxy .29 .6\n c b =\n cxy .15 .06\n c\n cmix .265 r .67 g .065 b\n rd .5",
        ),
    ];
    let mut report = String::new();
    for (what, entities) in materials {
        let scene = load(&format!("v at =\n p 0 0 0\nm x =\n c\n {entities}\nsph at 1\n"));
        let [bsdf] = of_class(&scene, PluginClass::Bsdf)[..] else { panic!("one bsdf is expected") };
        writeln!(report, "{what}\n    {}", outline(bsdf)).unwrap();
        let [sphere] = of_class(&scene, PluginClass::Shape)[..] else { panic!("one shape is expected") };
        let light = sphere.children.iter().find(|child| child.node.class == PluginClass::Emitter);
        light.into_iter().for_each(|light| writeln!(report, "    {}", outline(&light.node)).unwrap());
        let notices = scene.notices.iter().filter(|notice| !notice.subject.contains("the view"));
        notices.for_each(|notice| writeln!(report, "    {notice}").unwrap());
    }
    insta::assert_snapshot!(report);
}

const LAMP: &str = "TILT=NONE\n1 1 1 2 1 1 2 0 0 0\n1 1 1\n0 90\n0\n1790 1790\n";

#[test]
fn mgf_files_include_others_and_travel_with_them() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("lib")).expect("a folder");
    let files = [
        ("room.mgf", "# a room\ni lib/part.mgf -t 0 0 5 -a 2 -t 10 0 0\n"),
        (
            "lib/part.mgf",
            "i ../paint.mgf\nv at =\n p 0 0 0\no ball\nm paint\nsph at 1\no\nies lamp.ies -m 2 -t 0 0 2\n",
        ),
        ("paint.mgf", "m paint =\n rd .5\n"),
        ("lib/lamp.ies", LAMP),
    ];
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("writes");
    }
    let path = folder.path().join("room.mgf");
    let scene = load_file(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(of_class(&scene, PluginClass::Shape).len(), 2);
    let lamps = of_class(&scene, PluginClass::Emitter);
    let [first, second] = lamps[..] else { panic!("two lamps are expected") };
    assert_eq!(*parameter(first, "filename"), Value::String("lib/lamp.ies".to_owned()));
    assert_eq!(*parameter(first, "intensity"), Value::Rgb([2.0; 3]));
    let Value::Transform(matrix) = parameter(second, "to_world") else { panic!("a transform is expected") };
    assert_eq!(matrix.w_axis.truncate().to_array(), [10.0, 0.0, 7.0]);

    let bytes = pack(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(bytes.starts_with(b"PK"));
    let packed = load_bytes("scene", &bytes, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(outline(&packed.root), outline(&scene.root));
    // The lamp hangs over the ball and shines down on it, with 2 · 1790/179 W·sr⁻¹.
    let scene = Scene::prepare(&packed).unwrap_or_else(|error| panic!("{error}"));
    let found = scene.lights.sample_direct(&scene.geometry, &Vec3::new(0.0, 0.0, 6.0).into(), [0.5, 0.5, 0.0]);
    let found = found.expect("the lamp shines downwards");
    // It is picked a hundred times as often as the equal lamp that is ten times as far.
    assert!((found.weighted_radiance.x - 20.0 * 102.0 / 101.0).abs() < 1e-3, "{found:?}");
    assert!(scene.lights.sample_direct(&scene.geometry, &Vec3::new(0.0, 0.0, 8.0).into(), [0.5, 0.5, 0.0]).is_none());
}

#[test]
fn mgf_is_told_from_other_formats() {
    let text = "# comment\n\nv at =\n\tp 0 \\\n  0 0\r\nm lamp =\n ed 179\nsph at 1\nnewthing 1 2\nnewthing 3\n";
    let scene = load_bytes("scene", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let notices: Vec<String> = scene.notices.iter().map(ToString::to_string).collect();
    assert!(
        notices.iter().any(|notice| notice.contains("scene:9 (newthing): entity \"newthing\" (2 times) is ignored"))
    );
    assert!(notices.iter().any(|notice| notice.contains("MGF has no camera")), "{notices:?}");
    // A file alone is packed as it is.
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.MGF"), text).expect("writes");
    assert_eq!(pack(&folder.path().join("a.MGF"), &[]).expect("packs"), text.as_bytes());
    for other in ["v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "# nothing\n", "hello\n"] {
        let error = load_bytes("scene", other.as_bytes(), &[]).expect_err(other).to_string();
        assert!(error.contains("none of the formats that are read"), "{error}");
    }
    // The default camera sees the ball in the middle of the picture.
    let scene = Scene::prepare(&scene).unwrap_or_else(|error| panic!("{error}"));
    let ray = scene.camera.ray(photonfarm::math::Vec2::splat(0.5), [0.5; 2]);
    assert!(scene.geometry.intersect(&ray).is_some());
}

#[test]
fn mgf_that_cannot_be() {
    let cases = [
        ("p with two numbers", "v a =\n p 1 2"),
        ("p that is not a number", "v a =\n p 1 2 nan"),
        ("infinite p", "v a =\n p 1 2 1e999"),
        ("p too large for single precision", "v a =\n p 1e39 0 0\nsph a 1"),
        ("unknown vertex", "v corner1 =\nsph corner2 1"),
        ("unknown material", "m red"),
        ("unknown template", "m red = blue"),
        ("name that is none", "v 1 ="),
        ("no equals sign", "v a b"),
        ("sides 3", "m x =\n sides 3"),
        ("reflectance above 1", "m x =\n rd 1.5"),
        ("negative reflectance", "m x =\n rd -.5"),
        ("rs without roughness", "m x =\n rs .5"),
        ("index 0", "m x =\n ir 0 0"),
        ("black chromaticity", "c x =\n cxy 0 0\nm y =\n c x\n rd .5"),
        ("spectrum of nothing", "c x =\n cspec 400 700 0 0 0\nm y =\n c x\n rd .5"),
        ("spectrum backwards", "c x =\n cspec 700 400 1 1"),
        ("0 kelvin", "c x =\n cct 0"),
        ("mixture of an unknown color", "c x =\n cmix 1 y"),
        ("weight without color", "c x =\n c y =\n cmix 1 x 2"),
        ("face of two corners", "v a =\nf a a"),
        ("hole of two corners", "v a =\nfh a a a - a a"),
        ("sphere of radius 0", "v a =\nsph a 0"),
        ("cylinder without height", "v a =\ncyl a 1 a"),
        ("cone of two signs", "v a =\nv b =\n p 0 0 1\ncone a 1 b -1"),
        ("ring without a normal", "v a =\nring a 0 1"),
        ("ring inside out", "v a =\n n 0 0 1\nring a 2 1"),
        ("torus inside out", "v a =\n n 0 0 1\ntorus a 2 1"),
        ("prism without length", "v a =\nv b =\n p 1 0 0\nv c =\n p 0 1 0\nprism a b c 0"),
        ("prism without area", "v a =\nprism a a a 1"),
        ("end of no transform", "xf"),
        ("transform without end", "xf -t 1 2 3\nv a ="),
        ("unknown transform", "xf -q 1\nxf"),
        ("scale 0", "xf -s 0\nxf"),
        ("translation cut off", "xf -t 1 2\nxf"),
        ("no copies", "xf -a 0 -t 1 0 0\nxf"),
        ("half a copy", "xf -a 1.5 -t 1 0 0\nxf"),
        ("a cube of copies", "v a =\nxf -a 1000 -t 1 0 0 -a 1000 -t 0 1 0 -a 1000 -t 0 0 1\nsph a .1\nxf"),
        ("nested copies", "v a =\nxf -a 3000 -t 1 0 0\nxf -a 3000 -t 0 1 0\nsph a .1\nxf\nxf"),
        ("copies of nothing", "xf -a 9999 -t 1 0 0\nxf -a 9999 -t 0 1 0\nxf\nxf"),
        ("copies of tori", "m x =\n ed 1\nv a =\n n 0 0 1\nxf -a 9999 -t 1 0 0\ntorus a 1 2\nxf"),
        ("exploding repetition", "v a =\nxf -i 4000000000 -s 2\nsph a 1\nxf"),
        ("end of no object", "o"),
        ("include of a missing file", "i missing.mgf"),
        ("include above", "i ../secret.mgf"),
        ("absolute include", "i /etc/passwd"),
        ("include of itself", "i scene.mgf"),
        ("luminaire above", "ies ../lamp.ies\nv a =\nsph a 1"),
        ("negative luminaire", "ies lamp.ies -m -1"),
    ];
    let mut report = String::new();
    for (what, text) in cases {
        let result = load_bytes("scene.mgf", text.as_bytes(), &[]).and_then(|scene| Scene::prepare(&scene));
        match result {
            Ok(_) => panic!("{what} is no error"),
            Err(error) => writeln!(report, "{what}\n    {error}").unwrap(),
        }
    }
    let define = [("size".to_owned(), "1".to_owned())];
    let error = load_bytes("scene.mgf", b"m x =\n", &define).expect_err("MGF has no parameters");
    writeln!(report, "define\n    {error}").unwrap();
    insta::assert_snapshot!(report);
}

#[test]
fn mgf_files_that_include_each_other_are_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.mgf"), "m x =\ni b.mgf\n").expect("writes");
    fs::write(folder.path().join("b.mgf"), "\ni ./a.mgf\n").expect("writes");
    let error = load_file(&folder.path().join("a.mgf"), &[]).expect_err("a circle").to_string();
    assert_eq!(error, "b.mgf:2 (i): file \"a.mgf\" includes itself; remove one of the includes");
}

/// Concave polygons of many corners end in an error, not in a wait without end.
#[test]
fn mgf_costly_polygons_are_refused() {
    let mut text = String::new();
    let mut face = "f".to_owned();
    for corner in 0..3000 {
        // A spiral, whose ears lie at its ends.
        let angle = 0.05 * f64::from(corner);
        let radius = 1.0 + 0.01 * angle + if corner % 2 == 0 { 0.001 } else { 0.0 };
        writeln!(text, "v s{corner} =\n p {} {} 0", radius * angle.cos(), radius * angle.sin()).unwrap();
        write!(face, " s{corner}").unwrap();
    }
    writeln!(text, "m x =\n ed 5\nxf -a 1000 -t 0 0 1\n{face}\nxf").unwrap();
    let error = load_bytes("scene.mgf", text.as_bytes(), &[]).expect_err("it is too much").to_string();
    assert!(error.starts_with("scene.mgf:") && error.contains("; "), "{error}");
}

/// No cut and no changed byte of a scene makes importing it panic.
#[test]
fn mgf_mutations_are_read_or_refused() {
    let scene = format!(
        "{VERTICES}c red =\n cspec 400 700 1 2 3\nm red =\n c red\n rd .5\n rs .1 .1\n ts .2 0\n ir 1.5 0\n\
         xf -a 2 -t 1 0 0 -rz 30\no x\nsph o .5\ncyl o .5 z\ncone o 1 z .5\nring o .5 1\ntorus o .5 1\nprism a b c d 2\n\
         f a b notch d\nfh a b c d - e g h k\no\nxf\nies lamp.ies -m 2 -t 0 0 1\ni other.mgf -s 2\n"
    );
    let try_load = |bytes: &[u8]| drop(load_bytes("scene.mgf", bytes, &[]));
    for length in (0..scene.len()).step_by(3) {
        try_load(&scene.as_bytes()[..length]);
    }
    for index in 0..2000 {
        let u = numbers(3, index);
        let mut bytes = scene.clone().into_bytes();
        let at = (u[0] * bytes.len() as f32) as usize;
        bytes[at] = b"0123456789.-ecvfmxp \n\\#=\xff\0"[(u[1] * 26.0) as usize];
        // Lines that move and lines that are gone.
        if u[2] < 0.3 {
            let mut lines: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            let other = (u[3] * lines.len() as f32) as usize;
            lines.swap(at % scene.lines().count(), other);
            bytes = lines.join(&b'\n');
        }
        try_load(&bytes);
    }
}
