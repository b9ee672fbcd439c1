//! `photon_map`'s ways of finding direct light: those without bias agree with closed forms and with `path`, those with bias are off where and as
//! much as they say, and none changes with threads or regions.

use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::Arc;

use crate::progressive::{Job, reference_scene};
use crate::scene_text::prepare;
use photonfarm::estimate::{Estimate, PixelTally, RadiusField, Region, Shard};
use photonfarm::method::{MethodChoice, check};
use photonfarm::scene::Scene;

/// Every way, with samples where it takes some.
const WAYS: [&str; 5] = [
    r#""direct": "sample", "direct_samples": 3"#,
    r#""direct": "photons""#,
    r#""direct": "shadow_photons", "direct_samples": 2"#,
    r#""direct": "photon_direct", "direct_samples": 2"#,
    r#""direct": "photon_direct", "direct_reuse": 0"#,
];

/// Mean of the channels over all pixels.
fn mean(estimate: &Estimate) -> f64 {
    let picture = estimate.picture();
    picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>() / (3 * picture.radiance.len()) as f64
}

fn scene(body: &str) -> Arc<Scene> {
    Arc::new(prepare(body, &[]).expect("the scene is good"))
}

/// A camera with a square picture.
fn sensor(size: u32, fov: &str, look_at: &str) -> String {
    format!(
        "<sensor type='perspective'><float name='fov' value='{fov}'/><transform name='to_world'><lookat {look_at}/></transform>\
        <film type='hdrfilm'><integer name='width' value='{size}'/><integer name='height' value='{size}'/>\
        <rfilter type='box'/></film></sensor>"
    )
}

