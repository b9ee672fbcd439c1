//! Lights are picked by what may arrive at a place: with the stated probabilities, and never without those that do arrive.

use crate::scene_text;
use std::path::Path;

use photonfarm::import::load_file;
use photonfarm::math::Vec3;
use photonfarm::math::color::luminance;
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::light::importance::{Aim, Lamp};
use photonfarm::scene::light::importance_sampler::ImportanceSampler;
use photonfarm::scene::light::visibility::VisibilityNode;
use photonfarm::scene::light::{DirectSample, LightImportance, LightVisibility};
use photonfarm::transport::visibility_learning::{LightTrial, learn};

/// Evenly spread numbers in [0, 1).
const STEPS: u32 = 200_000;

/// Four random numbers in [0, 1).
fn numbers(index: u32) -> [f32; 4] {
    PathRandom::new(7, Stream::Photon, 0, index).block(0)
}

/// A random place in a box of 1 m.
fn place(index: u32) -> Vec3 {
    Vec3::from_slice(&numbers(index))
}

/// Lamps of all kinds in a box of 20 m, and two lights outside.
fn importances(count: usize) -> Vec<LightImportance> {
    let lamp = |index: usize| {
        let [center, axis, rest] = [0, 1, 2].map(|part| place(3 * index as u32 + part));
        let axis = axis - 0.5;
        let aim = match index % 3 {
            0 => Aim::Everywhere,
            1 => Aim::Side(axis.normalize()),
            _ => Aim::Cone(axis.normalize(), 2.0 * rest.z - 1.0),
        };
        LightImportance::Near(Lamp { center: center * 20.0, radius: rest.x, intensity: 0.1 + 10.0 * rest.y, aim })
    };
    let far = [0.01, 0.05].map(|irradiance| LightImportance::Far { irradiance });
    (0..count).map(lamp).chain(far).collect()
}

#[test]
fn lights_are_picked_as_often_as_their_probabilities_say() {
    // One group of lamps, and several; whatever is known of occlusion.
    for (count, hides) in [0, 1, 30, 1000].into_iter().flat_map(|count| [(count, false), (count, true)]) {
        let importances = importances(count);
        // A third of the lamps are left out.
        let share = |light: usize| match light % 3 {
            0 if light < count => 0.0,
            _ => numbers(light as u32)[3].powi(4).max(1e-6),
        };
        let picks = match hides {
            false => ImportanceSampler::new(&importances, 1e-3),
            true => ImportanceSampler::of_shares(&importances, 1e-3, share),
        };
        for position in [Vec3::splat(10.0), Vec3::new(3.0, 19.0, -1.0), Vec3::new(500.0, 0.0, 40.0)] {
            let place = position.into();
            let mut found = vec![0u32; importances.len()];
            for step in 0..STEPS {
                let u = (step as f32 + 0.5) / STEPS as f32;
                let (light, probability) = picks.pick(&place, u).expect("there are lights outside");
                found[light] += 1;
                let told = picks.probability(&place, light);
                assert!((probability - told).abs() <= 1e-5 * told, "light {light}: {probability} and {told}");
            }
            for (light, found) in found.into_iter().enumerate() {
                let (share, told) = (found as f32 / STEPS as f32, picks.probability(&place, light));
                // A step more or less at either end, and rounding of the running sum.
                assert!((share - told).abs() < 5e-5, "{count} lamps, light {light} at {position}: {share} and {told}");
            }
        }
    }
}

