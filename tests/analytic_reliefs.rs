//! Normal maps and bump maps against closed forms, and what cannot have a relief.

#[path = "support/scene_files.rs"]
mod scene_files;

use photonfarm::math::Vec3;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::{Scene, SceneError};
use scene_files::{exr_file, prepare};

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

fn relief(kind: &str, inside: &str) -> String {
    format!("<bsdf type='{kind}'>{TEXTURE}{inside}</bsdf>")
}

/// The shading normal at a point of the rectangle; the frame round it must be one.
fn normal(scene: &Scene, x: f32, y: f32) -> Vec3 {
    let hit = scene.intersect(&Ray::new(Vec3::new(x, y, 2.0), -Vec3::Z)).expect("the ray hits");
    let frame = hit.frame;
    let axes = [frame.tangent, frame.bitangent, frame.normal];
    for (index, axis) in axes.iter().enumerate() {
        assert!((axis.length() - 1.0).abs() < 1e-5 && axis.dot(axes[(index + 1) % 3]).abs() < 1e-5);
    }
    assert!(frame.tangent.x > 0.0 && frame.bitangent.y > 0.0, "the frame follows u");
    assert_eq!(hit.geometric_normal, Vec3::Z, "the true surface stays");
    frame.normal
}

#[test]
fn analytic_normal_maps_hold_normals() {
    for expected in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.36, 0.48, 0.8)] {
        let color = (expected * 0.5 + 0.5).to_array();
        let file = exr_file(2, 2, |_, _| color);
        for bsdf in
            [relief("normalmap", DIFFUSE), format!("<bsdf type='twosided'>{}</bsdf>", relief("normalmap", DIFFUSE))]
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
        let scene = rectangle(&relief("bumpmap", &inside), &file).expect("the scene is good");
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
fn analytic_reliefs_that_cannot_be() {
    let file = exr_file(2, 2, |_, _| [0.5, 0.5, 1.0]);
    let twice = relief("normalmap", &relief("bumpmap", DIFFUSE));
    let two = format!("<bsdf type='twosided'>{}{DIFFUSE}</bsdf>", relief("bumpmap", DIFFUSE));
    for (bsdf, part) in [
        (twice, "one relief holds another"),
        (two, "holds several bsdfs, one of them a \"bumpmap\""),
        (relief("normalmap", ""), "\"normalmap\" holds no bsdf"),
        (format!("<bsdf type='bumpmap'>{DIFFUSE}</bsdf>"), "\"bumpmap\" holds no texture"),
        (format!("<bsdf type='normalmap'>{DIFFUSE}</bsdf>"), "has no texture \"normalmap\""),
        (relief("normalmap", &format!("{DIFFUSE}{DIFFUSE}")), "cannot hold another bsdf"),
        (relief("bumpmap", &format!("{DIFFUSE}<float name='scall' value='1'/>")), "did you mean \"scale\"?"),
    ] {
        let message = rectangle(&bsdf, &file).err().unwrap_or_else(|| panic!("{bsdf} is no error")).to_string();
        assert!(message.contains(part) && message.contains("test.xml"), "{bsdf}: {message}");
    }
}
