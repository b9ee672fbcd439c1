//! Scenes as Mitsuba 3 shows them: small scenes with its own pictures (`tests/cases`), and the defaults of its plugins.
//!
//! `ref.npy` is Mitsuba 3.9.1, `scalar_rgb`, 1024 samples by the scene's own integrator.

use crate::rendered::{few_photons, rendered};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photonfarm::import::{load_bytes, load_file};
use photonfarm::method::METHODS;
use photonfarm::scene::Scene;
use photonfarm::scene::bundle::Bundle;

fn folder(case: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(case)
}

fn scene(case: &str) -> Arc<Scene> {
    let description = load_file(&folder(case).join("scene.xml"), &[]).expect("the case loads");
    Arc::new(Scene::prepare(&description).expect("the case is good"))
}

/// A picture of float32 numbers, H × W × 3.
fn reference(case: &str) -> Vec<[f64; 3]> {
    let bytes = std::fs::read(folder(case).join("ref.npy")).expect("the case has its picture");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let numbers: Vec<f64> = bytes[header..]
        .chunks_exact(4)
        .map(|number| f64::from(f32::from_le_bytes([number[0], number[1], number[2], number[3]])))
        .collect();
    numbers.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

fn render(scene: &Arc<Scene>, name: &str, passes: u32) -> Vec<[f64; 3]> {
    let picture = rendered(scene, name, few_photons(name), passes, 7);
    picture.radiance.iter().map(|pixel| pixel.map(f64::from)).collect()
}

fn mean(picture: &[[f64; 3]]) -> f64 {
    picture.iter().flatten().sum::<f64>() / (3 * picture.len()) as f64
}

/// Means of blocks of 16 × 16 pixels of a picture of 64 × 64.
fn blocks(picture: &[[f64; 3]]) -> Vec<f64> {
    let mut sums = vec![0.0; 16];
    for (index, pixel) in picture.iter().enumerate() {
        let (column, row) = (index % 64, index / 64);
        sums[row / 16 * 4 + column / 16] += pixel.iter().sum::<f64>() / (3.0 * 256.0);
    }
    sums
}

#[test]
fn mitsuba_pictures_agree() {
    for (case, passes) in [
        ("default-filter", 32),
        ("hide-emitters", 32),
        ("orthographic", 32),
        ("principal-point", 32),
        ("mask-rgb", 32),
        ("normal-map-matte", 32),
        ("bump-steep-mesh", 128),
        ("bump-steep-sphere", 128),
    ] {
        let (found, expected) = (render(&scene(case), "path", passes), reference(case));
        let bias = mean(&found) / mean(&expected) - 1.0;
        assert!(bias.abs() < 0.01, "{case}: the mean is {:+.2} % off", 100.0 * bias);
        let floor = 0.1 * mean(&expected);
        for (block, (one, other)) in blocks(&found).into_iter().zip(blocks(&expected)).enumerate() {
            let off = (one - other) / other.max(floor);
            assert!(off.abs() < 0.05, "{case}: block {block} is {:+.1} % off", 100.0 * off);
        }
    }
}

#[test]
fn mitsuba_cameras_and_hidden_lights_are_the_same_in_every_method() {
    for case in ["hide-emitters", "orthographic", "principal-point"] {
        let scene = Arc::new(scene(case).with_pixels(1024));
        let expected = mean(&reference(case));
        for method in METHODS {
            let bias = mean(&render(&scene, method.name, 16)) / expected - 1.0;
            let bound = if method.name == "light_tracing" { 0.05 } else { 0.03 };
            assert!(bias.abs() < bound, "{case}: {} is {:+.2} % off", method.name, 100.0 * bias);
        }
    }
}

/// In a matte sphere that emits 1 and reflects half, a camera sees 2 everywhere; the filter reaches over the seam of the picture.
#[test]
fn analytic_spherical_cameras_see_all_around_in_every_method() {
    for border in [false, true] {
        let text = format!(
            "<scene version='3.0.0'><sensor type='spherical'><transform name='to_world'><translate x='0.3' y='0.2'/></transform>\
             <film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='8'/><rfilter type='tent'/>\
             <boolean name='sample_border' value='{border}'/></film></sensor>\
             <shape type='sphere'><boolean name='flip_normals' value='true'/><bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf>\
             <emitter type='area'><rgb name='radiance' value='1'/></emitter></shape></scene>"
        );
        let description = load_bytes("sphere.xml", text.as_bytes(), &[]).expect("the scene loads");
        let scene = Arc::new(Scene::prepare(&description).expect("a good scene"));
        for method in METHODS {
            let picture = render(&scene, method.name, 64);
            let edges: Vec<[f64; 3]> = picture.chunks(16).flat_map(|row| [row[0], row[15]]).collect();
            for (part, found, bound) in [("picture", mean(&picture), 0.02), ("edges", mean(&edges), 0.04)] {
                assert!((found / 2.0 - 1.0).abs() < bound, "{}, border {border}: the {part} is {found}", method.name);
            }
        }
    }
}

/// Mitsuba 3.9.1 gives 1 1 0 0 in the upper rows of this mask, although `color0` lies at the corner (0, 0): its checkerboards swap what they are
/// asked for as numbers.
#[test]
fn mitsuba_checkerboards_swap_their_numbers() {
    for (swaps, upper) in
        [("", [1.0, 1.0, 0.0, 0.0]), ("<boolean name='swaps_numbers' value='false'/>", [0.0, 0.0, 1.0, 1.0])]
    {
        let text = format!(
            "<scene version='3.0.0'><sensor type='orthographic'>
                <transform name='to_world'><lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform>
                <film type='hdrfilm'><integer name='width' value='4'/><integer name='height' value='4'/><rfilter type='box'/></film>
            </sensor><emitter type='constant'/>
            <shape type='rectangle'><bsdf type='mask'>
                <texture name='opacity' type='checkerboard'><float name='color0' value='0'/><float name='color1' value='1'/>{swaps}</texture>
                <bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>
            </bsdf></shape></scene>"
        );
        let description = load_bytes("mask.xml", text.as_bytes(), &[]).expect("the scene loads");
        let picture = render(&Arc::new(Scene::prepare(&description).expect("a good scene")), "path", 2);
        let found: Vec<f64> = picture.iter().map(|pixel| pixel[0]).collect();
        let lower = upper.map(|value| 1.0 - value);
        assert_eq!(found, [upper, upper, lower, lower].concat(), "{swaps}");
    }
}

/// The frame of a normal map is right-handed where texture coordinates are mirrored, too: Mitsuba 3.9.1 gives the same for both
/// meshes. A constant normal may be a texture or a color.
#[test]
fn mitsuba_normal_maps_are_right_handed() {
    let mesh = |v: [u32; 2]| {
        let [first, last] = v;
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
            property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n-1 -1 0 0 {first}\n\
            1 -1 0 1 {first}\n1 1 0 1 {last}\n-1 1 0 0 {last}\n3 0 1 2\n3 0 2 3\n"
        )
    };
    let texture = "<texture name='normalmap' type='rawconstant'><vector name='value' value='0.6, 0.8, 0.9'/></texture>";
    for normal in [texture, "<rgb name='normalmap' value='0.6, 0.8, 0.9'/>"] {
        for v in [[0, 1], [1, 0]] {
            let text = format!(
                "<scene version='3.0.0'><sensor type='orthographic'>
                    <transform name='to_world'><lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform>
                    <film type='hdrfilm'><integer name='width' value='4'/><integer name='height' value='4'/><rfilter type='box'/></film>
                </sensor><emitter type='directional'><vector name='direction' value='0, -1, -1'/><rgb name='irradiance' value='3'/></emitter>
                <shape type='ply'><string name='filename' value='mesh.ply'/><bsdf type='normalmap'>{normal}
                    <boolean name='use_shadowing_function' value='false'/><bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf>
                </bsdf></shape></scene>"
            );
            let mut description = load_bytes("map.xml", text.as_bytes(), &[]).expect("the scene loads");
            let files = [("mesh.ply".to_owned(), Arc::from(mesh(v).as_bytes()))];
            description.bundle = Bundle::Archive(Arc::new(files.into_iter().collect()));
            let scene = Arc::new(Scene::prepare(&description).expect("a good scene"));
            let picture = render(&scene, "path", 1);
            // ρ/π times the irradiance times the cosine of (0.2, 0.6, 0.8) with (0, 1, 1).
            let expected = 0.5 / std::f64::consts::PI * 3.0 * 1.4 / (1.04_f64 * 2.0).sqrt();
            for pixel in picture {
                assert!((pixel[1] / expected - 1.0).abs() < 1e-4, "{normal}, v {v:?}: {} for {expected}", pixel[1]);
            }
        }
    }
}

