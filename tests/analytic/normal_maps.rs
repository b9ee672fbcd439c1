//! Normal maps and bump maps against closed forms, and what cannot have one.

use crate::scene_files::{exr_file, prepare};
use photonfarm::math::Vec3;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::material::{TransportMode, View};
use photonfarm::scene::{Scene, SceneError};

/// A rectangle of 2 m × 2 m, with the outside towards +z.
fn rectangle(bsdf: &str, file: &[u8]) -> Result<Scene, SceneError> {
    let body = format!(
        "<sensor type='perspective'><transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/>\
        </transform></sensor><emitter type='point'/><shape type='rectangle'>{bsdf}</shape>"
    );
    prepare(&body, &[("a.exr", file)])
}

const TEXTURE: &str = "<texture type='bitmap' name='normalmap'><string name='filename' value='a.exr'/>\
    <string name='wrap_mode' value='clamp'/></texture>";
const DIFFUSE: &str = "<bsdf type='diffuse'/>";

fn turning(kind: &str, inside: &str) -> String {
    format!("<bsdf type='{kind}'>{TEXTURE}{inside}</bsdf>")
}

/// The shading normal at a point of the rectangle; the frame round it must be one.
fn normal(scene: &Scene, x: f32, y: f32) -> Vec3 {
    let hit = scene.intersect(&Ray::new(Vec3::new(x, y, 2.0), -Vec3::Z)).expect("the ray hits");
    let frame = hit.frame;
    let view = View::at(&hit, TransportMode::Radiance);
    let axes = [frame.tangent, frame.bitangent, frame.normal];
    for (index, axis) in axes.iter().enumerate() {
        assert!((axis.length() - 1.0).abs() < 1e-5 && axis.dot(axes[(index + 1) % 3]).abs() < 1e-5);
    }
    assert!(frame.tangent.x > 0.0 && frame.bitangent.y > 0.0, "the frame follows u");
    assert_eq!([hit.geometric_normal, frame.normal], [Vec3::Z; 2], "the surface stays");
    frame.to_world(scene.material(hit.shape).turned_normal(&view))
}

#[test]
fn analytic_normal_maps_hold_normals() {
    for expected in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.36, 0.48, 0.8)] {
        let color = (expected * 0.5 + 0.5).to_array();
        let file = exr_file(2, 2, |_, _| color);
        for bsdf in
            [turning("normalmap", DIFFUSE), format!("<bsdf type='twosided'>{}</bsdf>", turning("normalmap", DIFFUSE))]
        {
            let scene = rectangle(&bsdf, &file).expect("the scene is good");
            let found = normal(&scene, 0.3, -0.2);
            assert!(found.distance(expected) < 1e-5, "{bsdf}: {found} is not {expected}");
        }
    }
}

#[test]
fn analytic_bump_maps_are_slopes() {
    // 0.3 m over the whole width, -0.1 m over the whole height; texture coordinates run over 2 m.
    let (width, height) = (16, 8);
    let file = exr_file(width, height, |x, y| {
        [0.3 * (x as f32 + 0.5) / width as f32 + 0.1 - 0.1 * (y as f32 + 0.5) / height as f32; 3]
    });
    for (scale, expected) in [(1.0, Vec3::new(-0.15, 0.05, 1.0)), (-4.0, Vec3::new(0.6, -0.2, 1.0))] {
        let inside = format!("<float name='scale' value='{scale}'/>{DIFFUSE}");
        let scene = rectangle(&turning("bumpmap", &inside), &file).expect("the scene is good");
        let found = normal(&scene, 0.3, -0.2);
        assert!(found.distance(expected.normalize()) < 1e-4, "{found} is not {}", expected.normalize());
    }
}

#[test]
fn analytic_bump_maps_follow_the_transform_of_their_texture() {
    let file = exr_file(16, 2, |x, _| [(x as f32 + 0.5) / 16.0; 3]);
    // Half the slope, and along v.
    let turned = TEXTURE.replace(
        "</texture>",
        "<transform name='to_uv'><matrix value='0 0.5 0 0  1 0 0 0  0 0 1 0  0 0 0 1'/></transform></texture>",
    );
    let bsdf = format!("<bsdf type='bumpmap'>{turned}{DIFFUSE}</bsdf>");
    let found = normal(&rectangle(&bsdf, &file).expect("the scene is good"), 0.1, 0.2);
    assert!(found.distance(Vec3::new(0.0, -0.25, 1.0).normalize()) < 1e-4, "{found}");
}

