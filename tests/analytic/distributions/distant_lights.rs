//! Light from outside starts on the box around the scene: χ² tests of where and whither, against integrals, and that what a
//! scene cannot receive is not sent.
//!
//! With the other tests of sampling the χ² tests fail by chance with probability 10⁻³ (Šidák's correction), the others at four
//! standard errors (6·10⁻⁵ each); seeds are fixed.

use std::f64::consts::PI;

use crate::chi_square::{Histogram, assert_directions, assert_uniform, numbers};
use crate::scene_files::{exr_file, prepare};
use photonfarm::math::{Frame, Vec3};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::light::{EmittedPhoton, Light, Origin};

const SAMPLES: u32 = 100_000;

/// An oblong block off the origin, whose box it fills.
const BLOCK: &str = "<shape type='cube'><transform name='to_world'><scale x='1' y='0.3' z='2'/>\
    <translate value='1, 2, 3'/></transform></shape>";
/// Its half sizes.
const HALF: Vec3 = Vec3::new(1.0, 0.3, 2.0);
const MIDDLE: Vec3 = Vec3::new(1.0, 2.0, 3.0);

const SKY: &str = "<emitter type='constant'/>";
const MAP: &str = "<emitter type='envmap'><string name='filename' value='sky.exr'/>\
    <transform name='to_world'><rotate x='1' y='-2' z='0.5' angle='65'/></transform></emitter>";

fn sun(direction: Vec3) -> String {
    let Vec3 { x, y, z } = direction;
    format!("<emitter type='directional'><vector name='direction' value='{x}, {y}, {z}'/></emitter>")
}

fn scene(shapes: &str, light: &str) -> Scene {
    let sky = exr_file(8, 5, |x, y| [(x % 3) as f32, if (x, y) == (5, 1) { 20.0 } else { 1.0 }, (y % 2) as f32]);
    prepare(&format!("<sensor type='perspective'/>{shapes}{light}"), &[("sky.exr", &sky)]).expect("the scene is good")
}

fn only_light(scene: &Scene) -> &Light {
    let [light] = scene.lights.lights() else { panic!("one light is expected") };
    light
}

fn photons(scene: &Scene, family: u32) -> Vec<EmittedPhoton> {
    let emit = |sample| {
        let u = numbers(family, sample);
        only_light(scene).emit(&scene.geometry, [u[0], u[1]], [u[2], u[3]]).expect("light comes")
    };
    (0..SAMPLES).map(emit).collect()
}

/// Of as many as there are samples.
fn mean_and_error(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (sum, squares) = values.fold((0.0, 0.0), |(sum, squares), value| (sum + value, squares + value * value));
    let mean = sum / f64::from(SAMPLES);
    (mean, ((squares / f64::from(SAMPLES) - mean * mean).max(0.0) / f64::from(SAMPLES)).sqrt())
}

/// The block's silhouette from first principles: a third of its faces, by their cosines.
fn silhouette(direction: Vec3) -> f64 {
    let [x, y, z] = (2.0 * HALF).to_array().map(f64::from);
    let [a, b, c] = direction.abs().to_array().map(f64::from);
    a * y * z + b * z * x + c * x * y
}

fn surface() -> f64 {
    2.0 * [Vec3::X, Vec3::Y, Vec3::Z].map(silhouette).iter().sum::<f64>()
}

/// Places across the direction, against which of them meet the block.
#[test]
fn chi_square_places_of_directional_light() {
    const SIDE: usize = 16;
    const FINE: usize = 40;
    for (family, direction) in
        [(220, Vec3::new(1.0, -2.0, 0.5)), (221, Vec3::new(-0.1, 3.0, 1.0)), (223, Vec3::new(0.0, 1.0, -1.0))]
    {
        let scene = scene(BLOCK, &sun(direction));
        let (axis, radius) = (Frame::from_normal(direction.normalize()), HALF.length());
        let mut histogram = Histogram::new(SIDE * SIDE);
        let bin = |x: f32| (((x / radius + 1.0) * 0.5 * SIDE as f32) as usize).min(SIDE - 1);
        for photon in photons(&scene, family) {
            assert!(photon.direction.distance(axis.normal) < 1e-6);
            let local = axis.to_local(photon.origin - MIDDLE);
            assert!((MIDDLE - photon.origin).abs().cmpgt(HALF).any(), "a photon starts inside the block");
            histogram.add(bin(local.x) * SIDE + bin(local.y));
        }
        let place = |index: usize| radius * ((index as f32 + 0.5) / (SIDE * FINE) as f32 * 2.0 - 1.0);
        let mut shares = vec![0.0; SIDE * SIDE];
        for i in 0..SIDE * FINE {
            for j in 0..SIDE * FINE {
                let offset = Vec3::new(place(i), place(j), -2.0 * radius);
                let ray = Ray::new(MIDDLE + axis.to_world(offset), axis.normal);
                shares[i / FINE * SIDE + j / FINE] += f64::from(u8::from(scene.geometry.intersect(&ray).is_some()));
            }
        }
        let all: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= all);
        histogram.assert_shares(&shares, &format!("directional light along {direction}"));
    }
}

/// Across one face.
#[test]
fn chi_square_places_of_light_along_an_axis() {
    let scene = scene(BLOCK, &sun(Vec3::NEG_X));
    let places = photons(&scene, 222).into_iter().map(|photon| {
        let local = ((photon.origin - MIDDLE) / HALF + 1.0) * 0.5;
        [f64::from(local.y), f64::from(local.z)]
    });
    assert_uniform(places, "light along x");
}

