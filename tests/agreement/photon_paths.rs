//! `mps`: photons of whole paths bring what ordinary photons bring, and chains of both kinds have the same bits on any number of threads.

use crate::methods::{ERRORS, mean_and_error};
use crate::progressive::{Job, reference_scene};
use photonfarm::estimate::{PixelTally, RadiusField, Region, Shard};

/// Means are those of `photon_map` with the same look-ups, whose bias it shares: with matte surfaces alone, with caustics that the camera sees itself and
/// in a mirror, and with a lens.
#[test]
fn photons_of_whole_paths_bring_what_photons_bring() {
    for (name, parameters) in [
        ("cornell-diffuse", "{}"),
        ("cornell-glass", "{}"),
        ("cornell-glass", r#"{"ways": 1, "large_steps": 5}"#),
        ("furnace-closed", "{}"),
        ("dof", "{}"),
    ] {
        let scene = reference_scene(name);
        let (expected, expected_error) = mean_and_error(&scene, "photon_map", "{}", 4, 4);
        let (found, error) = mean_and_error(&scene, "mps", parameters, 4, 4);
        let together = error.hypot(expected_error);
        println!("{name} {parameters}: {found:.5} ± {error:.5}, {expected:.5} ± {expected_error:.5} of photon_map");
        assert!((found - expected).abs() < ERRORS * together, "{name} {parameters}: {found} ± {error}, {expected}");
        assert!(together < 0.02 * expected, "{name} {parameters}: the test is blind: {together}");
    }
}

fn bits(pixels: &[PixelTally]) -> Vec<u32> {
    bytemuck::cast_slice(pixels).to_vec()
}

/// The same bits for any number of threads and regions.
#[test]
fn agreement_whole_paths_of_threads_and_regions() {
    let scene = reference_scene("cornell-glass");
    let hints = r#"[{"points": [[0, 0.99, 0], [0.7, -1, -0.6]]}]"#;
    for (method, parameters) in [
        ("mlt", format!(r#"{{"chains": 7, "user_paths": {hints}}}"#)),
        ("mps", format!(r#"{{"chains": 7, "photons_per_pass": 5000, "user_paths": {hints}}}"#)),
    ] {
        let job = Job::new(&scene, method, &parameters);
        let field = job.begin().estimate.radius_field(job.region());
        let trace = |region: Region, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let field = RadiusField { radius_squared: Vec::new(), ..field.clone() };
            let shard = Shard { first_pass: 3, passes: 2, region };
            pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels").pixels()
        };
        let whole = trace(job.region(), 1);
        assert!(bits(&whole) == bits(&trace(job.region(), 2)), "{method}: threads change the picture");
        let band = Region { row_start: 32, row_end: 64 };
        let pixels = 32 * scene.width as usize..64 * scene.width as usize;
        assert!(bits(&whole[pixels]) == bits(&trace(band, 2)), "{method}: regions change the picture");
    }
}
