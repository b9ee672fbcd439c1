//! Camera matrices of EXR headers: they take what a camera ray meets back to the place of the picture from which the ray came.

use photonfarm::math::Vec3;
use photonfarm::scene::Scene;
use photonfarm::scene::camera::CameraMatrices;

use crate::scene_text::prepare;

const PLACE: &str =
    "<transform name='to_world'><lookat origin='3,-2,5' target='0.5,0.25,-1' up='0.1,1,0'/></transform>";
const WINDOW: [(&str, i32); 6] = [
    ("width", 60),
    ("height", 40),
    ("crop_offset_x", 13),
    ("crop_offset_y", 7),
    ("crop_width", 20),
    ("crop_height", 9),
];

fn scene(camera: &str, fields: &str, film: &[(&str, i32)]) -> Scene {
    let film: String = film.iter().map(|(name, value)| format!("<integer name='{name}' value='{value}'/>")).collect();
    let film = format!("<film type='hdrfilm'>{film}<rfilter type='box'/></film>");
    let sensor = format!("<sensor type='{camera}'>{fields}{film}</sensor>");
    prepare(&format!("{sensor}<emitter type='constant'/><shape type='cube'/>"), &[]).expect("a good scene")
}

fn matrices(scene: &Scene) -> Option<CameraMatrices> {
    scene.camera.matrices(&scene.film)
}

/// A point as a row vector, times a matrix by rows, divided by the fourth number.
fn multiplied(point: Vec3, matrix: [f32; 16]) -> [f64; 3] {
    let row = [f64::from(point.x), f64::from(point.y), f64::from(point.z), 1.0];
    let column = |column: usize| (0..4).map(|k| row[k] * f64::from(matrix[4 * k + column])).sum::<f64>();
    [0, 1, 2].map(|axis| column(axis) / column(3))
}

/// Where rays from the middles of some pixels arrive after some way, and the place of each pixel in the picture.
fn points(scene: &Scene, way: f32) -> Vec<(Vec3, [f64; 2])> {
    let (width, height) = (scene.width, scene.height);
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| [column, row]));
    let seen = |pixel: [u32; 2]| {
        // The last two numbers are 0 in the middle of a lens.
        let ray = scene.camera_ray(pixel, [0.5, 0.5, 0.0, 0.0]);
        let place = [(0, width), (1, height)].map(|(axis, size)| (f64::from(pixel[axis]) + 0.5) / f64::from(size));
        (ray.origin + ray.direction * way, place)
    };
    pixels.map(seen).collect()
}

fn assert_close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < 2e-5 * expected.abs().max(1.0), "{what}: {found} for {expected}");
}

#[test]
fn ndc_is_the_place_in_the_picture() {
    let fov = "<float name='fov' value='50'/>";
    let shift =
        "<float name='principal_point_offset_x' value='0.2'/><float name='principal_point_offset_y' value='-0.1'/>";
    let lens = "<float name='aperture_radius' value='0.3'/><float name='focus_distance' value='4'/>";
    let mirror = "<transform name='to_world'><scale x='-1'/><rotate y='1' angle='20'/><translate z='-4'/></transform>";
    let size =
        "<transform name='to_world'><scale x='3' y='3'/><rotate x='1' angle='-35'/><translate y='2'/></transform>";
    for (camera, fields) in [
        ("perspective", [PLACE, fov].concat()),
        ("perspective", [PLACE, fov, shift].concat()),
        ("perspective", [mirror, fov].concat()),
        ("thinlens", [PLACE, fov, lens].concat()),
        ("orthographic", size.to_owned()),
    ] {
        for film in [&WINDOW[..2], &WINDOW] {
            let scene = scene(camera, &fields, film);
            let ndc = matrices(&scene).and_then(|camera| camera.world_to_ndc).expect("straight lines stay straight");
            for (point, place) in points(&scene, 3.0) {
                let found = multiplied(point, ndc);
                assert_close(found[0], place[0], camera);
                assert_close(found[1], place[1], camera);
            }
        }
    }
}

/// The third number, which OpenEXR discards, is 0 and 1 at the clip distances.
#[test]
fn ndc_depth_spans_the_clip_distances() {
    let clip = "<float name='near_clip' value='0.5'/><float name='far_clip' value='20'/>";
    for camera in ["perspective", "orthographic"] {
        let scene = scene(camera, &[PLACE, clip].concat(), &WINDOW[..2]);
        let ndc = matrices(&scene).and_then(|camera| camera.world_to_ndc).expect("straight lines stay straight");
        let ray = scene.camera_ray([3, 30], [0.5; 4]);
        assert_close(multiplied(ray.origin, ndc)[2], 0.0, camera);
        assert_close(multiplied(ray.origin + ray.direction * ray.length, ndc)[2], 1.0, camera);
    }
}

/// Left-handed: x to the right of the picture, y up, z forward, from where the camera stands.
#[test]
fn camera_space_is_right_up_forward() {
    let scene = scene("perspective", PLACE, &WINDOW[..2]);
    let camera = matrices(&scene).expect("it stands somewhere").world_to_camera;
    let (origin, target) = (Vec3::new(3.0, -2.0, 5.0), Vec3::new(0.5, 0.25, -1.0));
    let ahead = [0.0, 0.0, f64::from(origin.distance(target))];
    for (axis, expected) in ahead.into_iter().enumerate() {
        assert_close(multiplied(origin, camera)[axis], 0.0, "origin");
        assert_close(multiplied(target, camera)[axis], expected, "target");
    }
    for (point, [x, y]) in points(&scene, 2.0) {
        let [right, up, forward] = multiplied(point, camera);
        assert!((right > 0.0) == (x > 0.5) && (up > 0.0) == (y < 0.5) && forward > 0.0, "{x}, {y}");
        let length = (right * right + up * up + forward * forward).sqrt();
        assert_close(length, f64::from(point.distance(origin)), "length");
    }
}

#[test]
fn cameras_without_a_picture_plane_have_no_ndc() {
    let all_around = matrices(&scene("spherical", PLACE, &WINDOW[..2])).expect("it stands somewhere");
    assert_eq!(all_around.world_to_ndc, None);
    assert_eq!(matrices(&scene("distant", "", &[("width", 1), ("height", 1)])), None);
}