#[test]
fn chi_square_directions_of_distant_photons() {
    let sky = scene(BLOCK, SKY);
    let directions = photons(&sky, 224).into_iter().map(|photon| Some(photon.direction));
    let pdf = |direction| silhouette(direction) / (PI * surface());
    assert_directions(directions, pdf, -1.0, "constant: directions");

    let map = scene(BLOCK, MAP);
    let directions = photons(&map, 225).into_iter().map(|photon| Some(-photon.direction));
    let pdf = |direction| f64::from(map.lights.environment(&MIDDLE.into(), direction).expect("light comes").1);
    assert_directions(directions, pdf, -1.0, "a map: directions");
}

/// A ball anywhere in the box gets πr²·∫ L dω, and the densities are those that the other ways to find a path are told.
#[test]
fn energy_of_distant_photons_is_even_all_over_the_box() {
    let direction = Vec3::new(1.0, -2.0, 0.5);
    for (family, light) in [(226, sun(direction)), (227, SKY.to_owned()), (228, MAP.to_owned())] {
        let scene = scene(BLOCK, &light);
        let light = only_light(&scene);
        let photons = photons(&scene, family);
        // ∫ L dω by light sampling.
        let arriving = (0..SAMPLES).map(|sample| {
            let u = numbers(family + 10, sample);
            let sample = light.sample_direct(&scene.geometry, MIDDLE, [u[0], u[1]]).expect("light comes");
            f64::from(sample.weighted_radiance.y)
        });
        let fluence = arriving.sum::<f64>() / f64::from(SAMPLES);
        for [x, y, z] in [[0.0, 0.0, 0.0], [0.85, 0.1, 1.85], [-0.85, -0.1, -1.85], [0.85, -0.1, -0.3]] {
            let (center, radius) = (MIDDLE + Vec3::new(x, y, z), 0.15);
            let meets = |photon: &EmittedPhoton| (center - photon.origin).cross(photon.direction).length() < radius;
            let flux = |photon: &EmittedPhoton| if meets(photon) { f64::from(photon.flux.y) } else { 0.0 };
            let (found, error) = mean_and_error(photons.iter().map(flux));
            let expected = PI * f64::from(radius).powi(2) * fluence;
            // Light sampling of the map has an error of its own, far below 0.5 %.
            let bound = 4.0 * error + 0.005 * expected;
            assert!((found - expected).abs() < bound, "family {family}: {found} ± {error} W of {expected} W");
            assert!(bound < 0.2 * expected, "the test is blind");
        }
        let (mean, error) = mean_and_error(photons.iter().map(|photon| f64::from(photon.flux.y)));
        let power = f64::from(light.power().y);
        assert!((mean - power).abs() < 4.0 * error + 1e-3 * power, "photons carry {mean} ± {error} W of {power} W");
        let differ = photons.iter().filter(|photon| !densities_agree(light, photon)).count();
        assert!(differ < 20, "family {family}: {differ} densities differ");
    }
}

/// Rounding may move a direction of a map over the edge of its cell, where the density is another.
fn densities_agree(light: &Light, photon: &EmittedPhoton) -> bool {
    let Origin::Distant { sampling_ratio } = photon.origin_kind else { panic!("photons come from outside") };
    match light.environment(-photon.direction) {
        None => (photon.pdf * sampling_ratio - 1.0).abs() < 1e-4,
        Some((_, sampled)) => {
            let ratio = light.environment_emission_ratio(-photon.direction);
            (photon.pdf / (sampled * ratio) - 1.0).abs() < 1e-3 && (sampling_ratio * ratio - 1.0).abs() < 1e-3
        }
    }
}

// ---- What arrives. ------------------------------------------------------------------------------------------------

fn share_that_meets(scene: &Scene, family: u32) -> f64 {
    let meets = |photon: &EmittedPhoton| scene.geometry.intersect(&Ray::new(photon.origin, photon.direction)).is_some();
    photons(scene, family).iter().filter(|photon| meets(photon)).count() as f64 / f64::from(SAMPLES)
}

/// A floor, a wall, and a floor far from the origin: the sun's photons all arrive, of a disc's less than a third would.
#[test]
fn all_photons_of_the_sun_meet_a_flat_scene() {
    let turns = ["<rotate x='1' angle='-90'/>", "<rotate y='1' angle='90'/>", "<translate value='3, -50, 7'/>"];
    for (index, turn) in turns.into_iter().enumerate() {
        let floor = format!("<shape type='rectangle'><transform name='to_world'>{turn}</transform></shape>");
        for (which, direction) in [Vec3::new(2.0, -1.0, -2.0), Vec3::new(0.5, 3.0, 0.4)].into_iter().enumerate() {
            let share = share_that_meets(&scene(&floor, &sun(direction)), 240 + 2 * index as u32 + which as u32);
            assert!(share > 0.999, "{share} of all photons meet {turn}");
        }
    }
}

/// Along a flat scene nothing can arrive; that is no error.
#[test]
fn light_along_a_flat_scene_passes_by() {
    let floor = "<shape type='rectangle'/>";
    let along = scene(floor, &sun(Vec3::new(0.6, 0.8, 0.0)));
    let power = only_light(&along).power().x;
    assert!(power > 0.0 && power < 1e-4, "{power} W");
    assert!(photons(&along, 250).iter().all(|photon| photon.flux.is_finite() && photon.origin.is_finite()));
    assert_eq!(share_that_meets(&along, 250), 0.0);
    // Half of what a sky sends to a floor would come from below; all of it meets.
    for (family, light) in [(251, SKY), (252, MAP)] {
        let share = share_that_meets(&scene(floor, light), family);
        assert!(share > 0.999, "{share} of all photons meet the floor");
    }
}
