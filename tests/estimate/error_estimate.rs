//! A job's own error estimate against errors that are known because they were put in.

use std::sync::Arc;

use photonfarm::estimate::declaration::PHOTONS_EMITTED;
use photonfarm::estimate::{Declaration, Estimate, PixelTally, RadiusRule, Region, Shard, Tally};
use photonfarm::math::random::{PathRandom, Stream};

const SIZE: u32 = 64;
const PHOTONS: u64 = 1000;
const REGION: Region = Region { row_start: 0, row_end: SIZE };

/// Sums of one pixel in one pass: radiance, flux density (over πE), and its part inside half the disc's area.
struct Sample {
    radiance: f32,
    density: f32,
    inner: f32,
}

/// An estimate of `passes` passes, each of invented samples.
fn invented(passes: u32, sample: impl Fn(u32, u32) -> Sample) -> Estimate {
    let pixels = SIZE * SIZE;
    let declaration = Arc::new(Declaration::gathering(RadiusRule::Schedule, 2.0 / 3.0));
    let mut estimate = Estimate::new(SIZE, SIZE, &[REGION], declaration.clone(), &vec![1.0; pixels as usize])
        .expect("one radius per pixel");
    for first_pass in 0..passes {
        let field = estimate.radius_field(REGION);
        let mut found = vec![PixelTally::default(); pixels as usize];
        let per_photon = std::f32::consts::PI * PHOTONS as f32;
        for (pixel, index) in found.iter_mut().zip(0..) {
            let Sample { radiance, density, inner } = sample(first_pass, index);
            pixel.radiance = [radiance; 3];
            pixel.flux = [density * per_photon; 3];
            pixel.inner_flux = inner * per_photon;
        }
        let shard = Shard { first_pass, passes: 1, region: REGION };
        let mut tally = Tally::from_sums(shard, SIZE, &declaration, &found.into());
        tally.set_scalar(PHOTONS_EMITTED, PHOTONS as f64);
        estimate.merge(&tally, &field).expect("the tally fits");
    }
    estimate
}

/// A number in [-1, 1), of variance 1/3. Independent for all passes and pixels: later blocks are not spread evenly.
fn noise(pass: u32, pixel: u32, number: usize) -> f32 {
    2.0 * PathRandom::new(3, Stream::Camera, pass, pixel).block(100)[number] - 1.0
}

fn true_relmse(estimate: &Estimate, truth: f64) -> f64 {
    let picture = estimate.picture().radiance;
    let error = |pixel: &[f32; 3]| (f64::from(pixel[0]) - truth).powi(2);
    picture.iter().map(error).sum::<f64>() / (picture.len() as f64 * truth * truth * 1.001)
}

#[test]
fn noise_that_was_put_in_is_found() {
    for (passes, strength) in [(4, 0.3), (9, 1.0), (32, 3.0)] {
        let estimate = invented(passes, |pass, pixel| Sample {
            radiance: 2.0 * (1.0 + strength * noise(pass, pixel, 0)),
            density: 0.0,
            inner: 0.0,
        });
        let error = estimate.error().expect("both twins have passes");
        let expected = f64::from(strength * strength) / 3.0 / f64::from(passes);
        // 4096 squared differences: ± 2.2 % of their mean.
        assert!((error.noise / expected - 1.0).abs() < 0.08, "{error:?} where {expected} was put in");
        assert_eq!((error.bias, error.sampled_noise), (0.0, error.noise));
        let real = true_relmse(&estimate, 2.0);
        // Twice the estimate, and the spread of 16 blocks.
        assert!(real < error.bound && error.bound < 2.5 * real, "{error:?} where the error is {real}");
    }
}

/// Noise of camera paths and noise of density estimates, one three times as strong as the other.
#[test]
fn noise_is_told_apart_by_where_it_comes_from() {
    let estimate = invented(16, |pass, pixel| Sample {
        radiance: 1.0 + 0.3 * noise(pass, pixel, 0),
        density: 1.0 + 0.9 * noise(pass, pixel, 1),
        inner: 0.5,
    });
    let error = estimate.error().expect("both twins have passes");
    let ratio = error.sampled_noise / error.noise;
    // 4096 squared differences of each: ± 2.6 % of the ratio.
    assert!((ratio / 0.1 - 1.0).abs() < 0.12, "{ratio} where 0.1 was put in");
}

