//! Random numbers have no pattern that a picture could show: white spectra over pixels, over paths and over passes.
//!
//! Of N uniform numbers the power |F|² at each frequency, over N/12, is exponential with mean 1. So the largest of M powers is above
//! ln(M/p) with probability p, and the mean of n of them is normal with deviation 1/√n. Each test has a chance of 10⁻⁶ to fail numbers
//! that are perfect, shared among everything that it looks at.

use std::f64::consts::TAU;

use photonfarm::math::random::{PassRandom, Stream, dimension};

const SIGNIFICANCE: f64 = 1e-6;
/// Pixels on a side of the pictures of noise.
const SIDE: usize = 64;

#[derive(Clone, Copy, Default)]
struct Complex {
    re: f64,
    im: f64,
}

/// The discrete Fourier transform of 2ᵏ values [Cooley & Tukey 1965].
fn transform(values: &[Complex]) -> Vec<Complex> {
    if values.len() == 1 {
        return values.to_vec();
    }
    let half = |first: usize| transform(&values.iter().skip(first).step_by(2).copied().collect::<Vec<_>>());
    let (even, odd) = (half(0), half(1));
    let mut out = vec![Complex::default(); values.len()];
    for (index, (even, odd)) in even.iter().zip(&odd).enumerate() {
        let (sin, cos) = (-TAU * index as f64 / values.len() as f64).sin_cos();
        let turned = Complex { re: odd.re * cos - odd.im * sin, im: odd.re * sin + odd.im * cos };
        out[index] = Complex { re: even.re + turned.re, im: even.im + turned.im };
        out[index + values.len() / 2] = Complex { re: even.re - turned.re, im: even.im - turned.im };
    }
    out
}

/// Powers of a row of numbers with mean 0 and deviation 1, each frequency once, the mean left out.
fn spectrum(values: &[f64]) -> Vec<f64> {
    let complex: Vec<Complex> = values.iter().map(|value| Complex { re: *value, im: 0.0 }).collect();
    let power = |value: &Complex| (value.re * value.re + value.im * value.im) / values.len() as f64;
    transform(&complex)[1..values.len() / 2].iter().map(power).collect()
}

/// The same of a square picture, with the larger of both frequencies in waves per picture.
fn spectrum_of_picture(values: &[f64]) -> Vec<(usize, f64)> {
    let mut rows: Vec<Vec<Complex>> = values
        .chunks(SIDE)
        .map(|row| transform(&row.iter().map(|value| Complex { re: *value, im: 0.0 }).collect::<Vec<_>>()))
        .collect();
    for column in 0..SIDE {
        let transformed = transform(&rows.iter().map(|row| row[column]).collect::<Vec<_>>());
        rows.iter_mut().zip(transformed).for_each(|(row, value)| row[column] = value);
    }
    let waves = |index: usize| index.min(SIDE - index);
    let mut powers = Vec::new();
    for (y, row) in rows.iter().enumerate() {
        // The other half repeats this one; columns at both ends of it are real and left out.
        for (x, value) in row.iter().enumerate().take(SIDE / 2).skip(1) {
            powers.push((waves(x).max(waves(y)), (value.re * value.re + value.im * value.im) / (SIDE * SIDE) as f64));
        }
    }
    powers
}

/// `tests` is how many spectra share the significance.
fn assert_white(powers: &[f64], tests: f64, what: &str) {
    let most = (powers.len() as f64 * tests / SIGNIFICANCE).ln();
    let largest = powers.iter().copied().fold(0.0, f64::max);
    assert!(largest < most, "{what}: a wave of {largest:.1} times the mean power, at most {most:.1}");
    // The tail of the gamma distribution is longer than the normal one: 6 deviations are at 10⁻⁸ above some hundred powers.
    let mean = powers.iter().sum::<f64>() / powers.len() as f64;
    let off = (mean - 1.0) * (powers.len() as f64).sqrt();
    assert!(off.abs() < 6.0, "{what}: mean power {mean:.4}, {off:.1} standard deviations off");
}

/// Uniform in [0, 1) to mean 0 and deviation 1.
fn standard(value: f32) -> f64 {
    (f64::from(value) - 0.5) * 12f64.sqrt()
}

fn assert_picture_is_white(value: impl Fn(u32) -> f64, tests: f64, what: &str) {
    let values: Vec<f64> = (0..(SIDE * SIDE) as u32).map(value).collect();
    let powers = spectrum_of_picture(&values);
    for low in [0, 8, 16, 24] {
        let band: Vec<f64> =
            powers.iter().filter(|(waves, _)| (low..low + 8).contains(waves)).map(|(_, power)| *power).collect();
        assert_white(&band, 4.0 * tests, &format!("{what}, {low} waves and more"));
    }
}

/// Blocks with evenly spread numbers and one without.
const BLOCKS: [u32; 4] = [dimension::CAMERA, dimension::scattering(1), dimension::light(2), dimension::scattering(5)];

