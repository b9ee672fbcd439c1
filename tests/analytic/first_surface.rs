//! What pixels see first, where formulas say it: a ball in front of a rectangle.

use crate::scene_text::prepare;
use photonfarm::math::{Rgb, Vec3};
use photonfarm::render::first_surface::{FirstSurface, NOTHING_SEEN, first_surface_layers};
use photonfarm::scene::Scene;

/// Pixels along either side.
const SIDE: usize = 33;
const BALL: Rgb = Rgb::new(0.75, 0.5, 0.25);
const WALL: Rgb = Rgb::new(0.125, 0.625, 0.375);

/// Seen from (0, 0, 5) downwards along z with a field of view of 40°.
fn scene(shapes: &str) -> Scene {
    let film = format!(
        "<film type='hdrfilm'><integer name='width' value='{SIDE}'/><integer name='height' value='{SIDE}'/>\
         <rfilter type='box'/></film>"
    );
    let place = "<transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>";
    let fields = "<float name='fov' value='40'/><float name='near_clip' value='1.5'/>";
    let sensor = format!("<sensor type='perspective'>{place}{fields}{film}</sensor>");
    prepare(&format!("{sensor}<emitter type='constant'/>{shapes}"), &[]).expect("a good scene")
}

fn matte(color: Rgb) -> String {
    format!("<bsdf type='diffuse'><rgb name='reflectance' value='{},{},{}'/></bsdf>", color.x, color.y, color.z)
}

/// A ball of radius 1 round the origin, and a square of half side 1.7 at z = -2.
fn ball_and_wall() -> Scene {
    let wall = "<transform name='to_world'><scale value='1.7'/><translate z='-2'/></transform>";
    scene(&format!("<shape type='sphere'>{}</shape><shape type='rectangle'>{wall}{}</shape>", matte(BALL), matte(WALL)))
}

/// What a camera ray meets.
#[derive(Clone, Copy)]
struct Met {
    albedo: Rgb,
    normal: Vec3,
    depth: f32,
    position: Vec3,
}

/// What a camera ray through a place of the film meets, if there is something.
fn expected(x: f32, y: f32) -> Option<Met> {
    let half_extent = 20_f32.to_radians().tan();
    let direction = Vec3::new((2.0 * x - 1.0) * half_extent, (1.0 - 2.0 * y) * half_extent, -1.0).normalize();
    let eye = Vec3::new(0.0, 0.0, 5.0);
    let middle = -eye.dot(direction);
    let discriminant = middle * middle - 24.0;
    if discriminant > 0.0 {
        let depth = middle - discriminant.sqrt();
        let position = eye + direction * depth;
        return Some(Met { albedo: BALL, normal: position, depth, position });
    }
    let depth = 7.0 / -direction.z;
    let position = eye + direction * depth;
    let is_on_wall = position.x.abs() < 1.7 && position.y.abs() < 1.7;
    is_on_wall.then_some(Met { albedo: WALL, normal: Vec3::Z, depth, position })
}

/// What the formulas give at 5 × 5 places of a pixel.
fn expected_in(column: usize, row: usize) -> Vec<Option<Met>> {
    let place = |cell: usize, step: usize| (cell as f32 + step as f32 / 4.0) / SIDE as f32;
    (0..25).map(|step| expected(place(column, step % 5), place(row, step / 5))).collect()
}

fn assert_between(found: f32, values: impl Iterator<Item = f32> + Clone, what: &str) {
    let (low, high) = (values.clone().fold(f32::INFINITY, f32::min), values.fold(f32::NEG_INFINITY, f32::max));
    assert!(found >= low - 1e-5 && found <= high + 1e-5, "{what}: {found} is not in {low}..{high}");
}