#[test]
fn mitsuba_shows_a_sky_without_shapes() {
    let scene = scene("sky-without-shapes");
    for method in METHODS {
        let picture = render(&scene, method.name, 2);
        let expected = [0.7_f32, 0.5, 0.3].map(f64::from);
        assert!(picture.iter().all(|pixel| *pixel == expected), "{}: {:?}", method.name, picture[0]);
    }
}

/// Plugins of Mitsuba 3.9.1 with what its own objects print where nothing is given: place, plugin, what it must hold, defaults.
const DEFAULTS: &[(&str, &str, &str, &str)] = &[
    ("bsdf", "diffuse", "", "<rgb name='reflectance' value='0.5'/>"),
    ("bsdf", "dielectric", "", "<float name='int_ior' value='1.5046'/><float name='ext_ior' value='1.000277'/>"),
    ("bsdf", "thindielectric", "", "<float name='int_ior' value='1.5046'/><float name='ext_ior' value='1.000277'/>"),
    (
        "bsdf",
        "roughdielectric",
        "",
        "<float name='alpha' value='0.1'/><string name='distribution' value='beckmann'/>\
         <float name='int_ior' value='1.5046'/><float name='ext_ior' value='1.000277'/>",
    ),
    ("bsdf", "conductor", "", "<string name='material' value='none'/>"),
    (
        "bsdf",
        "roughconductor",
        "",
        "<string name='material' value='none'/><float name='alpha' value='0.1'/>\
         <string name='distribution' value='beckmann'/><rgb name='specular_reflectance' value='1'/>",
    ),
    (
        "bsdf",
        "plastic",
        "",
        "<float name='int_ior' value='1.49'/><float name='ext_ior' value='1.000277'/><boolean name='nonlinear' value='false'/>\
         <rgb name='diffuse_reflectance' value='0.5'/><rgb name='specular_reflectance' value='1'/>",
    ),
    (
        "bsdf",
        "roughplastic",
        "",
        "<float name='int_ior' value='1.49'/><float name='ext_ior' value='1.000277'/><boolean name='nonlinear' value='false'/>\
         <rgb name='diffuse_reflectance' value='0.5'/><float name='alpha' value='0.1'/><string name='distribution' value='beckmann'/>",
    ),
    (
        "bsdf",
        "principled",
        "",
        "<rgb name='base_color' value='0.5'/><float name='roughness' value='0.5'/><float name='specular' value='0.5'/>\
         <float name='metallic' value='0'/><float name='spec_trans' value='0'/><float name='clearcoat' value='0'/>\
         <float name='clearcoat_gloss' value='0'/><float name='sheen' value='0'/><float name='sheen_tint' value='0'/>\
         <float name='spec_tint' value='0'/><float name='flatness' value='0'/><float name='anisotropic' value='0'/>",
    ),
    ("bsdf", "mask", "<bsdf type='diffuse'/>", "<float name='opacity' value='0.5'/>"),
    (
        "bsdf",
        "bumpmap",
        "<bsdf type='diffuse'/><texture type='checkerboard'/>",
        "<float name='scale' value='1'/><boolean name='flip_invalid_normals' value='true'/>\
         <boolean name='use_shadowing_function' value='true'/>",
    ),
    (
        "bsdf",
        "normalmap",
        "<bsdf type='diffuse'/><texture name='normalmap' type='checkerboard'/>",
        "<boolean name='flip_invalid_normals' value='true'/><boolean name='use_shadowing_function' value='true'/>",
    ),
    ("emitter", "point", "", "<point name='position' x='0'/><rgb name='intensity' value='1'/>"),
    (
        "emitter",
        "spot",
        "",
        "<rgb name='intensity' value='1'/><float name='cutoff_angle' value='20'/><float name='beam_width' value='15'/>",
    ),
    ("emitter", "constant", "", "<rgb name='radiance' value='1'/>"),
    ("emitter", "directional", "", "<rgb name='irradiance' value='1'/><vector name='direction' x='0' y='0' z='1'/>"),
    (
        "emitter",
        "projector",
        "",
        "<rgb name='irradiance' value='1'/><float name='scale' value='1'/><string name='focal_length' value='50mm'/>",
    ),
    ("shape", "sphere", "", "<point name='center' x='0'/><float name='radius' value='1'/>"),
    (
        "shape",
        "cylinder",
        "",
        "<point name='p0' x='0'/><point name='p1' z='1'/><float name='radius' value='1'/><boolean name='flip_normals' value='false'/>",
    ),
    ("shape", "disk", "", "<boolean name='flip_normals' value='false'/>"),
    ("shape", "rectangle", "", "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>"),
    ("shape", "sphere", "<emitter type='area'/>", "<emitter type='area'><rgb name='radiance' value='1'/></emitter>"),
    (
        "sensor",
        "perspective",
        "",
        "<string name='focal_length' value='50mm'/><float name='near_clip' value='0.01'/><float name='far_clip' value='10000'/>\
         <float name='principal_point_offset_x' value='0'/><float name='principal_point_offset_y' value='0'/>",
    ),
    (
        "sensor",
        "thinlens",
        "<float name='aperture_radius' value='0.1'/>",
        "<string name='focal_length' value='50mm'/><float name='focus_distance' value='10000'/>",
    ),
    ("sensor", "orthographic", "", "<float name='near_clip' value='0.01'/><float name='far_clip' value='10000'/>"),
    (
        "film",
        "hdrfilm",
        "",
        "<integer name='width' value='768'/><integer name='height' value='576'/>\
         <rfilter type='gaussian'><float name='stddev' value='0.5'/></rfilter>",
    ),
    ("rfilter", "tent", "", "<float name='radius' value='1'/>"),
    ("rfilter", "gaussian", "", "<float name='stddev' value='0.5'/>"),
    ("rfilter", "lanczos", "", "<integer name='lobes' value='3'/>"),
    (
        "rfilter",
        "mitchell",
        "",
        "<float name='B' value='0.3333333333333333'/><float name='C' value='0.3333333333333333'/>",
    ),
];

