//! `photon_map` with many maps a pass: means, noise, counts and bits of what pixels see, whichever maps they look at.

use std::sync::Arc;

use crate::progressive::{Begun, Job, reference_scene};
use crate::scene_text::prepare;
use photonfarm::estimate::{PixelTally, RadiusField, Region, Shard};
use photonfarm::math::random::{MOST_PARTS, PassRandom, Stream};
use photonfarm::method::{MethodChoice, check};
use photonfarm::scene::Scene;

/// Blocks across a picture and down.
const BLOCKS: usize = 4;
/// Passes that means and variances are taken of.
const PASSES: u32 = 24;

/// Means of radiance over the picture's blocks, and the variance between the pixels' passes, averaged over the picture.
struct Statistics {
    mean: [f64; BLOCKS * BLOCKS],
    /// Of a block's value in one pass.
    variance: [f64; BLOCKS * BLOCKS],
    /// Of a pixel's value in one pass, mean over pixels.
    pixel_variance: f64,
}

/// What passes of a job see.
fn statistics(scene: &Arc<Scene>, parameters: &str, seed: u64) -> Statistics {
    let job = Job::with_seed(scene, "photon_map", parameters, seed);
    let Begun { estimate, renderer } = job.begin();
    let field = estimate.radius_field(job.region());
    let (width, side) = (scene.width as usize, scene.width as usize / BLOCKS);
    let mut blocks = [[0.0; 2]; BLOCKS * BLOCKS];
    let mut pixels = vec![[0.0; 2]; scene.pixel_count()];
    let add = |sums: &mut [f64; 2], value: f64| *sums = [sums[0] + value, sums[1] + value * value];
    for first_pass in 0..PASSES {
        let tally = renderer.trace(Shard { first_pass, passes: 1, region: job.region() }, &field, &job.never);
        let mut of_pass = [0.0; BLOCKS * BLOCKS];
        for (index, pixel) in tally.expect("nobody cancels").pixels().iter().enumerate() {
            let value = pixel.radiance.iter().map(|channel| f64::from(*channel)).sum::<f64>() / 3.0;
            add(&mut pixels[index], value);
            of_pass[index / width / side * BLOCKS + index % width / side] += value / (side * side) as f64;
        }
        blocks.iter_mut().zip(of_pass).for_each(|(sums, value)| add(sums, value));
    }
    let count = f64::from(PASSES);
    let variance = |[sum, squares]: [f64; 2]| (squares - sum * sum / count) / (count - 1.0);
    Statistics {
        mean: blocks.map(|[sum, _]| sum / count),
        variance: blocks.map(variance),
        pixel_variance: pixels.iter().map(|sums| variance(*sums)).sum::<f64>() / pixels.len() as f64,
    }
}

impl Statistics {
    /// The median over blocks of the variance over that of another picture's: what bright edges and the lamp bring, the camera's alone,
    /// stays out of it.
    fn block_variance_over(&self, other: &Self) -> f64 {
        let mut ratios: Vec<f64> = self.variance.iter().zip(other.variance).map(|(own, other)| own / other).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    }
}

/// Means of 16 blocks differ by no more than noise: with 46 degrees of freedom |t| is above 4.5 once in 20,000 comparisons. Returns
/// both sides' statistics.
fn check_same_mean(scene: &Arc<Scene>, parameters: &str, plain: &str) -> [Statistics; 2] {
    check_mean(scene, parameters, plain, 0.04)
}

/// The same where errors may be up to `blind` of a mean.
fn check_mean(scene: &Arc<Scene>, parameters: &str, plain: &str, blind: f64) -> [Statistics; 2] {
    let (many, one) = (statistics(scene, parameters, 21), statistics(scene, plain, 22));
    for block in 0..BLOCKS * BLOCKS {
        let error = ((many.variance[block] + one.variance[block]) / f64::from(PASSES)).sqrt();
        let difference = many.mean[block] - one.mean[block];
        assert!(difference.abs() < 4.5 * error, "{parameters}: block {block} is off by {difference} ± {error}");
        assert!(error < blind * one.mean[block], "{parameters}: the test is blind in block {block}");
    }
    [many, one]
}

const PLAIN: &str = r#"{"final_gather": 0, "photons_per_pass": 2000}"#;

