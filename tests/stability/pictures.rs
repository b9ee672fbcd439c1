//! Pieces of scenes, and what is measured in their pictures.

use std::ops::Range;
use std::sync::Arc;

use photonfarm::estimate::{Estimate, Picture};
use photonfarm::scene::Scene;

use crate::progressive::Job;
use crate::scene_text::prepare;

/// A camera at `origin` that looks at `target`, with `size` × `size` pixels that share nothing.
pub(crate) fn camera(origin: &str, target: &str, up: &str, fov: f64, size: u32) -> String {
    format!(
        "<sensor type='perspective'><float name='fov' value='{fov}'/>\
        <transform name='to_world'><lookat origin='{origin}' target='{target}' up='{up}'/></transform>\
        <film type='hdrfilm'><integer name='width' value='{size}'/><integer name='height' value='{size}'/>\
        <rfilter type='box'/></film></sensor>"
    )
}

/// A rectangle of the given half sides that faces from `center` towards `target`; its first side is across `up`.
pub(crate) fn sheet(center: &str, target: &str, up: &str, [across, along]: [f64; 2], parts: &str) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale x='{across}' y='{along}'/>\
        <lookat origin='{center}' target='{target}' up='{up}'/></transform>{parts}</shape>"
    )
}

/// A box around the origin with the given half sides, seen from inside.
pub(crate) fn room([x, y, z]: [f64; 3], parts: &str) -> String {
    format!(
        "<shape type='cube'><transform name='to_world'><scale x='{x}' y='{y}' z='{z}'/></transform>\
        <boolean name='flip_normals' value='true'/>{parts}</shape>"
    )
}

/// A grey matte material.
pub(crate) fn matte(albedo: f64) -> String {
    format!("<bsdf type='diffuse'><rgb name='reflectance' value='{albedo}, {albedo}, {albedo}'/></bsdf>")
}

/// A material on both sides.
pub(crate) fn two_sided(material: &str) -> String {
    format!("<bsdf type='twosided'>{material}</bsdf>")
}

/// A light on a shape, W·sr⁻¹·m⁻².
pub(crate) fn glow(radiance: f64) -> String {
    format!("<emitter type='area'><rgb name='radiance' value='{radiance}, {radiance}, {radiance}'/></emitter>")
}

/// A point light, W·sr⁻¹.
pub(crate) fn point_light(position: &str, intensity: f64) -> String {
    format!(
        "<emitter type='point'><point name='position' value='{position}'/>\
        <rgb name='intensity' value='{intensity}, {intensity}, {intensity}'/></emitter>"
    )
}

pub(crate) fn scene(parts: &[&str]) -> Arc<Scene> {
    Arc::new(prepare(&parts.concat(), &[]).expect("the scene is good"))
}

/// The seed of all pictures: 1, or what the sweep over seeds asks for (tools/stability_sweep.py).
fn seed() -> u64 {
    std::env::var("STABILITY_SEED").map_or(1, |seed| seed.parse().expect("STABILITY_SEED is a number"))
}

/// Renders; nothing may be other than finite.
pub(crate) fn estimate(scene: &Arc<Scene>, method: &str, parameters: &str, passes: u32) -> Estimate {
    let estimate = Job::with_seed(scene, method, parameters, seed()).run(passes, 8);
    assert_eq!(estimate.non_finite(), 0, "{method} {parameters}");
    estimate
}

pub(crate) fn picture(scene: &Arc<Scene>, method: &str, parameters: &str, passes: u32) -> Picture {
    let picture = estimate(scene, method, parameters, passes).picture();
    assert!(picture.radiance.iter().flatten().all(|value| value.is_finite() && *value >= 0.0), "{method} {parameters}");
    picture
}

/// The picture of one pass.
pub(crate) fn single_pass(scene: &Arc<Scene>, method: &str, parameters: &str, seed: u64) -> Picture {
    Job::with_seed(scene, method, parameters, seed).run(1, 1).picture()
}

/// Parameters of a method that names `photons` where it takes them.
pub(crate) fn with_photons(method: &str, photons: u32) -> String {
    match method {
        "path" | "bdpt" | "light_tracing" => "{}".to_owned(),
        _ => format!(r#"{{"photons_per_pass": {photons}}}"#),
    }
}

/// The pixels' means of channels, row by row.
pub(crate) fn grays(picture: &Picture) -> Vec<f64> {
    picture.radiance.iter().map(|color| color.iter().map(|value| f64::from(*value)).sum::<f64>() / 3.0).collect()
}

pub(crate) fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

pub(crate) fn mean(picture: &Picture) -> f64 {
    average(&grays(picture))
}

/// Mean over whole rows.
pub(crate) fn mean_of_rows(picture: &Picture, rows: Range<usize>) -> f64 {
    let width = picture.width as usize;
    average(&grays(picture)[rows.start * width..rows.end * width])
}

pub(crate) fn brightest(picture: &Picture) -> f64 {
    grays(picture).into_iter().fold(0.0, f64::max)
}

/// Root of the mean squared relative difference from `truth` per pixel.
pub(crate) fn relative_error(picture: &Picture, truth: impl Fn(usize) -> f64) -> f64 {
    let errors = grays(picture).into_iter().enumerate().map(|(pixel, value)| (value / truth(pixel) - 1.0).powi(2));
    average(&errors.collect::<Vec<_>>()).sqrt()
}

/// Asserts that `value` is `expected` but for the share `tolerance`, and prints how much it is off.
pub(crate) fn assert_close(value: f64, expected: f64, tolerance: f64, what: &str) {
    let off = value / expected - 1.0;
    println!("{what}: {value:.5} of {expected:.5}, off by {:+.3} %", 100.0 * off);
    assert!(off.abs() < tolerance, "{what}: {value} where {expected} is right, off by {:+.3} %", 100.0 * off);
}

/// Asserts that a picture's mean is `expected` but for four standard errors, as its pixels tell them, which share nothing; the
/// relative noise of a pixel must be below `noisiest`. One in 16 000 such tests fails by chance.
pub(crate) fn assert_unbiased(seen: &Picture, expected: f64, noisiest: f64, what: &str) {
    let values = grays(seen);
    let (count, mean) = (values.len() as f64, average(&values));
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let noise = variance.sqrt() / expected;
    assert_below(noise, noisiest, &format!("{what}: noise of a pixel"));
    assert_close(mean, expected, 4.0 * noise / count.sqrt() + 1e-5, what);
}

/// Asserts that `value` is below `bound`, and prints it.
pub(crate) fn assert_below(value: f64, bound: f64, what: &str) {
    println!("{what}: {value:.3e}, bound {bound:.3e}");
    assert!(value < bound, "{what}: {value:.4e} is not below {bound:.4e}");
}