/// Everything of a scene with one plugin that its parameters decide.
fn outcome(place: &str, plugin: &str, inside: &str) -> String {
    let node = format!("<{place} type='{plugin}'>{inside}</{place}>");
    let (mut shape, mut light, mut sensor) =
        ("<shape type='rectangle'/>".to_owned(), "<emitter type='constant'/>".to_owned(), String::new());
    match place {
        "bsdf" => shape = format!("<shape type='rectangle'>{node}</shape>"),
        "shape" => shape = node,
        "emitter" => light = node,
        "sensor" => sensor = node,
        "film" => sensor = format!("<sensor type='perspective'>{node}</sensor>"),
        _ => sensor = format!("<sensor type='perspective'><film type='hdrfilm'>{node}</film></sensor>"),
    }
    if sensor.is_empty() {
        sensor = "<sensor type='perspective'/>".to_owned();
    }
    let text = format!("<scene version='3.0.0'>{sensor}{shape}{light}</scene>");
    let description = load_bytes("a.xml", text.as_bytes(), &[]).expect("the scene loads");
    let scene = Scene::prepare(&description).unwrap_or_else(|error| panic!("{text}: {error}"));
    let primitives: Vec<_> =
        (0..scene.geometry.primitive_count()).map(|index| scene.geometry.primitive(index as u32)).collect();
    format!("{:?} {:?} {:?} {:?} {primitives:?}", scene.materials, scene.lights.lights(), scene.camera, scene.film)
}

