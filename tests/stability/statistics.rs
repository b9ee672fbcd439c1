//! What is summed over passes: many passes, few photons, extreme radii and α.

use std::f64::consts::PI;
use std::sync::Arc;

use photonfarm::estimate::declaration::PHOTONS_EMITTED;
use photonfarm::estimate::radius::shrinkage;
use photonfarm::estimate::{Declaration, Estimate, PixelTally, RadiusRule, Region, Shard, Tally};
use photonfarm::scene::Scene;

use crate::pictures::{assert_close, camera, estimate, glow, grays, matte, mean, picture, relative_error, room, scene};

const PIXEL: Region = Region { row_start: 0, row_end: 1 };
const ALPHA: f64 = 2.0 / 3.0;

/// A picture of one pixel, gathering in discs of 1 m² over π.
fn single_pixel(rule: RadiusRule, alpha: f64) -> Estimate {
    let declaration = Arc::new(Declaration::gathering(rule, alpha));
    Estimate::new(1, 1, &[PIXEL], declaration, &[1.0]).expect("one radius for one pixel")
}

fn one_pass(estimate: &Estimate, pass: u32, photons: u64, pixel: PixelTally) -> Tally {
    let shard = Shard { first_pass: pass, passes: 1, region: PIXEL };
    let mut tally = Tally::from_sums(shard, 1, estimate.declaration(), &vec![pixel].into());
    tally.set_scalar(PHOTONS_EMITTED, photons as f64);
    tally
}

/// A tenth cannot be written in binary: sums of a million of them in single precision are 1 % off.
#[test]
fn a_million_passes_lose_nothing() {
    const PASSES: u32 = 1_000_000;
    let mut found = single_pixel(RadiusRule::Statistics, ALPHA);
    let (emitted, density) = (1u64 << 26, 10.0);
    for pass in 0..PASSES {
        // Photons of an even density: as many as the disc takes.
        let field = found.radius_field(PIXEL);
        let area = field.radius_squared[0];
        let flux = [0.1 * area; 3];
        let pixel = PixelTally { radiance: [0.1; 3], flux, photons: density * area, inner_flux: 0.05 * area };
        found.merge(&one_pass(&found, pass, emitted, pixel), &field).expect("tallies come in order");
    }
    let expected = f64::from(0.1f32) * (1.0 + 1.0 / (PI * emitted as f64));
    assert_close(f64::from(found.picture().radiance[0][0]), expected, 1e-6, "radiance after a million passes");
    let pixel = found.pixel(0);
    let shrunk = shrinkage(RadiusRule::Statistics, ALPHA, PASSES);
    assert_close(pixel.radius_squared, shrunk, 1e-6, "radius² after a million passes");
    assert_close(pixel.photons, f64::from(density) * shrunk * f64::from(PASSES), 1e-6, "photons");
    assert_eq!(found.photons_emitted(), emitted * u64::from(PASSES));
}

#[test]
fn a_pixel_without_photons_stays_black_and_keeps_its_radius() {
    let mut found = single_pixel(RadiusRule::Statistics, ALPHA);
    for pass in 0..1000 {
        let field = found.radius_field(PIXEL);
        found.merge(&one_pass(&found, pass, 1000, PixelTally::default()), &field).expect("tallies come in order");
    }
    assert_eq!(found.picture().radiance, [[0.0; 3]]);
    assert_eq!((found.pixel(0).radius_squared, found.pixel(0).photons), (1.0, 0.0));
}

/// One photon among 1000 passes: N = α, R² = α·R₁², and L = Φ/(π·R₁²·E).
#[test]
fn a_pixel_with_one_photon_is_what_the_formula_says() {
    let mut found = single_pixel(RadiusRule::Statistics, ALPHA);
    for pass in 0..1000 {
        let field = found.radius_field(PIXEL);
        let count = if pass == 500 { 1.0 } else { 0.0 };
        let pixel = PixelTally { flux: [3.0 * count; 3], photons: count, ..PixelTally::default() };
        found.merge(&one_pass(&found, pass, 1000, pixel), &field).expect("tallies come in order");
    }
    let pixel = found.pixel(0);
    assert!((pixel.photons - ALPHA).abs() < 1e-12 && (pixel.radius_squared - ALPHA).abs() < 1e-12, "{pixel:?}");
    assert_close(f64::from(found.picture().radiance[0][0]), 3.0 / (PI * 1e6), 1e-6, "radiance of one photon");
}

