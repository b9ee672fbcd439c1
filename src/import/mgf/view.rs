//! The camera, which MGF has not: one that sees everything from outside. Rooms are dark from there; they get one inside.

use glam::{DMat4, DVec3, Vec3};

use super::super::default_environment::is_dark;
use super::super::draft::{Draft, DraftChild, Target};
use super::super::resolve::resolve;
use super::super::transform;
use crate::scene::Scene;
use crate::scene::bundle::{Bundle, Generated};
use crate::scene::camera;
use crate::scene::description::{PluginClass, SceneDescription};
use crate::scene::error::Location;
use crate::scene::fields::Fields;
use crate::scene::geometry::Ray;
use crate::scene::notice::Notice;

/// How wide a camera outside sees, degrees along the shorter side of the picture.
const OUTSIDE: f64 = 40.0;
/// The same of a camera inside.
const INSIDE: f64 = 70.0;
/// Where a camera outside looks from: in front, from the right and from above, for z upwards.
const VIEWPOINT: DVec3 = DVec3::new(0.5, -0.75, 0.45);
/// Where cameras inside may stand, as shares of the scene's box.
const PLACES: [f64; 3] = [0.12, 0.5, 0.88];
/// How many of the places with the most room around them are tried.
const TRIES: usize = 4;

/// The scene with a camera. `bounds` are those of all surfaces.
pub(super) fn with_camera(
    scene: Draft,
    bounds: [DVec3; 2],
    bundle: &Bundle,
    made: &Generated,
    notices: &mut Vec<Notice>,
) -> Draft {
    let place = scene.location.clone();
    let bounds = if bounds[0].x > bounds[1].x { [DVec3::NEG_ONE, DVec3::ONE] } else { bounds };
    let (target, radius) = (0.5 * (bounds[0] + bounds[1]), (0.5 * (bounds[1] - bounds[0]).length()).max(1e-6));
    let distance = radius / libm::sin(0.5 * OUTSIDE.to_radians());
    let origin = target + distance * VIEWPOINT.normalize();
    let outside = seen_by(&scene, sensor(origin, target, OUTSIDE, [1e-3 * distance, 10.0 * distance], &place));
    let prepared = |root: &Draft| {
        let bundle = bundle.clone().with_generated(made.clone());
        Scene::prepare(&SceneDescription { root: resolve(root, &[]).ok()?, bundle, notices: Vec::new(), moves: None })
            .ok()
    };
    let subject = "the view (MGF has no camera)";
    // What cannot be prepared is told when it is.
    let lit = prepared(&outside).filter(is_dark).and_then(|dark| {
        let inside = |origin: DVec3| {
            let aim = if origin.distance(target) > 0.05 * radius { target } else { target + DVec3::Y };
            sensor(origin, aim, INSIDE, [1e-4 * radius, 10.0 * radius], &place)
        };
        let candidates = roomy_places(&dark, bounds).into_iter().take(TRIES).map(inside);
        candidates.filter(|sensor| is_lit(&dark, sensor)).map(|sensor| seen_by(&scene, sensor)).next()
    });
    let (root, instead) = match lit {
        Some(root) => (root, "everything is dark from outside: a perspective camera looks from inside to the middle"),
        None => {
            (outside, "a perspective camera sees everything from outside, from the right and above with +z upwards")
        }
    };
    notices.push(Notice::approximated(&place, subject, instead));
    root
}

/// Whether a camera at another place would see a scene lit.
fn is_lit(scene: &Scene, sensor: &Draft) -> bool {
    let Ok(node) = resolve(sensor, &[]) else { return false };
    let camera = camera::read(&mut Fields::new(&node), scene.film.whole);
    camera.is_ok_and(|camera| {
        let mut seen = scene.clone();
        seen.camera = camera;
        !is_dark(&seen)
    })
}

/// The scene with its camera, which comes first.
fn seen_by(scene: &Draft, sensor: Draft) -> Draft {
    let mut scene = scene.clone();
    let location = sensor.location.clone();
    scene.children.insert(0, DraftChild { name: String::new(), target: Target::Plugin(sensor), location });
    scene
}

fn sensor(from: DVec3, to: DVec3, angle: f64, [near, far]: [f64; 2], place: &Location) -> Draft {
    let [from, to, up] = [from, to, DVec3::Z].map(|vector| vector.to_array());
    let to_world = transform::look_at(from, to, up).unwrap_or(DMat4::IDENTITY);
    Draft::new(PluginClass::Sensor, "perspective", place)
        .with_float("fov", angle)
        .with_text("fov_axis", "smaller")
        .with_float("near_clip", near)
        .with_float("far_clip", far)
        .with_transform("to_world", to_world)
}

/// Places within the scene's box, those with the most room around them first.
fn roomy_places(scene: &Scene, [least, most]: [DVec3; 2]) -> Vec<DVec3> {
    let mut places = Vec::new();
    for [x, y, z] in
        PLACES.iter().flat_map(|x| PLACES.iter().flat_map(move |y| PLACES.iter().map(move |z| [*x, *y, *z])))
    {
        let origin = least + (most - least) * DVec3::new(x, y, z);
        places.push((room(scene, origin.as_vec3()), origin));
    }
    places.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    places.into_iter().map(|(_, origin)| origin).collect()
}

/// The mean free distance around a place, m; what leads out of the scene counts nothing.
fn room(scene: &Scene, origin: Vec3) -> f32 {
    const DIRECTIONS: u32 = 96;
    let golden = 2.399_963_2_f32;
    let distance = |index: u32| {
        let z = 1.0 - (2 * index + 1) as f32 / DIRECTIONS as f32;
        let (sine, cosine) = libm::sincosf(golden * index as f32);
        let across = (1.0 - z * z).max(0.0).sqrt();
        let direction = Vec3::new(across * cosine, across * sine, z).normalize();
        scene.geometry.intersect(&Ray::new(origin, direction)).map_or(0.0, |hit| hit.distance)
    };
    (0..DIRECTIONS).map(distance).sum::<f32>() / DIRECTIONS as f32
}
