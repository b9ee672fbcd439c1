//! Figure 3 of the paper: what user paths do to the noise of Metropolis light transport, where they lead and elsewhere.

use std::error::Error;

use photonfarm::estimate::Picture;
use photonfarm::math::{Vec2, Vec3};
use serde_json::{Value, json};

use crate::contenders::{Contender, Subject, acceptance, save};

/// Pixels on each side.
const SIZE: u32 = 96;
/// Pictures whose errors are averaged.
const SEEDS: u64 = 4;
/// Processor-seconds of the reference.
const REFERENCE: f64 = 120.0;
/// Where user paths lead is within this share of the picture's width of the end of one.
const NEAR: f32 = 0.08;

/// Prints the errors with and without user paths, of `seconds` each, and saves pictures.
pub(crate) fn print(name: &'static str, seconds: f64) -> Result<(), Box<dyn Error>> {
    let subject = Subject::load(name, SIZE)?;
    let (reference, _) = subject.traced(&Contender::plain("bdpt"), 7, REFERENCE)?;
    let noise = reference.error().map_or(0.0, |error| error.noise);
    let reference = reference.picture();
    let is_near = near_ends(&subject);
    let share = 100.0 * is_near.iter().filter(|near| **near).count() as f64 / is_near.len() as f64;
    println!("| {name}, `mlt` | relMSE where user paths lead ({share:.0} % of the picture) | elsewhere | accepted |");
    println!("|---|---:|---:|---|");
    let guided = |share: u32| Contender::with("mlt", vec![("user_path", json!(share))]).hinted();
    for (label, contender) in [
        ("without user paths".to_owned(), Contender::plain("mlt")),
        ("user paths, 10 parts".to_owned(), guided(10)),
        ("user paths, 40 parts".to_owned(), guided(40)),
    ] {
        let (mut sums, mut accepted) = ([0.0f64; 2], String::new());
        for seed in 1..=SEEDS {
            let (run, _) = subject.traced(&contender, seed, seconds)?;
            let errors = errors(&run.picture(), &reference, &is_near);
            sums = [sums[0] + errors[0], sums[1] + errors[1]];
            accepted = acceptance(&run);
            save(&contender.file(name, "figure-3-"), &run.picture())?;
        }
        let [near, far] = sums.map(|sum| sum / SEEDS as f64 - noise);
        println!("| {label} | {near:.3} | {far:.3} | {accepted} |");
    }
    println!(
        "\n![without](metropolis/{name}-figure-3-mlt.png)\n![with](metropolis/{name}-figure-3-mlt-user-paths.png)"
    );
    Ok(())
}

/// Which pixels are near where user paths end.
fn near_ends(subject: &Subject) -> Vec<bool> {
    let scene = &subject.scene;
    let ends = |path: &Value| {
        let last = path["points"].as_array()?.last()?.as_array()?;
        let [x, y, z] = [0, 1, 2].map(|axis| last.get(axis).and_then(Value::as_f64).unwrap_or(f64::NAN) as f32);
        Some(scene.camera.look_at(Vec3::new(x, y, z), [0.5; 2])?.film)
    };
    let paths = subject.hints.iter().filter_map(Value::as_array).flatten();
    let ends: Vec<Vec2> = paths.filter_map(ends).collect();
    let pixel = |index: usize| {
        let index = index as u32;
        Vec2::new((index % scene.width) as f32 + 0.5, (index / scene.width) as f32 + 0.5)
            / Vec2::new(scene.width as f32, scene.height as f32)
    };
    (0..scene.pixel_count()).map(|index| ends.iter().any(|end| end.distance(pixel(index)) < NEAR)).collect()
}

/// relMSE of the pixels near, and of the others.
fn errors(picture: &Picture, reference: &Picture, is_near: &[bool]) -> [f64; 2] {
    let mean = |pixel: &[f32; 3]| pixel.iter().map(|value| f64::from(*value)).sum::<f64>() / 3.0;
    let whole = reference.radiance.iter().map(mean).sum::<f64>() / reference.radiance.len() as f64;
    let error = |index: usize| {
        let (found, right) = (&picture.radiance[index], &reference.radiance[index]);
        let square: f64 = (0..3).map(|channel| f64::from(found[channel] - right[channel]).powi(2)).sum::<f64>() / 3.0;
        square / (mean(right).powi(2) + 1e-3 * whole * whole)
    };
    [true, false].map(|near| {
        let pixels: Vec<usize> = (0..is_near.len()).filter(|index| is_near[*index] == near).collect();
        pixels.iter().map(|index| error(*index)).sum::<f64>() / pixels.len().max(1) as f64
    })
}