#[test]
fn near_and_bright_lamps_are_picked_more_often() {
    let lamp = |x: f32, intensity| {
        LightImportance::Near(Lamp { center: Vec3::X * x, radius: 0.0, intensity, aim: Aim::Everywhere })
    };
    let lamps = [lamp(1.0, 1.0), lamp(2.0, 1.0), lamp(2.0, 8.0)];
    let picks = ImportanceSampler::new(&lamps, 1e-3);
    let found = [0, 1, 2].map(|light| picks.probability(&Vec3::ZERO.into(), light));
    let expected = [4.0 / 13.0, 1.0 / 13.0, 8.0 / 13.0];
    assert!((0..3).all(|light| (found[light] - expected[light]).abs() < 1e-6), "{found:?}");
    // The brightest is seen from an eighth of the places.
    let picks = ImportanceSampler::of_shares(&lamps, 1e-3, |light| if light == 2 { 0.125 } else { 1.0 });
    let found = [0, 1, 2].map(|light| picks.probability(&Vec3::ZERO.into(), light));
    let expected = [4.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0];
    assert!((0..3).all(|light| (found[light] - expected[light]).abs() < 1e-6), "{found:?}");
}

/// A spot, a flat mesh, a sphere, a cylinder, a bent mesh, a point and the sky: whatever sends light to a place can be picked there.
fn all_kinds() -> Scene {
    let glow = "<emitter type='area'><rgb name='radiance' value='1, 2, 3'/></emitter>";
    let at = |x: f64, turn: &str| {
        format!(
            "<transform name='to_world'><scale value='0.3'/>{turn}<translate x='{x}' y='0.4' z='-0.2'/></transform>"
        )
    };
    let tilt = "<rotate x='1' y='2' angle='40'/>";
    let body = format!(
        "<sensor type='perspective'/><shape type='rectangle'/><emitter type='constant'/><emitter type='point'/>\
        <emitter type='spot'>{}<float name='cutoff_angle' value='50'/><float name='beam_width' value='50'/></emitter>\
        <shape type='rectangle'>{}{glow}</shape><shape type='cube'>{}{glow}</shape><shape type='sphere'>{}{glow}</shape>\
        <shape type='cylinder'>{}{glow}</shape><shape type='disk'>{}{glow}</shape>\
        <shape type='obj'><string name='filename' value='kite.obj'/>{}{glow}</shape>\
        <shape type='obj'><string name='filename' value='bent.obj'/>{}{glow}</shape>",
        at(0.0, tilt),
        at(1.0, tilt),
        at(2.0, tilt),
        at(-1.0, ""),
        at(-2.0, tilt),
        at(3.0, tilt),
        at(-3.0, tilt),
        at(4.0, tilt),
    );
    let kite = "v 0 0 0\nv 3 1 0\nv 4 4 0\nv 1 3 0\nf 1 2 3\nf 1 3 4\n";
    let files = [("kite.obj", kite.to_owned()), ("bent.obj", kite.replace("v 1 3 0", "v 1 3 2"))];
    scene_text::prepare(&body, &files).expect("the scene is good")
}

fn picks_of(scene: &Scene) -> ImportanceSampler {
    let importances: Vec<LightImportance> =
        scene.lights.lights().iter().map(|light| light.importance(&scene.geometry)).collect();
    ImportanceSampler::new(&importances, 1e-4)
}

/// Numbers of a tree with two cells, across x, and shares of `count` lights that differ there.
fn two_cells(count: usize) -> Vec<f32> {
    let mut values = Vec::new();
    VisibilityNode::Parted { axis: 0, at: 0.5 }.write(&mut values);
    for cell in 0..2 {
        let shares: Vec<f32> = (0..count).map(|light| if (light + cell) % 2 == 0 { 1.0 } else { 1e-4 }).collect();
        VisibilityNode::Cell(&shares).write(&mut values);
    }
    values
}