/// α so small that a radius² of single precision is 0: the sums must stay finite.
#[test]
fn radii_never_become_zero() {
    for alpha in [1e-300, 1e-45, 1e-12, 1.0 - 1e-12] {
        for rule in [RadiusRule::Statistics, RadiusRule::Schedule] {
            let mut found = single_pixel(rule, alpha);
            for pass in 0..64 {
                let field = found.radius_field(PIXEL);
                let area = field.radius_squared[0];
                let pixel = PixelTally { flux: [area; 3], photons: 5.0 * area, ..PixelTally::default() };
                found.merge(&one_pass(&found, pass, 1000, pixel), &field).expect("tallies come in order");
            }
            let radius_squared = found.radius_field(PIXEL).radius_squared[0];
            let radiance = found.picture().radiance[0][0];
            assert!(radius_squared > 0.0, "α = {alpha:e} {rule:?}: R² = {radius_squared:e}");
            assert_close(f64::from(radiance), 1.0 / (PI * 1000.0), 1e-6, &format!("α = {alpha:e} {rule:?}"));
        }
    }
}

fn furnace() -> Arc<Scene> {
    let walls = room([1.0; 3], &format!("{}{}", matte(0.8), glow(0.2)));
    scene(&[&camera("0.1, 0.2, 0.3", "1, 0.3, 0.4", "0, 1, 0", 50.0, 16), &walls])
}

/// α near 1 keeps the first radius, and its bias; α near 0 gives it up after the first photons and waits for the next: noisy,
/// but right on average. (With α = 10⁻⁶ and radii from statistics hardly any pixel ever sees another photon.)
#[test]
fn every_alpha_keeps_the_mean() {
    let scene = furnace();
    for rule in ["statistics", "schedule"] {
        for (alpha, tolerance) in [(0.01, 0.3), (0.1, 0.08), (0.667, 0.02), (0.99, 0.02), (1.0 - 1e-6, 0.02)] {
            let parameters = format!(
                r#"{{"photons_per_pass": 4096, "direct": "photons", "alpha": {alpha}, "radius_rule": "{rule}"}}"#
            );
            let seen = picture(&scene, "sppm", &parameters, 32);
            println!("{rule}, α = {alpha}: error of a pixel {:.3}", relative_error(&seen, |_| 1.0));
            assert_close(mean(&seen), 1.0, tolerance, &format!("{rule}: α = {alpha}"));
        }
    }
}

/// With 20 photons in the first gather the radius would be 0.06 m.
#[test]
fn wrong_first_radii_give_the_right_mean() {
    let scene = furnace();
    for (radius, tolerance) in [("0.0006", 2.0), ("0.006", 0.15), ("0.06", 0.02), ("0.6", 0.05)] {
        let parameters = format!(r#"{{"photons_per_pass": 4096, "direct": "photons", "initial_radius": {radius}}}"#);
        let seen = picture(&scene, "sppm", &parameters, 32);
        println!("first radius {radius}: error of a pixel {:.3}", relative_error(&seen, |_| 1.0));
        // The smaller ones find so few photons that four standard errors are these.
        assert_close(mean(&seen), 1.0, tolerance, &format!("first radius {radius}"));
    }
    let huge = r#"{"photons_per_pass": 2048, "direct": "photons", "initial_radius": 6}"#;
    let [soon, late] = [4, 64].map(|passes| 1.0 - mean(&picture(&scene, "sppm", huge, passes)));
    println!("first radius 6: {soon:.3} too dark after 4 passes, {late:.3} after 64");
    assert!(late < 0.9 * soon, "what a radius far too large hides does not come back: {late}");
}

/// As many photons in passes of one as in one pass.
#[test]
fn any_number_of_photons_a_pass_gives_the_right_mean() {
    let scene = furnace();
    for (photons, passes, tolerance) in [(1, 2048, 0.2), (16, 512, 0.15), (4096, 8, 0.05), (1 << 18, 1, 0.03)] {
        let parameters = format!(r#"{{"photons_per_pass": {photons}, "direct": "photons"}}"#);
        let seen = picture(&scene, "sppm", &parameters, passes);
        println!("{photons} photons a pass: error of a pixel {:.3}", relative_error(&seen, |_| 1.0));
        assert_close(mean(&seen), 1.0, tolerance, &format!("{photons} photons a pass, {passes} passes"));
    }
}

/// Pixels that found no photon yet are black, not wrong: radii only shrink where photons came.
#[test]
fn passes_of_a_single_photon_shrink_no_radius_in_vain() {
    let found = estimate(&furnace(), "sppm", r#"{"photons_per_pass": 1, "direct": "photons"}"#, 16);
    let first = estimate(&furnace(), "sppm", r#"{"photons_per_pass": 1, "direct": "photons"}"#, 1);
    let values = grays(&found.picture());
    let unseen = values.iter().zip(found.pixels()).zip(first.pixels());
    let mut black = 0;
    for ((value, pixel), before) in unseen.filter(|((_, pixel), _)| pixel.photons == 0.0) {
        assert_eq!((*value > 0.3, pixel.radius_squared), (false, before.radius_squared));
        black += 1;
    }
    assert!(black > 10, "only {black} pixels without photons");
}