#[test]
fn mitsuba_defaults_are_ours() {
    for (place, plugin, needed, defaults) in DEFAULTS {
        // What is written out takes the place of what must be there.
        let written = match defaults.starts_with("<emitter") {
            true => (*defaults).to_owned(),
            false => format!("{needed}{defaults}"),
        };
        let (plain, written) = (outcome(place, plugin, needed), outcome(place, plugin, &written));
        assert_eq!(plain, written, "{place} \"{plugin}\"");
    }
    let board = "<texture name='reflectance' type='checkerboard'>";
    let explicit = format!("{board}<rgb name='color0' value='0.4'/><rgb name='color1' value='0.2'/></texture>");
    assert_eq!(outcome("bsdf", "diffuse", &format!("{board}</texture>")), outcome("bsdf", "diffuse", &explicit));
}

/// A scene with one emitter and one transform of a shape.
fn with(emitter: &str, rotation: &str) -> String {
    format!(
        "<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'><translate z='-5'/></transform></sensor>\
         <emitter type='constant'>{emitter}</emitter>\
         <shape type='cube'><transform name='to_world'>{rotation}</transform></shape></scene>"
    )
}

#[test]
fn mitsuba_rotations_about_long_axes_are_noticed() {
    for (rotation, told) in [
        ("<rotate x='1' y='2' angle='30'/>", true),
        ("<rotate value='0, 0.6, 0.8' angle='30'/>", false),
        ("<rotate z='1' angle='30'/>", false),
    ] {
        let description = load_bytes("a.xml", with("", rotation).as_bytes(), &[]).expect("the scene loads");
        let notices = description.notices.iter().filter(|notice| notice.subject.contains("an axis of length 2.236"));
        assert_eq!(notices.count(), usize::from(told), "{rotation}");
    }
}

#[test]
fn emitters_that_are_never_sampled_are_refused() {
    for (weight, good) in [(2.0, true), (0.0, false), (-1.0, false)] {
        let emitter = format!("<float name='sampling_weight' value='{weight}'/>");
        let description = load_bytes("a.xml", with(&emitter, "").as_bytes(), &[]).expect("the scene loads");
        let error = Scene::prepare(&description).err().map(|error| error.to_string()).unwrap_or_default();
        assert_eq!(error.is_empty(), good, "{error}");
        assert!(good || error.contains("give a number above 0, or remove the emitter"), "{error}");
    }
}
