//! The small scenes of `tests/mitsuba_scenes`, and how far pictures of them are from Mitsuba's.
//!
//! A picture is judged by the means of square blocks. The noise of a block is known on both sides: Mitsuba's standard errors are stored,
//! our own come from batches with seeds of their own. Differences are relative to the block, or to a tenth of the picture's mean where
//! the block is darker; where blocks are single pixels, which edges make dark and bright, to the mean itself.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photonfarm::estimate::Picture;
use photonfarm::evaluation::Run;
use photonfarm::farm::method_choice::{choice, without_passed_over};
use photonfarm::import::load_file;
use photonfarm::method;
use photonfarm::scene::Scene;

/// So many standard errors are noise.
const NOISE: f64 = 5.0;
/// Batches from which our own standard errors are estimated.
const BATCHES: u64 = 16;
/// Darker blocks count as bright as this share of the picture's mean.
const DARKEST: f64 = 0.1;
/// The largest difference beyond noise of a block of a scene that agrees.
pub(crate) const AGREES: f64 = 0.03;
/// The same for the mean of the picture.
pub(crate) const MEAN_AGREES: f64 = 0.01;

/// Mitsuba's `eval_discretized` shows it; with the exact weights its pictures would be ours.
const TABLE_OF_WEIGHTS: &str = "Mitsuba's scalar variants take a filter's weights from a table of 32 steps";

/// Scenes that differ, by how much at most, and why.
pub(crate) const KNOWN: &[(&str, f64, &str)] = &[
    (
        "bsdf-blendbsdf",
        0.3,
        "Mitsuba mixes the density 1 of a perfect mirror with densities by solid angle: black and a mirror at 0.3 show 0.172, not 0.3",
    ),
    ("film-catmullrom", 0.06, TABLE_OF_WEIGHTS),
    ("film-lanczos", 0.12, TABLE_OF_WEIGHTS),
    ("film-lanczos-lobes", 0.08, TABLE_OF_WEIGHTS),
    ("film-mitchell", 0.05, TABLE_OF_WEIGHTS),
    ("film-mitchell-b-c", 0.06, TABLE_OF_WEIGHTS),
    (
        "emitter-area-smooth-mesh",
        0.25,
        "Mitsuba's meshes with smooth normals shine where those face, not where their triangles do",
    ),
];

/// What Mitsuba makes of a scene: `NAME.json`.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Reference {
    pub(crate) mitsuba: String,
    pub(crate) variant: String,
    pub(crate) samples: u32,
    width: usize,
    height: usize,
    /// Side of a block, pixels.
    block: usize,
    means: Vec<[f64; 3]>,
    standard_errors: Vec<[f64; 3]>,
}

/// How far a picture is from Mitsuba's.
pub(crate) struct Judged {
    pub(crate) reference: Reference,
    /// Difference of the picture's mean over the mean.
    pub(crate) mean: f64,
    /// Standard error of that.
    pub(crate) mean_noise: f64,
    /// The largest difference of a block beyond noise, with its sign.
    pub(crate) worst: f64,
    /// Where that is: column and row of the block.
    pub(crate) place: [usize; 2],
    /// The largest standard error of a block.
    pub(crate) noise: f64,
    pub(crate) notices: Vec<String>,
}

impl Judged {
    /// Why the scene may differ; empty where it need not.
    pub(crate) fn reason(name: &str) -> &'static str {
        KNOWN.iter().find(|(known, ..)| *known == name).map_or("", |(_, _, reason)| reason)
    }

    /// Whether it differs no more than scenes do that agree, or than is known of the scene.
    pub(crate) fn holds(&self, name: &str) -> bool {
        let most = KNOWN.iter().find(|(known, ..)| *known == name).map_or(AGREES, |(_, most, _)| *most);
        let mean = most.min(if most > AGREES { 0.12 } else { MEAN_AGREES });
        self.worst.abs() <= most && self.mean.abs() <= mean + NOISE * self.mean_noise
    }
}

pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba_scenes")
}

