//! Furnaces: scenes whose radiance is exactly 1 everywhere, through every method and radius rule.

use crate::progressive::{Job, reference_scene};
use photonfarm::estimate::Picture;
use photonfarm::evaluation::compare;

/// Relative error that the mean of the picture may have.
const MEAN_BOUND: f64 = 0.003;
/// With these all pictures together take about 60 seconds of one core. What is left is the bias of discs that reach over
/// edges; it falls with the radius, hence slowly with the passes.
const PASSES: u32 = 24;
const AUTO: &str = "\"auto\"";

/// Renders `name` with every method and radius rule; no 8 × 8 block may be off by more than `block_bound`.
fn check_furnace(name: &str, radius: &str, photons: u32, block_bound: f64) {
    let scene = reference_scene(name);
    let white = Picture { width: scene.width, height: scene.height, radiance: vec![[1.0; 3]; scene.pixel_count()] };
    let rules = ["statistics", "schedule", "uniformity"];
    for (method, rule) in ["sppm", "ppm"].into_iter().flat_map(|method| rules.map(|rule| (method, rule))) {
        let parameters =
            format!(r#"{{"radius_rule": "{rule}", "photons_per_pass": {photons}, "initial_radius": {radius}}}"#);
        let estimate = Job::new(&scene, method, &parameters).run(PASSES, 8);
        let metrics = compare(&estimate.picture(), &white, None).expect("the sizes agree");
        println!("{name} {method} {rule}: mean {:+.5}, blocks {:.4}", metrics.bias, metrics.block_bias_max);
        assert_eq!(estimate.non_finite(), 0);
        for bias in metrics.bias_rgb {
            assert!(bias.abs() < MEAN_BOUND, "{name} by {method} ({rule}): mean off by {:.3} %", 100.0 * bias);
        }
        let block = metrics.block_bias_max;
        assert!(block < block_bound, "{name} by {method} ({rule}): a block off by {:.1} %", 100.0 * block);
    }
}

#[test]
fn furnace_closed_box() {
    // The automatic first radius leaves a bias of 0.25 %, and a mean 0.1 % of noise with half as many photons.
    check_furnace("furnace-closed", "0.015", 1 << 17, 0.05);
}

#[test]
fn furnace_white_sphere_in_an_environment() {
    check_furnace("furnace-env", AUTO, 1 << 14, 0.03);
}

#[test]
fn furnace_with_mirror_and_glass() {
    // Discs that reach over edges take 1 to 2 % of the blocks there: a first radius of 0.03 m (about the automatic one) is off
    // by 0.63 % after so few passes, so start smaller; blocks are noisier then.
    check_furnace("furnace-specular", "0.006", 1 << 17, 0.08);
}
