//! Pictures in batches: means with their errors, and noise.

use std::path::Path;
use std::sync::Arc;

use photonfarm::estimate::{Picture, Shard};
use photonfarm::import::load_file;
use photonfarm::scene::Scene;

use crate::progressive::{Begun, Job};

/// With 16 batches, 4.5 standard errors are passed by chance once in 2,000 times; seeds are fixed.
pub(crate) const ERRORS: f64 = 4.5;
const BATCHES: u32 = 16;

pub(crate) fn repository_scene(path: &str, size: &str) -> Arc<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(path);
    let description = load_file(&path, &[("size".to_owned(), size.to_owned())]).expect("a scene of the repository");
    Arc::new(Scene::prepare(&description).expect("a scene of the repository is good"))
}

fn mean(picture: &Picture) -> f64 {
    picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>() / (3 * picture.radiance.len()) as f64
}

/// The mean over pixels of the relative variance of pictures.
fn relative_variance(pictures: &[Picture]) -> f64 {
    let count = pictures.len() as f64;
    let pixels = pictures[0].radiance.len();
    let values = |pixel: usize| pictures.iter().map(move |picture| f64::from(picture.radiance[pixel][1]));
    let means: Vec<f64> = (0..pixels).map(|pixel| values(pixel).sum::<f64>() / count).collect();
    let dark = 1e-3 * (means.iter().sum::<f64>() / pixels as f64).powi(2);
    let of_pixel = |pixel: usize| {
        let squares: f64 = values(pixel).map(|value| (value - means[pixel]).powi(2)).sum();
        squares / (count - 1.0) / (means[pixel].powi(2) + dark)
    };
    (0..pixels).map(of_pixel).sum::<f64>() / pixels as f64
}

/// Mean of a picture and its standard error, from batches of passes with the first radii; and the mean relative variance of its pixels.
pub(crate) fn mean_and_error(scene: &Arc<Scene>, method: &str, parameters: &str, passes: u32) -> [f64; 3] {
    let job = Job::new(scene, method, parameters);
    let Begun { estimate: start, renderer } = job.begin();
    let field = start.radius_field(job.region());
    let pictures: Vec<Picture> = (0..BATCHES)
        .map(|batch| {
            let mut estimate = start.clone();
            for pass in 0..passes {
                let shard = Shard { first_pass: batch * passes + pass, passes: 1, region: job.region() };
                let mut tally = renderer.trace(shard, &field, &job.never).expect("nobody cancels");
                tally.shard.first_pass = pass;
                estimate.merge(&tally, &field).expect("tallies come in order");
            }
            estimate.picture()
        })
        .collect();
    let means: Vec<f64> = pictures.iter().map(mean).collect();
    let count = f64::from(BATCHES);
    let average = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|mean| (mean - average).powi(2)).sum::<f64>() / (count - 1.0);
    [average, (variance / count).sqrt(), relative_variance(&pictures)]
}

pub(crate) fn assert_same(
    [found, error, noise]: [f64; 3],
    [expected, of_expected, other]: [f64; 3],
    bias: f64,
    what: &str,
) {
    println!("{what}: {found:.6} ± {error:.6}, {expected:.6} ± {of_expected:.6}; noise {noise:.4}, {other:.4}");
    let both = (error * error + of_expected * of_expected).sqrt();
    assert!((found - expected).abs() < ERRORS * both + bias * expected, "{what}: {found} ± {error}, not {expected}");
}

/// The bits of a picture from one, two and three threads.
pub(crate) fn bits_of_threads(scene: &Arc<Scene>, method: &str, parameters: &str) -> Vec<Vec<u32>> {
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let picture = pool.install(|| Job::new(scene, method, parameters).run(4, 2).picture());
        picture.radiance.iter().flatten().map(|value| value.to_bits()).collect()
    };
    (1..=3).map(of_threads).collect()
}