/// Four maps of 2,000 photons are the mean of four estimates with 2,000: the same mean, less noise.
#[test]
fn agreement_estimates_from_four_maps() {
    let scene = reference_scene("cornell-glass");
    let four = r#"{"final_gather": 0, "photons_per_pass": 8000, "maps": 4}"#;
    let [many, one] = check_same_mean(&scene, four, PLAIN);
    let ratio = many.block_variance_over(&one);
    assert!((0.15..0.4).contains(&ratio), "variance of blocks fell to {ratio}, a quarter was expected");
    let gathered = r#"{"final_gather": 2, "photons_per_pass": 8000, "maps": 4}"#;
    check_same_mean(&scene, gathered, r#"{"final_gather": 2, "photons_per_pass": 2000}"#);
}

/// More paths to one map remove what paths bring of noise, and leave what the map brings.
#[test]
fn agreement_camera_paths_to_one_map() {
    let scene = reference_scene("cornell-glass");
    let four = r#"{"final_gather": 0, "photons_per_pass": 2000, "camera_paths": 4}"#;
    let [many, one] = check_same_mean(&scene, four, PLAIN);
    let blocks = many.block_variance_over(&one);
    let pixels = many.pixel_variance / one.pixel_variance;
    assert!((0.6..1.6).contains(&blocks), "variance of blocks, the map's, went to {blocks}");
    assert!(pixels < 0.9, "variance of pixels fell only to {pixels}");
}

/// Pixels keep their noise, and neighbors no longer share it.
#[test]
fn agreement_skipping_turns_low_into_high_frequencies() {
    let scene = reference_scene("cornell-glass");
    let skipping = r#"{"final_gather": 0, "photons_per_pass": 2000, "skipping": 4}"#;
    let [many, one] = check_same_mean(&scene, skipping, PLAIN);
    let blocks = many.block_variance_over(&one);
    let pixels = many.pixel_variance / one.pixel_variance;
    // A block is the mean over 16 maps; the noise of camera paths stays.
    assert!(blocks < 0.5, "variance of blocks fell only to {blocks}");
    assert!((0.9..1.1).contains(&pixels), "variance of pixels went to {pixels}");
}

/// Without localization the hierarchy has the mean of every map, whatever its levels. What it does to noise depends on the picture.
#[test]
fn agreement_hierarchy_without_localization() {
    let scene = reference_scene("cornell-glass");
    let hierarchy = |levels: u32| {
        format!(
            r#"{{"final_gather": 0, "photons_per_pass": 2000, "hierarchy": {levels}, "coarsest_samples": 20,
            "finest_samples": 1}}"#
        )
    };
    // Bright noise far away is interpolated into the dark, and only few maps take it out again.
    check_mean(&scene, &hierarchy(7), PLAIN, 0.1);
    // 2 to the 16th is more than the width: the base is the two corners.
    check_mean(&scene, &hierarchy(16), PLAIN, 0.1);
    check_mean(&scene, &hierarchy(1), PLAIN, 0.1);
}

fn bits(pixels: &[PixelTally]) -> Vec<u32> {
    bytemuck::cast_slice(pixels).to_vec()
}

/// The same bits for any number of threads, regions and splits of passes.
#[test]
fn agreement_many_maps_of_threads_regions_and_splits() {
    let scene = reference_scene("cornell-glass");
    let variants = [
        r#"{"photons_per_pass": 3001, "maps": 3, "camera_paths": 2}"#,
        r#"{"photons_per_pass": 2000, "skipping": 3, "final_gather": 0, "structure": "kdtree"}"#,
        r#"{"photons_per_pass": 1000, "maps": 2, "hierarchy": 5, "coarsest_samples": 6, "localization": 30, "final_gather": 0}"#,
    ];
    for variant in variants {
        let job = Job::new(&scene, "photon_map", variant);
        let field = job.begin().estimate.radius_field(job.region());
        let trace = |region: Region, first_pass: u32, passes: u32, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let field = RadiusField { radius_squared: Vec::new(), ..field.clone() };
            let shard = Shard { first_pass, passes, region };
            pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels").pixels()
        };
        let whole = trace(job.region(), 3, 2, 1);
        assert!(bits(&whole) == bits(&trace(job.region(), 3, 2, 2)), "{variant}: threads change the picture");
        let band = Region { row_start: 32, row_end: 64 };
        let pixels = 32 * scene.width as usize..64 * scene.width as usize;
        assert!(bits(&whole[pixels]) == bits(&trace(band, 3, 2, 2)), "{variant}: regions change the picture");
        let [mut first, second] = [3, 5].map(|pass| trace(job.region(), pass, 1, 2));
        for (first, second) in first.iter_mut().zip(second) {
            (0..3).for_each(|channel| first.radiance[channel] += second.radiance[channel]);
        }
        assert!(bits(&whole) == bits(&first), "{variant}: splits change the picture");
    }
}