/// The names of all scenes that start with `start`, sorted.
pub(crate) fn names(start: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder()).expect("the folder is there");
    let paths = entries.map(|entry| entry.expect("an entry can be read").path());
    let scenes = paths.filter(|path| path.extension().is_some_and(|extension| extension == "xml"));
    let stem = |path: PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut names: Vec<String> = scenes.map(stem).filter(|name| name.starts_with(start)).collect();
    names.sort();
    names
}

/// Renders a scene with about `passes` passes in all, by the method that its integrator asks for.
pub(crate) fn judge(name: &str, passes: u32) -> Result<Judged, Box<dyn Error>> {
    let reference = std::fs::read_to_string(folder().join(format!("{name}.json")))?;
    let reference: Reference = serde_json::from_str(&reference)?;
    let scene = Arc::new(Scene::prepare(&load_file(&folder().join(format!("{name}.xml")), &[])?)?);
    let integrator = scene.integrator.as_ref().map(|integrator| without_passed_over(integrator).0);
    let method = integrator.as_ref().map_or("path", |integrator| integrator.name.as_str());
    let choice = choice(method, &serde_json::Map::new(), integrator.as_ref());
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    // A block of one pixel needs as many samples as a larger one.
    let passes = if reference.block == 1 { 32 * passes } else { passes };
    let mut batches = Vec::new();
    for seed in 1..=BATCHES {
        let mut run = Run::start(&scene, &checked, seed)?;
        while run.passes() < passes.div_ceil(BATCHES as u32) {
            run.pass()?;
        }
        batches.push(block_means(&run.picture(), &reference)?);
    }
    Ok(compare(reference, &batches, scene.notices.clone()))
}

fn block_means(picture: &Picture, reference: &Reference) -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
    let (width, height, block) = (picture.width as usize, picture.height as usize, reference.block);
    if (width, height) != (reference.width, reference.height) {
        return Err(format!("{width} × {height} pixels instead of {} × {}", reference.width, reference.height).into());
    }
    let mut sums = vec![[0.0; 3]; reference.means.len()];
    for (index, pixel) in picture.radiance.iter().enumerate() {
        let (column, row) = (index % width, index / width);
        let sum: &mut [f64; 3] = &mut sums[row / block * (width / block) + column / block];
        (0..3).for_each(|channel| sum[channel] += f64::from(pixel[channel]) / (block * block) as f64);
    }
    Ok(sums)
}

/// Mean and standard error of numbers of which each is one batch.
fn mean_and_error(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn compare(reference: Reference, batches: &[Vec<[f64; 3]>], notices: Vec<String>) -> Judged {
    let blocks = reference.means.len();
    let numbers = (3 * blocks) as f64;
    let expected_mean = reference.means.iter().flatten().sum::<f64>() / numbers;
    let (found_mean, own_noise) =
        mean_and_error(batches.iter().map(|batch| batch.iter().flatten().sum::<f64>() / numbers));
    let their_noise =
        reference.standard_errors.iter().flatten().map(|error| error * error).sum::<f64>().sqrt() / numbers;
    let darkest = if reference.block == 1 { 1.0 } else { DARKEST };
    let (mut worst, mut place, mut noise) = (0.0_f64, 0, 0.0_f64);
    for index in 0..3 * blocks {
        let (block, channel) = (index / 3, index % 3);
        let (found, own) = mean_and_error(batches.iter().map(|batch| batch[block][channel]));
        let expected = reference.means[block][channel];
        let scale = expected.max(darkest * expected_mean);
        let error = own.hypot(reference.standard_errors[block][channel]) / scale;
        let difference = (found - expected) / scale;
        // Pictures are single precision, and stored numbers have five digits.
        let beyond = (difference.abs() - NOISE * error - 1e-4).max(0.0);
        noise = noise.max(error);
        if beyond > worst.abs() {
            (worst, place) = (beyond.copysign(difference), block);
        }
    }
    let columns = reference.width / reference.block;
    Judged {
        mean: found_mean / expected_mean - 1.0,
        mean_noise: own_noise.hypot(their_noise) / expected_mean,
        worst,
        place: [place % columns, place / columns],
        noise,
        notices,
        reference,
    }
}
