//! `mmlt`: means of its chains against closed forms and references, and their bits; how numbers are mutated.

use crate::methods::{ERRORS, mean_and_error};
use crate::progressive::{Job, reference_folder, reference_scene};
use photonfarm::estimate::{PixelTally, RadiusField, Region, Shard, picture_files};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::transport::metropolis::mutation::{LARGEST_STEP, Source, moved};

/// A closed furnace has radiance 1, whichever paths its chains keep to; with mirrors and glass, too.
#[test]
fn furnaces_of_chains_have_radiance_one() {
    for name in ["furnace-closed", "furnace-specular"] {
        let (found, error) = mean_and_error(&reference_scene(name), "mmlt", "{}", 16, 4);
        println!("{name}: {found:.5} ± {error:.5}");
        assert!((found - 1.0).abs() < ERRORS * error, "{name}: {found} ± {error}");
        assert!(error < 0.01, "{name}: the test is blind");
    }
}

/// Means of references, with few chains that run long and with many that hardly move: neither has a start-up bias.
#[test]
fn means_of_chains_are_those_of_references() {
    for name in ["cornell-glass", "door-ajar"] {
        let scene = reference_scene(name);
        let reference = picture_files::read_exr(&reference_folder(name).join("ref.exr")).expect("it can be read");
        let sum: f64 = reference.radiance.iter().flatten().map(|value| f64::from(*value)).sum();
        let expected = sum / (3 * reference.radiance.len()) as f64;
        for parameters in [r#"{"chains": 4}"#, r#"{"chains": 4096}"#, r#"{"large_steps": 100}"#] {
            let (found, error) = mean_and_error(&scene, "mmlt", parameters, 16, 2);
            println!("{name} {parameters}: {found:.5} ± {error:.5} of {expected:.5}");
            assert!((found - expected).abs() < ERRORS * error, "{name} {parameters}: {found} ± {error}, {expected}");
            assert!(error < 0.06 * expected, "{name} {parameters}: the test is blind");
        }
    }
}

fn bits(pixels: &[PixelTally]) -> Vec<u32> {
    bytemuck::cast_slice(pixels).to_vec()
}

/// The same bits for any number of threads and regions.
#[test]
fn agreement_chains_of_threads_and_regions() {
    let scene = reference_scene("cornell-glass");
    let job = Job::new(&scene, "mmlt", r#"{"chains": 7}"#);
    let field = job.begin().estimate.radius_field(job.region());
    let trace = |region: Region, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let field = RadiusField { radius_squared: Vec::new(), ..field.clone() };
        let shard = Shard { first_pass: 3, passes: 2, region };
        pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels").pixels()
    };
    let whole = trace(job.region(), 1);
    assert!(bits(&whole) == bits(&trace(job.region(), 2)), "threads change the picture");
    let band = Region { row_start: 32, row_end: 64 };
    let pixels = 32 * scene.width as usize..64 * scene.width as usize;
    assert!(bits(&whole[pixels]) == bits(&trace(band, 2)), "regions change the picture");
}

/// Chains of small steps visit the parts of a space in proportion to a target, and would not if steps went to one side twice as often as back. Visits
/// are counted once in so many steps that they are nearly independent; χ² with 7 degrees of freedom is above 29.9 once in 10,000.
#[test]
fn chains_visit_a_space_in_proportion_to_their_target() {
    const PARTS: usize = 8;
    const TARGET: [f64; PARTS] = [1.0, 4.0, 2.0, 8.0, 1.0, 1.0, 5.0, 2.0];
    const APART: usize = 20_000;
    let part = |number: f32| (number * PARTS as f32) as usize;
    let chi_squared = |propose: &dyn Fn(f32, f32) -> f32| {
        let mut source = Source::new(PathRandom::new(6, Stream::Chain, 0, 0));
        let (mut number, mut visits) = (0.0f32, [0.0f64; PARTS]);
        let samples = 1000;
        for _ in 0..samples {
            for _ in 0..APART {
                let next = propose(number, source.number());
                if f64::from(source.number()) < TARGET[part(next)] / TARGET[part(number)] {
                    number = next;
                }
            }
            visits[part(number)] += 1.0;
        }
        let total: f64 = TARGET.iter().sum();
        let expected = |part: usize| f64::from(samples) * TARGET[part] / total;
        (0..PARTS).map(|part| (visits[part] - expected(part)).powi(2) / expected(part)).sum::<f64>()
    };
    let right = chi_squared(&|number, u| moved(number, u, LARGEST_STEP));
    let wrong = chi_squared(&|number, u| moved(number, u * u, LARGEST_STEP));
    println!("χ² {right:.1}, of a lopsided step {wrong:.1}");
    assert!(right < 29.9 && wrong > 60.0, "χ² {right}, of a lopsided step {wrong}");
}

/// A small step is as likely to lead back: over a space of eight parts, flows from each part to each other one are the same both ways. With 28 pairs and
/// about 10,000 flows a pair of neighbours, |z| is above 5 once in 60,000 runs.
#[test]
fn small_steps_lead_back_as_often() {
    const PARTS: usize = 8;
    let mut source = Source::new(PathRandom::new(5, Stream::Chain, 0, 0));
    let part = |number: f32| (number * PARTS as f32) as usize;
    let mut flows = [[0.0f64; PARTS]; PARTS];
    let mut visits = [0.0f64; PARTS];
    for _ in 0..4_000_000 {
        let number = source.number();
        let next = moved(number, source.number(), LARGEST_STEP);
        assert!((0.0..1.0).contains(&next), "{number} moved to {next}");
        flows[part(number)][part(next)] += 1.0;
        visits[part(next)] += 1.0;
    }
    for from in 0..PARTS {
        let z = (visits[from] - 500_000.0) / 500_000.0f64.sqrt();
        assert!(z.abs() < 5.0, "part {from} is visited {} times", visits[from]);
        for (to, there) in flows[from].iter().enumerate().take(from) {
            let back = flows[to][from];
            let z = (there - back) / (there + back).max(1.0).sqrt();
            assert!(z.abs() < 5.0, "{there} from {from} to {to}, {back} back");
        }
    }
    assert!(flows[0][PARTS - 1] > 1000.0, "steps do not go round the borders");
}
