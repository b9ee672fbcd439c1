//! Makes the table of `docs/measured/MITSUBA-TESTS.md`: Mitsuba 3's own render tests, judged by Mitsuba's own rule.
//!
//! `cargo run --release --example mitsuba_tests -- ../shared/mitsuba-tests 256 path` renders every test with 256 passes of `path`,
//! limited as its integrator says; it takes about 10 minutes of processor time. The rule: z = (mean − reference)·√(passes/variance) per pixel and channel, two-sided, at a
//! significance of 0.01 that is corrected for the number of pixels (Šidák); a test passes when 99.75 % of the values do. Methods
//! whose pixels are correlated are judged by the means of 8 × 8 blocks and the standard error of four jobs instead.
//!
//! The variances of the references are estimates, up to 40 % of which are negative in a picture, so that Mitsuba itself fails many of
//! its tests by this rule. `own_shares.json` holds what it gets (`tools/mitsuba_own_shares.py`); whoever gets as much is as right as it is.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::read_exr;
use photonfarm::evaluation::Run;
use photonfarm::farm::method_choice::{choice, without_passed_over};
use photonfarm::import::load_file;
use photonfarm::method;
use photonfarm::scene::Scene;

/// The variance that Mitsuba takes at least.
const LEAST_VARIANCE: f64 = 1e-4;
/// The share of values that must pass.
const SHARE: f64 = 0.9975;
const SIGNIFICANCE: f64 = 0.01;
/// By so many standard errors a share may be below Mitsuba's own by chance.
const ERRORS: f64 = 3.0;
/// Side of the blocks in which methods with correlated pixels are judged, pixels.
const BLOCK: usize = 8;
/// Photons of a pass: the pictures are small.
const PHOTONS: u32 = 1 << 15;
/// Jobs of other seeds that tell the noise of such methods.
const JOBS: u64 = 4;

/// What Mitsuba gets by the rule, in percent by the name of the test.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct OwnShares {
    mitsuba: String,
    samples: u32,
    shares: BTreeMap<String, f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, passes, name] = arguments.as_slice() else {
        return Err("usage: mitsuba_tests FOLDER PASSES METHOD".into());
    };
    let passes: u32 = passes.parse()?;
    let own: OwnShares = serde_json::from_str(include_str!("own_shares.json"))?;
    println!("Mitsuba {} has {} samples, {name} {passes} passes.\n", own.mitsuba, own.samples);
    println!(
        "| test | {name} | mean | of reference | values that pass | of Mitsuba's | |\n|---|---|---:|---:|---:|---:|---|"
    );
    let mut counts = BTreeMap::<&str, u32>::new();
    let tests = tests(&Path::new(folder).join("tests/scenes"))?;
    for test in &tests {
        let label = test.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let share = own.shares.get(&label).copied();
        let shown = share.map_or("–".to_owned(), |share| format!("{share:.2} %"));
        let verdict = match run(test, name, passes) {
            Ok(judged) => {
                // Blocks of pixels have a rule of their own.
                let own = share.filter(|_| name == "path").map(|share| share / 100.0);
                let own = own.map(|own| own - ERRORS * (2.0 * own * (1.0 - own) / judged.values as f64).sqrt());
                let verdict = match judged.share {
                    share if share >= SHARE => "passes",
                    share if own.is_some_and(|own| share >= own) => "as Mitsuba",
                    _ => "differs",
                };
                let Judged { share, mean, expected, notices, .. } = judged;
                println!(
                    "| {label} | {verdict} | {mean:.5} | {expected:.5} | {:.2} % | {shown} | {notices} |",
                    100.0 * share
                );
                verdict
            }
            Err(error) => {
                println!("| {label} | not loaded | | | | {shown} | {error} |");
                "not loaded"
            }
        };
        *counts.entry(verdict).or_default() += 1;
    }
    let counts: Vec<String> = counts.iter().map(|(verdict, count)| format!("{count} {verdict}")).collect();
    println!("\n{} tests: {}.", tests.len(), counts.join(", "));
    Ok(())
}

/// The scene files of all tests, by name.
fn tests(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut found = Vec::new();
    for group in std::fs::read_dir(folder)? {
        let group = group?.path();
        if !group.is_dir() {
            continue;
        }
        for file in std::fs::read_dir(group)? {
            let file = file?.path();
            if file.extension().is_some_and(|extension| extension == "xml") {
                found.push(file);
            }
        }
    }
    found.sort();
    Ok(found)
}

struct Judged {
    /// The share of values that pass.
    share: f64,
    /// How many there are.
    values: usize,
    mean: f64,
    expected: f64,
    notices: String,
}