/// Two matte squares, the left one darker, under a lamp at the camera; `right` is the albedo of the right one.
fn two_squares(right: f64) -> Arc<Scene> {
    let square = |place: f64, albedo: f64| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='4'/><translate x='{place}'/></transform>\
            <bsdf type='diffuse'><rgb name='reflectance' value='{albedo}, {albedo}, {albedo}'/></bsdf></shape>"
        )
    };
    let scene = prepare(
        &format!(
            "<sensor type='perspective'><float name='fov' value='40'/><transform name='to_world'>\
            <lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>\
            <integer name='width' value='65'/><integer name='height' value='8'/><rfilter type='box'/></film></sensor>\
            {}{}<emitter type='point'><point name='position' value='0, 0, 5'/>\
            <rgb name='intensity' value='5, 5, 5'/></emitter>",
            square(-3.5, 0.2),
            square(4.5, right)
        ),
        &[],
    );
    Arc::new(scene.expect("the scene is good"))
}

/// The light is direct, from a point and the same in every sample: only the edge between the squares is localized, on the finest level
/// where a node or one of its neighbors is at the edge.
#[test]
fn analytic_localization_at_an_edge() {
    let localized = |scene: &Arc<Scene>| -> Vec<f32> {
        let parameters = r#"{"photons_per_pass": 100, "max_depth": 2, "final_gather": 0, "hierarchy": 6, "coarsest_samples": 4,
            "localization": 30, "show": "localized"}"#;
        let picture = Job::new(scene, "photon_map", parameters).run(2, 2).picture();
        picture.radiance.iter().map(|channels| channels[0]).collect()
    };
    assert!(localized(&two_squares(0.2)).iter().all(|share| *share == 0.0), "an even wall is localized");
    let scene = two_squares(0.8);
    let shares = localized(&scene);
    // 65 pixels are as wide as 2·5·tan 20° = 3.640 m; the edge is at 0.5 m, in pixel 32.5 + 8.93 = 41.4 of either direction of x.
    let edges = [41, 23].map(|edge: i32| (0..65).filter(|x| x % 2 == 1 && (x - edge).abs() <= 1).collect::<Vec<i32>>());
    for row in shares.chunks(65) {
        let finest: Vec<i32> = (0..65).filter(|x| x % 2 == 1 && row[*x as usize] > 0.0).collect();
        assert!(edges.contains(&finest), "localized on the finest level: {finest:?}");
    }
    // What is localized is seen by the mean of all samples, as it is without a hierarchy.
    let picture = |more: &str| {
        let parameters = format!(r#"{{"photons_per_pass": 100, "max_depth": 2, "final_gather": 0, {more}}}"#);
        Job::new(&scene, "photon_map", &parameters).run(16, 2).picture().radiance
    };
    let plain = picture(r#""camera_paths": 4"#);
    let hierarchical = picture(r#""hierarchy": 6, "coarsest_samples": 4, "localization": 30"#);
    for (x, (plain, found)) in
        plain.iter().zip(&hierarchical).enumerate().filter(|(x, _)| ![41, 23].contains(&(x % 65)))
    {
        assert!((found[0] - plain[0]).abs() < 0.02 * plain[0], "pixel {x}: {} is not {}", found[0], plain[0]);
    }
}

/// Photons of all maps of a pass are counted, those that are traced a second time too, and a pilot knows what they cost.
#[test]
fn many_maps_are_counted() {
    let scene = reference_scene("cornell-diffuse");
    let emitted = |more: &str| {
        let parameters = format!(r#"{{"photons_per_pass": 1001, "final_gather": 0{more}}}"#);
        let job = Job::new(&scene, "photon_map", &parameters);
        (job.run(1, 1).photons_emitted(), job.renderer.pilot(&job.never).expect("nobody cancels").cost_per_pass())
    };
    let (plain, cost) = emitted("");
    assert_eq!(plain, 1001);
    assert_eq!(emitted(r#", "maps": 4"#).0, 1001);
    assert_eq!(emitted(r#", "camera_paths": 4"#).0, 1001);
    let (skipping, skipping_cost) = emitted(r#", "skipping": 3"#);
    assert_eq!(skipping, 9 * 1001);
    assert!(cost < skipping_cost && skipping_cost < 2 * cost, "{cost} and {skipping_cost}: few photons cost little");
    let hierarchy = r#", "hierarchy": 7, "coarsest_samples": 20, "finest_samples": 3"#;
    let (hierarchical, hierarchical_cost) = emitted(hierarchy);
    assert_eq!(hierarchical, 20 * 1001);
    assert!(2 * cost < hierarchical_cost && hierarchical_cost < 6 * cost, "{cost} and {hierarchical_cost}");
    let (localized, _) = emitted(&format!(r#"{hierarchy}, "localization": 20"#));
    assert_eq!(localized, (20 + 17) * 1001, "the first three maps have been looked at by all pixels");
}

#[test]
fn maps_that_contradict_each_other_are_refused() {
    let refused = [
        (r#"{"maps": 9, "photons_per_pass": 8}"#, "\"maps\" is 9, and \"photons_per_pass\" has 8 for all of them"),
        (r#"{"hierarchy": 3, "skipping": 2}"#, "\"hierarchy\" and \"skipping\" both say which maps a pixel looks at"),
        (
            r#"{"hierarchy": 3, "coarsest_samples": 4, "finest_samples": 5}"#,
            "\"finest_samples\" is 5, and \"coarsest_samples\" is 4",
        ),
        (r#"{"coarsest_samples": 40}"#, "\"coarsest_samples\" is about levels of sampling, and \"hierarchy\" is 0"),
        (r#"{"finest_samples": 2}"#, "\"finest_samples\" is about levels of sampling, and \"hierarchy\" is 0"),
        (r#"{"localization": 2}"#, "\"localization\" is about levels of sampling, and \"hierarchy\" is 0"),
        (r#"{"show": "localized"}"#, "\"show\" is about levels of sampling, and \"hierarchy\" is 0"),
        (
            r#"{"hierarchy": 3, "coarsest_samples": 4, "finest_samples": 4, "localization": 1}"#,
            "\"localization\" is given, and all levels have 4 samples, so no pixel lacks any",
        ),
        (r#"{"hierarchy": 3, "show": "localized"}"#, "\"show\" is \"localized\", and \"localization\" is 0"),
    ];
    for (parameters, expected) in refused {
        let parameters = serde_json::from_str(parameters).expect("an object");
        let choice = MethodChoice { name: "photon_map".to_owned(), parameters };
        let message = check(&choice, 100).expect_err("refused").to_string();
        assert!(message.starts_with(&format!("method \"photon_map\": {expected}")), "{message}");
    }
}

/// Where pixels have different numbers of samples, each sample is spread evenly over the passes by itself: 64 of its points, the whole square in
/// 64 boxes. Fine levels of the hierarchy, which have few samples, were as noisy as with independent numbers.
#[test]
fn each_sample_of_a_pixel_is_spread_evenly_over_passes() {
    for (sample, paths) in [(0, 1), (1, 1), (37, 1), (5, 4)] {
        let mut boxes = [0; 64];
        for path in 0..paths {
            for pass in 0..64 / paths {
                let random = PassRandom::of_pixels(3, Stream::Camera, 2 * pass).sample(sample).part(path, paths);
                let [x, y, ..] = random.path(9).block(1);
                boxes[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
            }
        }
        assert_eq!(boxes, [1; 64], "sample {sample} of {paths} paths");
    }
    let numbers = |sample| PassRandom::of_pixels(3, Stream::Camera, 4).sample(sample).path(9).block(0);
    assert_eq!(numbers(0), PassRandom::of_pixels(3, Stream::Camera, 4).path(9).block(0));
    assert_ne!(numbers(0), numbers(1));
}

/// Parts of passes have numbers of their own, and the only part of a pass has the numbers of the pass.
#[test]
fn parts_of_passes_share_no_numbers() {
    let whole = PassRandom::independent(3, Stream::Photon, 7);
    let mut seen = Vec::new();
    for (pass, part) in [6, 7].into_iter().flat_map(|pass| [0, 1, 2, MOST_PARTS - 1].map(|part| (pass, part))) {
        let random = PassRandom::independent(3, Stream::Photon, pass).part(part, MOST_PARTS);
        seen.extend((0..40).map(|block| random.path(9).block(block).map(f32::to_bits)));
    }
    assert_eq!(whole.path(9).block(5), whole.part(0, 1).path(9).block(5));
    let spread = PassRandom::of_pixels(3, Stream::Camera, 7);
    assert_eq!(spread.path(9).block(0), spread.part(0, 1).path(9).block(0));
    assert_ne!(spread.path(9).block(0), spread.part(1, 2).path(9).block(0));
    let count = seen.len();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), count);
}