/// The left half is noisy, the right half is not: the standard error of the mean of n passes is σ/√n, and 0.
#[test]
fn standard_errors_stand_where_the_noise_is() {
    let (passes, strength) = (16, 0.5);
    let is_noisy = |pixel: u32| pixel % SIZE < SIZE / 2;
    let estimate = invented(passes, |pass, pixel| Sample {
        radiance: if is_noisy(pixel) { 2.0 + strength * noise(pass, pixel, 0) } else { 2.0 },
        density: 0.0,
        inner: 0.0,
    });
    let errors = estimate.standard_error().expect("both twins have passes");
    let variance = f64::from(strength * strength) / 3.0 / f64::from(passes);
    let at = |column: u32| (0..SIZE).map(move |row| row * SIZE + column);
    let mean_square = |columns: std::ops::Range<u32>| {
        let squares = columns.flat_map(at).map(|pixel| f64::from(errors[pixel as usize]).powi(2));
        let squares: Vec<f64> = squares.collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    // 1920 squared differences: ± 3.2 % of their mean.
    let ratio = mean_square(0..SIZE / 2 - 1) / variance;
    assert!((ratio - 1.0).abs() < 0.12, "{ratio} of the variance that was put in");
    // A third of the pixels around are noisy on one side of the border, two thirds on the other: 64 rows, ± 25 %.
    let border =
        [mean_square(SIZE / 2 - 1..SIZE / 2), mean_square(SIZE / 2..SIZE / 2 + 1)].map(|square| square / variance);
    assert!((0.4..0.95).contains(&border[0]) && (0.15..0.55).contains(&border[1]), "{border:?}");
    assert_eq!(mean_square(SIZE / 2 + 1..SIZE), 0.0);
}

/// L(R²) = 1 + c·R²: the disc finds 1 + c, half its area half of 1 + c/2.
#[test]
fn bias_that_was_put_in_is_found() {
    for (c, strength) in [(0.2, 0.0), (0.2, 0.1), (-0.1, 0.05)] {
        let estimate = invented(32, |pass, pixel| {
            let [ring, middle] = [1, 2].map(|number| 0.5 * strength * noise(pass, pixel, number));
            let inner = 0.5 * (1.0 + 0.5 * c) + middle;
            Sample { radiance: 0.0, density: 1.0 + c + ring + middle, inner }
        });
        let error = estimate.error().expect("both twins have passes");
        // Relative to the truth, or to the picture where that is darker.
        let expected = f64::from(c * c / (1.0 + c.min(0.0)).powi(2));
        assert!((error.bias / expected - 1.0).abs() < 0.05, "{error:?} where {expected} was put in");
        let real = true_relmse(&estimate, 1.0);
        assert!(real < 1.5 * error.bound, "{error:?} where the error is {real}");
    }
}

/// A strip of darkness, 0.1, beside light of 1, blurred: 0.5 is found there, and half the bias inside half of each disc. The picture is no measure of
/// how dark it should be.
#[test]
fn light_in_the_dark_is_measured_by_the_dark() {
    const DARK: f32 = 0.1;
    let is_dark = |pixel: u32| (24..36).contains(&(pixel % SIZE));
    for strength in [0.0, 0.3, 1.0] {
        let estimate = invented(32, |pass, pixel| {
            let bias = if is_dark(pixel) { 0.5 - DARK } else { 0.0 };
            let truth = if is_dark(pixel) { DARK } else { 1.0 };
            let [ring, middle] = [1, 2].map(|number| 0.5 * strength * (truth + bias) * noise(pass, pixel, number));
            Sample { radiance: 0.0, density: truth + bias + ring + middle, inner: 0.5 * (truth + 0.5 * bias) + middle }
        });
        let error = estimate.error().expect("both twins have passes");
        // Y is a quarter of the picture at least, and less of the bias is sure where it is noisy.
        let expected = 12.0 / 64.0 * 0.4f64.powi(2) / 0.125f64.powi(2);
        assert!((0.65..1.05).contains(&(error.bias / expected)), "{error:?} where {expected} was put in");
    }
}

/// Where there is only noise, both twins tell a bias by chance as often as they contradict each other.
#[test]
fn noise_is_not_taken_for_light_in_the_dark() {
    for strength in [0.3, 1.0, 3.0] {
        let estimate = invented(16, |pass, pixel| {
            let [ring, middle] = [1, 2].map(|number| 0.5 * strength * noise(pass, pixel, number));
            Sample { radiance: 0.0, density: 1.0 + ring + middle, inner: 0.5 + middle }
        });
        let error = estimate.error().expect("both twins have passes");
        assert!(error.bias < 0.1 * error.noise, "{error:?}");
    }
}

#[test]
fn nothing_is_said_before_both_twins_have_a_pass() {
    let sample = |_, _| Sample { radiance: 1.0, density: 0.0, inner: 0.0 };
    assert_eq!(invented(0, sample).error(), None);
    assert_eq!(invented(1, sample).error(), None);
    assert!(invented(2, sample).error().is_some());
    assert_eq!(invented(1, sample).standard_error(), None);
    assert_eq!(invented(2, sample).standard_error(), Some(vec![0.0; (SIZE * SIZE) as usize]));
}

/// A black picture has no scale to measure an error by.
#[test]
fn a_black_picture_has_no_error() {
    assert_eq!(invented(4, |_, _| Sample { radiance: 0.0, density: 0.0, inner: 0.0 }).error(), None);
}