#[test]
fn seen_lights_are_picked_as_often_as_their_probabilities_say() {
    let scene = all_kinds();
    let count = scene.lights.lights().len();
    let visibility = LightVisibility::new(&two_cells(count), &scene.lights).expect("a good tree");
    let seeing = scene.with_lights(scene.lights.with_visibility(visibility));
    for position in [Vec3::new(-0.9, -0.8, 2.0), Vec3::new(0.9, -0.7, -0.7)] {
        let hit = seeing.intersect(&Ray::new(position.with_z(0.01), -Vec3::Z)).expect("the rectangle is behind all");
        for place in [seeing.place(&hit), position.into()] {
            let mut found = vec![0u32; count];
            for step in 0..STEPS {
                let (light, probability) =
                    seeing.lights.pick(&place, (step as f32 + 0.5) / STEPS as f32).expect("there is a sky");
                found[light] += 1;
                let told = seeing.lights.probability(&place, light);
                assert!((probability - told).abs() <= 1e-5 * told, "light {light}: {probability} and {told}");
            }
            for (light, found) in found.into_iter().enumerate() {
                let (share, told) = (found as f32 / STEPS as f32, seeing.lights.probability(&place, light));
                assert!((share - told).abs() < 5e-5, "light {light} at {position}: {share} and {told}");
                assert!(told > 0.0 || scene.lights.probability(&place, light) == 0.0, "light {light} is lost");
            }
        }
    }
}

#[test]
fn what_is_no_tree_is_refused() {
    let scene = all_kinds();
    let good = two_cells(scene.lights.lights().len());
    assert!(LightVisibility::new(&good, &scene.lights).is_ok());
    let with = |index: usize, value: f32| {
        let mut values = good.clone();
        values[index] = value;
        values
    };
    let longer = [good.as_slice(), &[1.0]].concat();
    let wrong = [vec![], good[1..].to_vec(), good[..good.len() - 1].to_vec(), longer, [-1.0, 0.0].repeat(1000)];
    let numbers =
        [with(0, -4.0), with(0, f32::NAN), with(1, f32::INFINITY), with(2, 0.0), with(3, 1.5), with(4, f32::NAN)];
    for values in wrong.iter().chain(&numbers) {
        assert!(LightVisibility::new(values, &scene.lights).is_err(), "{values:?}");
    }
}

/// A trial of one of two lights at a random place in a box of 1 m.
fn trial(index: u32, arrives: impl Fn(u32, Vec3) -> bool) -> LightTrial {
    let (light, position) = (index % 2, place(index));
    LightTrial { position, light, arrives: arrives(light, position) }
}

#[test]
fn where_lights_are_seen_is_learnt() {
    let trials: Vec<LightTrial> =
        (0..1 << 15).map(|index| trial(index, |light, position| light == 0 && position.x < 0.75)).collect();
    let values = learn(&trials, 2).expect("few lights");
    let scene = all_kinds();
    let share = |position: Vec3| cell_of(&values, position);
    // Far from the border; the second light is seen nowhere.
    let (seen, hidden) = (share(Vec3::new(0.2, 0.5, 0.5)), share(Vec3::new(0.9, 0.5, 0.5)));
    assert!(seen[0] > 0.99 && hidden[0] < 0.1, "{seen:?} and {hidden:?}");
    assert!(seen[1] < 1e-4 && hidden[1] < 1e-4, "{seen:?} and {hidden:?}");
    assert!(learn(&[], 2).is_some_and(|values| values == [1.0, 1.0]), "all lights are seen where none was tried");
    assert_eq!(learn(&trials, 1 << 20), None);
    assert!(scene.lights.visibility().is_none());
}

/// The shares of two lights in the cell of a tree.
fn cell_of(values: &[f32], position: Vec3) -> [f32; 2] {
    fn end(values: &[f32], node: usize) -> usize {
        if values[node] < 0.0 { end(values, end(values, node + 2)) } else { node + 2 }
    }
    let mut node = 0;
    while values[node] < 0.0 {
        let axis = (-1.0 - values[node]) as usize;
        node = if position[axis] < values[node + 1] { node + 2 } else { end(values, node + 2) };
    }
    [values[node], values[node + 1]]
}