fn run(test: &Path, name: &str, passes: u32) -> Result<Judged, Box<dyn Error>> {
    let stem = test.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let stem = stem.rsplit_once('_').map_or(stem.as_str(), |(stem, _)| stem);
    let picture = |suffix: &str| {
        let file = test.parent().unwrap_or(Path::new("")).join("refs").join(format!("{stem}_ref_rgb{suffix}.exr"));
        read_exr(&file)
    };
    let (reference, variance) = (picture("")?, picture("_var")?);
    let scene = Arc::new(Scene::prepare(&load_file(test, &[])?)?);
    let integrator = scene.integrator.as_ref().map(|integrator| without_passed_over(integrator).0);
    let mut parameters = serde_json::Map::new();
    if method::entry(name)?.parameters.iter().any(|parameter| parameter.name == "photons_per_pass") {
        parameters.insert("photons_per_pass".to_owned(), PHOTONS.into());
    }
    let choice = choice(name, &parameters, integrator.as_ref());
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    let render = |seed: u64, passes: u32| -> Result<Picture, Box<dyn Error>> {
        let mut run = Run::start(&scene, &checked, seed)?;
        while run.passes() < passes {
            run.pass()?;
        }
        Ok(run.picture())
    };
    let (found, share) = if name == "path" {
        let found = render(1, passes)?;
        let share = share_of_pixels(&found, &reference, &variance, passes);
        (found, share)
    } else {
        let jobs = (1..=JOBS).map(|seed| render(seed, passes / JOBS as u32)).collect::<Result<Vec<_>, _>>()?;
        mean_and_share_of_blocks(&jobs, &reference)
    };
    let mean = |picture: &Picture| {
        let values = picture.radiance.iter().flatten().map(|value| f64::from(*value));
        values.sum::<f64>() / (3 * picture.radiance.len()) as f64
    };
    let notices = scene.notices.iter().filter(|notice| !notice.contains("\"moment\"")).cloned();
    let notices = notices.collect::<Vec<_>>().join("; ");
    let values = 3 * found.radiance.len();
    Ok(Judged { share, values, mean: mean(&found), expected: mean(&reference), notices })
}

/// The largest |z| that passes.
fn largest_z(tests: usize) -> f64 {
    let tail = 0.5 * (1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / tests as f64));
    // The upper tail of the normal distribution falls with z.
    let (mut low, mut high) = (0.0, 20.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if 0.5 * libm::erfc(middle / std::f64::consts::SQRT_2) > tail { low = middle } else { high = middle }
    }
    low
}

fn share_of_pixels(found: &Picture, reference: &Picture, variance: &Picture, passes: u32) -> f64 {
    let most = largest_z(found.radiance.len());
    let values = found.radiance.iter().zip(&reference.radiance).zip(&variance.radiance);
    let passing = values.flat_map(|((found, reference), variance)| {
        (0..3).map(move |channel| {
            let variance = f64::from(variance[channel]).max(LEAST_VARIANCE);
            let difference = f64::from(found[channel]) - f64::from(reference[channel]);
            (difference * (f64::from(passes) / variance).sqrt()).abs() <= most
        })
    });
    passing.filter(|passes| *passes).count() as f64 / (3 * found.radiance.len()) as f64
}

/// The mean picture of several jobs, and the share of blocks whose mean differs from the reference's by no more than 3 % of it and five
/// standard errors of the jobs' means.
fn mean_and_share_of_blocks(jobs: &[Picture], reference: &Picture) -> (Picture, f64) {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let of_block = |picture: &Picture, top: usize, left: usize| {
        let rows = top..(top + BLOCK).min(height);
        let pixels = rows.flat_map(|row| (left..(left + BLOCK).min(width)).map(move |column| row * width + column));
        let values: Vec<f64> = pixels.flat_map(|pixel| picture.radiance[pixel]).map(f64::from).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let (mut all, mut passing) = (0, 0);
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let means: Vec<f64> = jobs.iter().map(|job| of_block(job, top, left)).collect();
            let (count, expected) = (means.len() as f64, of_block(reference, top, left));
            let mean = means.iter().sum::<f64>() / count;
            let squares: f64 = means.iter().map(|value| (value - mean).powi(2)).sum();
            let noise = (squares / (count * (count - 1.0))).sqrt();
            all += 1;
            passing += u32::from((mean - expected).abs() <= 0.03 * expected.abs() + 5.0 * noise);
        }
    }
    let pixel = |index: usize| {
        [0, 1, 2].map(|channel| jobs.iter().map(|job| job.radiance[index][channel]).sum::<f32>() / jobs.len() as f32)
    };
    let radiance = (0..width * height).map(pixel).collect();
    (Picture { radiance, width: reference.width, height: reference.height }, f64::from(passing) / f64::from(all))
}