/// In a matte sphere of albedo ρ with a point light of intensity I in its middle, direct light has radiance ρI/(πR²) everywhere.
#[test]
fn analytic_direct_light_in_a_sphere() {
    let body = sensor(32, "80", "origin='0, 0, 0.5' target='0, 0.2, -1' up='0, 1, 0'")
        + "<shape type='sphere'><float name='radius' value='2'/><boolean name='flip_normals' value='true'/>\
        <bsdf type='diffuse'><rgb name='reflectance' value='0.6, 0.6, 0.6'/></bsdf></shape>\
        <emitter type='point'><rgb name='intensity' value='5, 5, 5'/></emitter>";
    let scene = scene(&body);
    let expected = 0.6 * 5.0 / (PI * 4.0);
    for way in WAYS {
        let parameters = format!(r#"{{"photons_per_pass": 50000, "max_depth": 2, {way}}}"#);
        let found = mean(&Job::new(&scene, "photon_map", &parameters).run(8, 8));
        // Samples of a point are exact; nearest photons were 0.1 % off.
        let bound = if way.contains("photons\"") && !way.contains("shadow") { 0.005 } else { 1e-4 };
        assert!((found - expected).abs() < bound * expected, "{way}: {found} is not {expected}");
    }
}

/// Whole pictures have the mean of those by one light sample. At narrow lobes the path that goes on finds lights too: nothing is lost or counted twice.
#[test]
fn agreement_photon_map_of_all_ways_to_direct_light() {
    for (name, bound) in [("cornell-diffuse", 0.006), ("glossy-blocks-a010", 0.006), ("cornell-glass", 0.006)] {
        let scene = reference_scene(name);
        let run = |way: &str| {
            let parameters = format!(r#"{{"photons_per_pass": 65536, "final_gather": 1, {way}}}"#);
            mean(&Job::new(&scene, "photon_map", &parameters).run(8, 8))
        };
        let expected = run(r#""direct": "sample""#);
        for way in WAYS {
            let ratio = run(way) / expected;
            // What photons estimate is dark at edges.
            let bound = if way.contains("\"photons\"") { 0.02 } else { bound };
            println!("{name}, {way}: {ratio}");
            assert!((ratio - 1.0).abs() < bound, "{name}, {way}: {ratio}");
        }
    }
}

/// Five by five lamps under a ceiling with walls between some of them, so that photons of few lamps come to a point, and a few photons a pass.
fn lamps() -> Arc<Scene> {
    let mut body = sensor(32, "50", "origin='0, 4, 12' target='0, 0.5, 0' up='0, 1, 0'");
    body += "<bsdf type='twosided' id='white'><bsdf type='diffuse'><rgb name='reflectance' value='0.7, 0.6, 0.5'/></bsdf></bsdf>\
        <shape type='rectangle'><transform name='to_world'><scale value='6'/><rotate x='1' angle='-90'/></transform><ref id='white'/></shape>";
    for wall in [-3.0, -1.0, 1.0, 3.0] {
        write!(
            body,
            "<shape type='cube'><transform name='to_world'><scale x='0.05' y='0.6' z='4'/><translate x='{wall}' y='0.6' z='-1'/></transform>\
            <ref id='white'/></shape>"
        )
        .expect("a string takes it");
    }
    for lamp in 0..25u32 {
        let (x, z) = (2.0 * f64::from(lamp % 5) - 4.0, 2.0 * f64::from(lamp / 5) - 4.0);
        // One is as near to the floor as it is wide, where material samples count.
        let y = if lamp == 12 { 0.3 } else { 1.5 };
        write!(
            body,
            "<shape type='rectangle'><transform name='to_world'><scale value='0.3'/><rotate x='1' angle='90'/>\
            <translate x='{x}' y='{y}' z='{z}'/></transform><ref id='white'/><emitter type='area'>\
            <rgb name='radiance' value='{}, 3, 2'/></emitter></shape>",
            1 + lamp % 4
        )
        .expect("a string takes it");
    }
    scene(&body)
}

const BLOCK: usize = 8;

/// Means of blocks of 8 × 8 pixels.
fn blocks(scene: &Arc<Scene>, method: &str, parameters: &str, seed: u64, passes: u32) -> Vec<f64> {
    let picture = Job::with_seed(scene, method, parameters, seed).run(passes, 64).picture();
    let side = picture.width as usize / BLOCK;
    let mut sums = vec![0.0; side * side];
    for (pixel, radiance) in picture.radiance.iter().enumerate() {
        let (x, y) = (pixel % picture.width as usize, pixel / picture.width as usize);
        let value: f64 = radiance.iter().map(|channel| f64::from(*channel)).sum();
        sums[y / BLOCK * side + x / BLOCK] += value / (3 * BLOCK * BLOCK) as f64;
    }
    sums
}

/// With 25 lamps and 40 photons a pass the photons' guesses are mostly wrong, which costs noise and nothing else: block by block the mean is that of
/// `path`, within 4.5 standard errors of 24 independent pictures (for 16 blocks and four ways together about one false alarm in 200).
#[test]
fn agreement_photon_map_photon_direct_without_bias() {
    const SEEDS: u64 = 24;
    let scene = lamps();
    let truth = |seed: u64| blocks(&scene, "path", r#"{"max_depth": 2, "light_picks": "importance"}"#, seed, 64);
    let truths: Vec<Vec<f64>> = (0..SEEDS).map(|seed| truth(1000 + seed)).collect();
    for way in [
        r#""largest_radius": 20, "photons_per_pass": 40, "direct_reuse": 0"#,
        r#""largest_radius": 20, "photons_per_pass": 40, "direct_reuse": 1, "direct_samples": 3"#,
        r#""largest_radius": 20, "photons_per_pass": 1"#,
        r#""photons_per_pass": 4000, "direct_neighbors": 5, "direct_samples": 7"#,
    ] {
        let parameters = format!(
            r#"{{"direct": "photon_direct", "max_depth": 2, "final_gather": 0, "emission": "power", "light_picks": "importance", {way}}}"#
        );
        let found: Vec<Vec<f64>> = (0..SEEDS).map(|seed| blocks(&scene, "photon_map", &parameters, seed, 32)).collect();
        for block in 0..truths[0].len() {
            let [a, b] = [&found, &truths].map(|pictures| statistics(pictures, block));
            let error = (a.squared_error + b.squared_error).sqrt();
            println!("{way}, block {block}: {} is {} ± {error}", a.mean, b.mean);
            assert!(
                (a.mean - b.mean).abs() <= 4.5 * error,
                "{way}, block {block}: {} is not {} ± {error}",
                a.mean,
                b.mean
            );
            // Of what a lost tenth of the light would be.
            assert!(
                b.mean < 0.01 || error < 0.03 * b.mean,
                "{way}, block {block}: the test is blind, {error} of {}",
                b.mean
            );
        }
    }
}

struct Statistics {
    mean: f64,
    squared_error: f64,
}

/// Of one block over independent pictures.
fn statistics(pictures: &[Vec<f64>], block: usize) -> Statistics {
    let count = pictures.len() as f64;
    let mean = pictures.iter().map(|picture| picture[block]).sum::<f64>() / count;
    let squares = pictures.iter().map(|picture| (picture[block] - mean).powi(2)).sum::<f64>();
    Statistics { mean, squared_error: squares / (count * (count - 1.0)) }
}

/// A ball of this radius between a lamp and the floor, and the middle of its shadow filling the picture.
fn shadow_of(radius: f64) -> Arc<Scene> {
    let body = sensor(8, "0.5", "origin='1, 0.4, 0' target='0, 0, 0' up='0, 1, 0'")
        + "<shape type='rectangle'><transform name='to_world'><scale value='3'/><rotate x='1' angle='-90'/></transform>\
        <bsdf type='diffuse'><rgb name='reflectance' value='0.5, 0.5, 0.5'/></bsdf></shape>\
        <emitter type='point'><point name='position' x='0' y='2' z='0'/><rgb name='intensity' value='4, 4, 4'/></emitter>"
        + &format!(
            "<shape type='sphere'><point name='center' x='0' y='1' z='0'/><float name='radius' value='{radius}'/></shape>"
        );
    scene(&body)
}

/// The bias of shadow photons: an object that every photon missed throws no shadow. One that they hit does, and where they disagree shadow rays
/// tell.
#[test]
fn photon_map_shadow_photons_miss_small_objects() {
    let run = |scene: &Arc<Scene>, way: &str| {
        let parameters = format!(
            r#"{{"max_depth": 2, "final_gather": 0, "emission": "power", "photons_per_pass": 3000, "largest_radius": 0.5, {way}}}"#
        );
        mean(&Job::new(scene, "photon_map", &parameters).run(1, 8))
    };
    // ρ/π·I/h², seen from anywhere.
    let lit = 0.5 / PI * 4.0 / 4.0;
    let small = shadow_of(0.008);
    assert_eq!(run(&small, r#""direct": "sample""#), 0.0, "a ball of 8 mm throws a shadow");
    let missed = run(&small, r#""direct": "shadow_photons""#);
    assert!((missed - lit).abs() < 0.001 * lit, "every photon missed the ball, and yet there is {missed} of {lit}");
    let larger = shadow_of(0.5);
    assert_eq!(run(&larger, r#""direct": "shadow_photons""#), 0.0, "a ball of 0.5 m throws a shadow");
    let between = shadow_of(0.1);
    assert_eq!(run(&between, r#""direct": "shadow_photons""#), 0.0, "with both kinds near, a shadow ray tells");
}

fn bits(pixels: &[PixelTally]) -> Vec<u32> {
    bytemuck::cast_slice(pixels).to_vec()
}

#[test]
fn agreement_photon_map_direct_of_threads_and_regions() {
    let scene = reference_scene("cornell-glass");
    for way in WAYS {
        let job = Job::new(&scene, "photon_map", &format!(r#"{{"photons_per_pass": 8192, {way}}}"#));
        let field = job.begin().estimate.radius_field(job.region());
        let trace = |region: Region, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let radius_squared = vec![1.0; region.pixel_count(scene.width)];
            let field = RadiusField { radius_squared, ..field.clone() };
            let shard = Shard { first_pass: 3, passes: 2, region };
            pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels")
        };
        let whole = trace(job.region(), 1);
        assert!(bits(&whole.pixels()) == bits(&trace(job.region(), 2).pixels()), "{way}: threads change the picture");
        let band = Region { row_start: 32, row_end: 64 };
        let pixels = 32 * scene.width as usize..64 * scene.width as usize;
        assert!(bits(&whole.pixels()[pixels]) == bits(&trace(band, 2).pixels()), "{way}: regions change the picture");
    }
}

/// Both structures find the same direct photons, whose sums differ by rounding alone.
#[test]
fn agreement_photon_map_direct_in_a_grid_and_in_a_kd_tree() {
    let scene = reference_scene("cornell-diffuse");
    for way in [WAYS[1], WAYS[2]] {
        let picture = |structure: &str| {
            let parameters = format!(r#"{{"structure": "{structure}", "photons_per_pass": 20000, {way}}}"#);
            Job::new(&scene, "photon_map", &parameters).run(1, 8).picture().radiance
        };
        let [grid, tree] = [picture("grid"), picture("kdtree")];
        for (pixel, (grid, tree)) in grid.iter().zip(&tree).enumerate() {
            for channel in 0..3 {
                let difference = (grid[channel] - tree[channel]).abs();
                assert!(difference <= 1e-4 * grid[channel], "{way}, pixel {pixel}: {grid:?}, {tree:?}");
            }
        }
    }
}

#[test]
fn photon_map_direct_parameters_that_cannot_be() {
    let refused = [
        (
            r#"{"direct": "shadows"}"#,
            "\"direct\" is \"shadows\"; allowed: sample, photons, shadow_photons, photon_direct",
        ),
        (r#"{"direct_samples": 0}"#, "\"direct_samples\" is 0; allowed: 1 to 1024"),
        (r#"{"direct_reuse": 2}"#, "\"direct_reuse\" is 2; allowed: 0.0 to 1.0"),
        (
            r#"{"direct": "photons", "direct_samples": 2}"#,
            "\"direct_samples\" means nothing with this \"direct\"; leave it out",
        ),
        (r#"{"direct_neighbors": 20}"#, "\"direct_neighbors\" means nothing with this \"direct\"; leave it out"),
        (
            r#"{"direct": "shadow_photons", "direct_reuse": 0}"#,
            "\"direct_reuse\" means nothing with this \"direct\"; leave it out",
        ),
    ];
    for (parameters, expected) in refused {
        let parameters = serde_json::from_str(parameters).expect("an object");
        let choice = MethodChoice { name: "photon_map".to_owned(), parameters };
        let message = check(&choice, 100).expect_err("refused").to_string();
        assert!(message.starts_with(&format!("method \"photon_map\": {expected}")), "{message}");
    }
}