#[test]
fn pixels_of_a_pass_share_no_pattern() {
    for pass in [0, 1, 2, 7, 1000] {
        let random = PassRandom::of_pixels(1, Stream::Camera, pass);
        for (block, number) in BLOCKS.into_iter().flat_map(|block| (0..4).map(move |number| (block, number))) {
            let what = format!("pass {pass}, block {block}, number {number}");
            assert_picture_is_white(|pixel| standard(random.path(pixel).block(block)[number]), 80.0, &what);
        }
    }
}

/// What a picture shows after many passes is the mean over passes, so that must be white too. Its deviation is the picture's own:
/// evenly spread numbers err less than independent ones.
#[test]
fn sums_of_passes_share_no_pattern() {
    const PASSES: u32 = 256;
    // A step at 0.3, as shadows make them.
    let step = |value: f32| if value < 0.3 { 0.7 } else { -0.3 };
    let passes: Vec<PassRandom> = (0..PASSES).map(|pass| PassRandom::of_pixels(1, Stream::Camera, pass)).collect();
    for block in BLOCKS {
        let sum = |pixel: u32| -> f64 { passes.iter().map(|pass| step(pass.path(pixel).block(block)[1])).sum() };
        let sums: Vec<f64> = (0..(SIDE * SIDE) as u32).map(sum).collect();
        let deviation = (sums.iter().map(|sum| sum * sum).sum::<f64>() / sums.len() as f64).sqrt();
        // Independent passes: √(256·0.21) = 7.3.
        assert!(deviation < 7.3 * 1.06, "block {block}: deviation {deviation}");
        let what = format!("sum of {PASSES} passes, block {block}");
        assert_picture_is_white(|pixel| sums[pixel as usize] / deviation, 4.0, &what);
    }
}

/// Shards are ranges of passes, so this holds between shards and workers too.
#[test]
fn ten_thousand_passes_of_independent_numbers_share_no_pattern() {
    const PASSES: u32 = 1 << 14;
    for (path, number) in [(0, 0), (1, 1), (77, 2), (262_143, 3)] {
        let value = |pass: u32, block: u32| {
            standard(PassRandom::independent(1, Stream::Photon, pass).path(path).block(block)[number])
        };
        for block in [dimension::EMISSION, dimension::scattering(3)] {
            let values: Vec<f64> = (0..PASSES).map(|pass| value(pass, block)).collect();
            assert_white(&spectrum(&values), 16.0, &format!("path {path}, block {block} over passes"));
        }
    }
    // The photons of a pass among themselves.
    for pass in [0, 1, 2, 9999] {
        let random = PassRandom::independent(1, Stream::Photon, pass);
        for block in [dimension::EMISSION, dimension::EMISSION_DIRECTION] {
            let values: Vec<f64> = (0..PASSES).map(|path| standard(random.path(path).block(block)[0])).collect();
            assert_white(&spectrum(&values), 16.0, &format!("pass {pass}, block {block} over paths"));
        }
    }
}

/// After 10⁴ passes a pixel's evenly spread numbers must have come closer to the mean than independent ones would have, in each twin,
/// and the twins' errors must have nothing to do with each other.
#[test]
fn ten_thousand_passes_of_a_pixel_converge_and_twins_are_independent() {
    const PASSES: u32 = 10_000;
    const PIXELS: u32 = 200;
    // The distance from a corner of the square: bent in both numbers. Mean (√2 + ln(1 + √2))/3, variance 2/3 − mean².
    let value = |numbers: [f32; 4]| f64::from(numbers[0].hypot(numbers[1]));
    let mean = (2f64.sqrt() + (1.0 + 2f64.sqrt()).ln()) / 3.0;
    let independent = ((2.0 / 3.0 - mean * mean) / f64::from(PASSES / 2)).sqrt();
    let errors: Vec<[f64; 2]> = (0..PIXELS)
        .map(|pixel| {
            let mut sums = [0.0; 2];
            for pass in 0..PASSES {
                let numbers = PassRandom::of_pixels(1, Stream::Camera, pass).path(pixel).block(dimension::CAMERA);
                sums[pass as usize % 2] += value(numbers);
            }
            sums.map(|sum| (sum / f64::from(PASSES / 2) - mean) / independent)
        })
        .collect();
    let deviation = |twin: usize| (errors.iter().map(|e| e[twin] * e[twin]).sum::<f64>() / f64::from(PIXELS)).sqrt();
    let [first, second] = [deviation(0), deviation(1)];
    println!("deviation over that of independent numbers: {first:.4}, {second:.4}");
    assert!(first < 0.1 && second < 0.1, "{first} and {second} of independent numbers' deviation");
    let product = errors.iter().map(|e| e[0] * e[1]).sum::<f64>() / (f64::from(PIXELS) * first * second);
    // Normal with deviation 1/√200; 4.9 deviations are at 10⁻⁶.
    assert!(product.abs() < 4.9 / f64::from(PIXELS).sqrt(), "twins correlate by {product}");
}
