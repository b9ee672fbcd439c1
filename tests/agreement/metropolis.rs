//! `mmlt`: means of its chains against closed forms and references, and their bits; how numbers are mutated.

use crate::methods::{ERRORS, mean_and_error};
use crate::progressive;

use photonfarm::estimate::{PixelTally, RadiusField, Region, Shard, picture_files};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::transport::metropolis::mutation::{Source, moved};
use progressive::{Job, reference_folder, reference_scene};

/// A closed furnace has radiance 1, whichever paths its chains keep to; with mirrors and glass, too.
#[test]
fn furnaces_of_chains_have_radiance_one() {
    for name in ["furnace-closed", "furnace-specular"] {
        let (found, error) = mean_and_error(&reference_scene(name), "mmlt", "{}", 16, 4);
        println!("{name}: {found:.5} ± {error:.5}");
        assert!((found - 1.0).abs() < ERRORS * error, "{name}: {found} ± {error}");
        assert!(error < 0.008, "{name}: the test is blind");
    }
}

/// Means of references, with few chains that run long and with many that hardly move: neither has a start-up bias.
#[test]
fn means_of_chains_are_those_of_references() {
    for name in ["cornell-glass", "door-ajar", "lantern"] {
        let scene = reference_scene(name);
        let reference = picture_files::read_exr(&reference_folder(name).join("ref.exr")).expect("it can be read");
        let sum: f64 = reference.radiance.iter().flatten().map(|value| f64::from(*value)).sum();
        let expected = sum / (3 * reference.radiance.len()) as f64;
        for parameters in [r#"{"chains": 4}"#, r#"{"chains": 4096}"#, r#"{"large_steps": 100}"#] {
            let (found, error) = mean_and_error(&scene, "mmlt", parameters, 16, 4);
            println!("{name} {parameters}: {found:.5} ± {error:.5} of {expected:.5}");
            assert!((found - expected).abs() < ERRORS * error, "{name} {parameters}: {found} ± {error}, {expected}");
            assert!(error < 0.03 * expected, "{name} {parameters}: the test is blind");
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
        let number = source.next();
        let next = moved(number, source.next());
        assert!((0.0..1.0).contains(&next), "{number} moved to {next}");
        flows[part(number)][part(next)] += 1.0;
        visits[part(next)] += 1.0;
    }
    for from in 0..PARTS {
        let z = (visits[from] - 500_000.0) / 500_000.0f64.sqrt();
        assert!(z.abs() < 5.0, "part {from} is visited {} times", visits[from]);
        for to in 0..from {
            let [there, back] = [flows[from][to], flows[to][from]];
            let z = (there - back) / (there + back).max(1.0).sqrt();
            assert!(z.abs() < 5.0, "{there} from {from} to {to}, {back} back");
        }
    }
    assert!(flows[0][PARTS - 1] > 1000.0, "steps do not go round the borders");
}