#[test]
fn every_light_that_arrives_can_be_picked() {
    let scene = all_kinds();
    let (lights, picks) = (scene.lights.lights(), picks_of(&scene));
    let (mut arrived, mut left_out) = (0, 0);
    for index in 0..20_000 {
        let [u, v, ..] = numbers(2 * index);
        let (u, place) = ([u, v], (place(2 * index + 1) - 0.5) * 8.0);
        for (index, light) in lights.iter().enumerate() {
            let can_be_picked = picks.probability(&place.into(), index) > 0.0;
            if light.sample_direct(&scene.geometry, place, u).is_some() {
                arrived += 1;
                assert!(can_be_picked, "light {index} arrives at {place} and is never picked");
            }
            left_out += usize::from(!can_be_picked);
        }
    }
    // Spots and flat lamps are left out behind them.
    assert!(arrived > 100_000 && left_out > 30_000, "{arrived} arrived, {left_out} left out");
}

/// The same on surfaces, where lights below the horizon are left out.
#[test]
fn every_light_over_the_horizon_can_be_picked() {
    let scene = all_kinds();
    let (lights, picks) = (scene.lights.lights(), picks_of(&scene));
    let (mut arrived, mut left_out) = (0, 0);
    for index in 0..20_000 {
        let [u, v, ..] = numbers(3 * index);
        let (origin, target) = ((place(3 * index + 1) - 0.5) * 8.0, (place(3 * index + 2) - 0.5) * 3.0);
        let Some(hit) = scene.intersect(&Ray::new(origin, (target - origin).normalize())) else { continue };
        let surface = scene.place(&hit);
        let facing = hit.geometric_normal * hit.outgoing.dot(hit.geometric_normal).signum();
        for (index, light) in lights.iter().enumerate() {
            let can_be_picked = picks.probability(&surface, index) > 0.0;
            let sample = light.sample_direct(&scene.geometry, surface.position, [u, v]);
            if sample.is_some_and(|sample| sample.direction.dot(facing) > 1e-4) {
                arrived += 1;
                assert!(can_be_picked, "light {index} arrives at {} and is never picked", surface.position);
            }
            left_out += usize::from(!can_be_picked);
        }
    }
    assert!(arrived > 10_000 && left_out > 10_000, "{arrived} arrived, {left_out} left out");
}

/// Whatever the probabilities: on average a picked light gives what all lights together give.
#[test]
fn picking_keeps_the_mean() {
    const SAMPLES: u32 = 4000;
    let gallery = load_file(Path::new("scenes/gallery/scene.xml"), &[]).expect("the scene loads");
    for scene in [all_kinds(), Scene::prepare(&gallery).expect("the scene is good")] {
        let (low, high) = scene.geometry.bounds();
        let (mut difference, mut variance, mut all) = (0.0, 0.0, 0.0);
        for index in 0..100 {
            let target = low + (high - low) * place(1000 + index);
            let origin = low + (high - low) * place(2000 + index);
            let Some(hit) = scene.intersect(&Ray::new(origin, (target - origin).normalize())) else { continue };
            let surface = scene.place(&hit);
            let arriving = |sample: Option<DirectSample>| {
                sample.map_or(0.0, |sample| {
                    let cosine =
                        sample.direction.dot(hit.geometric_normal) * hit.outgoing.dot(hit.geometric_normal).signum();
                    f64::from(luminance(sample.weighted_radiance) * cosine.max(0.0))
                })
            };
            let (mut sum, mut squares) = (0.0, 0.0);
            for step in 0..SAMPLES {
                let [u, v, w, _] = numbers(10_000 + index * SAMPLES + step);
                let picked = arriving(scene.lights.sample_direct(&scene.geometry, &surface, [u, v, w]));
                let lights = scene.lights.lights().iter();
                let together: f64 =
                    lights.map(|light| arriving(light.sample_direct(&scene.geometry, surface.position, [u, v]))).sum();
                sum += picked - together;
                squares += (picked - together).powi(2);
                all += together / f64::from(SAMPLES);
            }
            difference += sum / f64::from(SAMPLES);
            variance += squares / f64::from(SAMPLES).powi(2);
        }
        let deviations = difference / variance.sqrt();
        println!("off by {:.4} ± {:.4}", difference / all, variance.sqrt() / all);
        assert!(deviations.abs() < 4.5, "off by {:.4} ± {:.4}", difference / all, variance.sqrt() / all);
    }
}
