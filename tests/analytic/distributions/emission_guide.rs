//! Photons that start as a guide says: how often where, and with what weight.

use photonfarm::math::Rgb;
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::scene::Scene;
use photonfarm::scene::light::emission_guide::{
    BY_POWER, EmissionGuide, EmissionPoint, GuideCell, GuideError, GuideNode,
};

use crate::chi_square::Histogram;
use crate::scene_text::prepare;

const SAMPLES: u32 = 1 << 18;

/// Three lights, of which the second emits nothing.
fn scene() -> Scene {
    let body = "<sensor type='perspective'/><shape type='cube'/><emitter type='point'><point name='position' value='0, 3, 0'/>\
        <rgb name='intensity' value='3, 2, 1'/></emitter><emitter type='point'><rgb name='intensity' value='0'/></emitter>\
        <shape type='sphere'><point name='center' value='4, 0, 0'/><float name='radius' value='0.5'/>\
        <emitter type='area'><rgb name='radiance' value='1, 2, 5'/></emitter></shape>";
    prepare(body, &[]).expect("the scene is good")
}

fn values(nodes: &[GuideNode]) -> Vec<f32> {
    nodes.iter().map(|node| f32::from(*node)).collect()
}

/// Cells of many sizes and weights, one of them without any.
fn nodes() -> Vec<GuideNode> {
    use GuideNode::{Cell, Halved};
    vec![
        Halved(0),
        Cell(1.0),
        Halved(3),
        Cell(0.0),
        Halved(3),
        Cell(7.0),
        Cell(0.25),
        Cell(3.0),
        Halved(2),
        Halved(1),
        Cell(2.0),
        Cell(0.5),
        Cell(11.0),
    ]
}

fn point(scene: &Scene, guide: &EmissionGuide, sample: u32) -> EmissionPoint {
    let random = PathRandom::new(0x9e37, Stream::Photon, 3, sample);
    let ([a, b, pick, _], [c, d, ..]) = (random.block(0), random.block(1));
    scene.lights.emission_point(Some(guide), [a, b, pick], [c, d])
}

fn holds(cell: &GuideCell, point: &EmissionPoint) -> bool {
    let inside = |axis: usize| (cell.low[axis]..cell.low[axis] + cell.side[axis]).contains(&point.numbers[axis]);
    cell.light == point.light && (0..4).all(inside)
}

#[test]
fn chi_square_guided_photons_start_as_often_as_their_density_says() {
    let scene = scene();
    let guide = EmissionGuide::new(&values(&nodes()), &scene.lights).expect("a good guide");
    let probabilities: Vec<f64> = guide.probabilities().collect();
    let (cells, count) = (guide.cells(), guide.cells().len());
    let mut places = Histogram::new(count);
    // Each half of each dimension of each cell.
    let mut halves = Histogram::new(8 * count);
    for sample in 0..SAMPLES {
        let point = point(&scene, &guide, sample);
        let index = cells.iter().position(|cell| holds(cell, &point)).expect("cells cover all that is emitted");
        let cell = &cells[index];
        let by_power = f64::from(scene.lights.emission_pick(cell.light)) * f64::from(cell.volume());
        let expected = probabilities[index] / by_power;
        assert!((f64::from(point.density) / expected - 1.0).abs() < 1e-6, "{point:?}, {expected}");
        places.add(index);
        for axis in 0..4 {
            let half = usize::from(!cell.is_first_half(axis, point.numbers[axis]));
            halves.add(8 * index + 2 * axis + half);
        }
    }
    places.assert_shares(&probabilities, "cells of a guide");
    let shares: Vec<f64> = probabilities.iter().flat_map(|share| [share / 8.0; 8]).collect();
    halves.assert_shares(&shares, "halves of the cells of a guide");
}

/// Weights are inverse densities: over all that is emitted by power they average 1, in closed form and for what lights emit.
#[test]
fn weights_of_guided_photons_average_one() {
    let scene = scene();
    let guide = EmissionGuide::new(&values(&nodes()), &scene.lights).expect("a good guide");
    let by_power = |cell: &GuideCell| f64::from(scene.lights.emission_pick(cell.light)) * f64::from(cell.volume());
    let whole: f64 = guide.probabilities().sum();
    assert_eq!(whole, 1.0);
    for (cell, probability) in guide.cells().iter().zip(guide.probabilities()) {
        assert!(probability >= BY_POWER * by_power(cell) * (1.0 - 1e-3), "{cell:?} has {probability}");
        assert_eq!(probability == 0.0, by_power(cell) == 0.0, "{cell:?}: only dark lights emit nothing");
    }
    let (mut sum, mut squares) = (Rgb::ZERO, Rgb::ZERO);
    for sample in 0..SAMPLES {
        let start = point(&scene, &guide, sample);
        let photon = scene.lights.emit_at(&scene.geometry, &start).expect("both lights emit everywhere");
        sum += photon.flux;
        squares += photon.flux * photon.flux;
    }
    let count = SAMPLES as f32;
    let power: Rgb = scene.lights.lights().iter().map(|light| light.power()).sum();
    let (mean, squares) = (sum / count, squares / count);
    for channel in 0..3 {
        let [mean, squares, power] = [mean, squares, power].map(|color| color.to_array()[channel]);
        let error = ((squares - mean * mean) / count).sqrt();
        assert!((mean - power).abs() < 4.0 * error, "channel {channel}: {mean} ± {error} W of {power} W");
    }
}

#[test]
fn numbers_that_are_no_guide_are_refused() {
    let scene = scene();
    let refusal = |values: &[f32]| EmissionGuide::new(values, &scene.lights).map(|_| ()).expect_err("it is refused");
    let good = values(&nodes());
    for length in 0..good.len() {
        assert_eq!(refusal(&good[..length]), GuideError::Trees, "{length} numbers");
    }
    assert_eq!(refusal(&[1.0, 1.0, 1.0, 1.0]), GuideError::Trees);
    assert_eq!(refusal(&[0.0, 0.0, 0.0]), GuideError::Nowhere);
    for wrong in [-0.5, -5.0, f32::INFINITY] {
        assert_eq!(refusal(&[wrong, 1.0, 1.0]), GuideError::Node(wrong));
    }
    assert!(matches!(refusal(&[f32::NAN, 1.0, 1.0]), GuideError::Node(_)));
    assert_eq!(refusal(&[-1.0; 64]), GuideError::TooFine);
}