#[test]
fn analytic_first_surfaces_are_as_the_formulas_say() {
    let seen = first_surface_layers(&ball_and_wall());
    let (mut balls, mut walls, mut nothing) = (0, 0, 0);
    for (index, pixel) in seen.iter().enumerate() {
        let places = expected_in(index % SIDE, index / SIDE);
        let met: Vec<_> = places.iter().copied().flatten().collect();
        let what = format!("pixel {index}");
        let Some(Met { albedo, .. }) = met.first().copied() else {
            let zero = Vec3::ZERO;
            let expected = FirstSurface { albedo: Rgb::ZERO, normal: zero, depth: NOTHING_SEEN, position: zero };
            assert_eq!(*pixel, expected, "{what}");
            nothing += 1;
            continue;
        };
        assert_between(pixel.depth, met.iter().map(|met| met.depth), &what);
        for axis in 0..3 {
            assert_between(pixel.position[axis], met.iter().map(|met| met.position[axis]), &what);
        }
        if met.len() < places.len() || met.iter().any(|other| other.albedo != albedo) {
            continue;
        }
        if albedo == BALL {
            balls += 1
        } else {
            walls += 1
        }
        assert!(pixel.albedo.abs_diff_eq(albedo, 1e-6), "{what}: {}", pixel.albedo);
        for axis in 0..3 {
            assert_between(pixel.normal[axis], met.iter().map(|met| met.normal[axis]), &what);
        }
        let length = pixel.normal.length();
        assert!(length < 1.00001 && length > 0.97, "{what}: a normal of length {length}");
    }
    assert!(
        balls > 200 && walls > 100 && nothing > 500,
        "{balls} of the ball, {walls} of the wall, {nothing} of nothing"
    );
}

#[test]
fn analytic_first_surfaces_have_the_same_bits_on_any_number_of_threads() {
    let scene = ball_and_wall();
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let seen = pool.install(|| first_surface_layers(&scene));
        let values = |pixel: FirstSurface| [pixel.albedo, pixel.normal, Vec3::splat(pixel.depth), pixel.position];
        let bits = seen.into_iter().flat_map(values).flat_map(|vector| vector.to_array().map(f32::to_bits));
        bits.collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(2));
}

/// The pixel in the middle, of a wall across the view.
fn middle_of_wall(transform: &str, material: &str) -> FirstSurface {
    let wall = format!("<transform name='to_world'>{transform}<scale value='3'/></transform>");
    // The small ball is there for a camera that sees nothing but black backs is refused.
    first_surface_layers(&scene(&format!("<shape type='rectangle'>{wall}{material}</shape>{CORNER}")))[SIDE * SIDE / 2]
}

/// A small ball in the corner of the view.
const CORNER: &str =
    "<shape type='sphere'><point name='center' x='-0.8' y='0.8' z='2.5'/><float name='radius' value='0.2'/></shape>";

#[test]
fn analytic_first_surfaces_are_seen_on_their_side() {
    let (front, back) = ("", "<rotate y='1' angle='180'/>");
    let two_sided = format!("<bsdf type='twosided'>{}</bsdf>", matte(WALL));
    let dark = "<bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf>";
    let light = format!("{dark}<emitter type='area'/>");
    let glass = "<bsdf type='dielectric'/>".to_owned();
    for (transform, material, albedo) in [
        (front, &two_sided, WALL),
        (back, &two_sided, WALL),
        (front, &matte(WALL), WALL),
        (back, &matte(WALL), Rgb::ZERO),
        (front, &light, Rgb::ZERO),
        (front, &glass, Rgb::ONE),
        (back, &glass, Rgb::ONE),
    ] {
        let seen = middle_of_wall(transform, material);
        assert!(seen.albedo.abs_diff_eq(albedo, 1e-5), "{material}: {}", seen.albedo);
        assert!(seen.normal.abs_diff_eq(Vec3::Z, 1e-5), "{material}: {}", seen.normal);
        assert!((seen.depth - 5.0).abs() < 1e-2, "{material}: {}", seen.depth);
    }
}