#[test]
fn analytic_normal_maps_that_cannot_be() {
    let file = exr_file(2, 2, |_, _| [0.5, 0.5, 1.0]);
    for (bsdf, part) in [
        (turning("normalmap", ""), "\"normalmap\" holds no bsdf"),
        (format!("<bsdf type='bumpmap'>{DIFFUSE}</bsdf>"), "\"bumpmap\" holds no texture"),
        (format!("<bsdf type='normalmap'>{DIFFUSE}</bsdf>"), "has no texture \"normalmap\""),
        (turning("normalmap", &format!("{DIFFUSE}{DIFFUSE}")), "cannot hold another bsdf"),
        (turning("bumpmap", &format!("{DIFFUSE}<float name='scall' value='1'/>")), "did you mean \"scale\"?"),
    ] {
        let message = rectangle(&bsdf, &file).err().unwrap_or_else(|| panic!("{bsdf} is no error")).to_string();
        assert!(message.contains(part) && message.contains("test.xml"), "{bsdf}: {message}");
    }
}

/// The value of a matte surface of reflectance 1 whose normal is (0.6, 0, 0.8), as `mi.BSDF.eval` of Mitsuba 3.9.1 gives it with the
/// cosine of light: without corrections, and with the two that are on by default.
#[test]
fn analytic_normal_maps_flip_and_dim_as_mitsuba() {
    let file = exr_file(2, 2, |_, _| [0.8, 0.5, 0.9]);
    let material = |flags: bool| {
        let off = "<boolean name='flip_invalid_normals' value='false'/><boolean name='use_shadowing_function' value='false'/>";
        let white = "<bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf>";
        let inside = format!("{}{white}", if flags { "" } else { off });
        rectangle(&turning("normalmap", &inside), &file).expect("the scene is good")
    };
    let normal = Vec3::new(0.6, 0.0, 0.8);
    let shadow = |light: Vec3| {
        let tangent_squared = |z: f32| 1.0 / (z * z) - 1.0;
        2.0 / (1.0 + (1.0 + 0.125 * tangent_squared(0.8) * tangent_squared(light.z)).sqrt())
    };
    for (viewer, light) in [
        (Vec3::new(0.1, 0.2, 0.97), Vec3::new(0.3, -0.2, 0.93)),
        (Vec3::new(-0.95, 0.0, 0.3), Vec3::new(-0.5, 0.2, 0.84)),
        (Vec3::new(0.3, 0.0, 0.95), Vec3::new(-0.9, 0.1, 0.42)),
    ] {
        let (viewer, light) = (viewer.normalize(), light.normalize());
        let faces = viewer.dot(normal) > 0.0;
        let flipped = Vec3::new(-normal.x, -normal.y, normal.z);
        let cosine = |normal: Vec3| light.dot(normal).max(0.0);
        for (flags, expected) in [
            (false, if faces { cosine(normal) } else { 0.0 }),
            (true, cosine(if faces { normal } else { flipped }) * shadow(light)),
        ] {
            let scene = material(flags);
            let hit = scene.intersect(&Ray::new(Vec3::new(0.3, 0.1, 2.0), -Vec3::Z)).expect("the ray hits");
            let material = scene.material(hit.shape);
            // As the path from the camera asks, and as the one from the light does.
            let view = |outgoing, mode| View { outgoing, ..View::new(hit.uv, outgoing, mode) };
            let camera = material.evaluate(&view(viewer, TransportMode::Radiance), light).x * light.z;
            let from_light = material.evaluate(&view(light, TransportMode::Flux), viewer).x * light.z;
            let expected = expected * std::f32::consts::FRAC_1_PI;
            assert!((camera - expected).abs() < 1e-5, "{flags}: {camera} is not {expected}");
            assert!((from_light - expected).abs() < 1e-5, "{flags}: {from_light} is not {expected}");
        }
    }
}
