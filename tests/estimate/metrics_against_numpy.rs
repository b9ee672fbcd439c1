//! The error metrics against figures that independent programs computed for the same made-up pictures: numpy, SSIM by scikit-image 0.26
//! (Gaussian weights, σ = 1.5), FLIP by NVIDIA's `flip_evaluator` 1.7, which calculates in single precision.

use photonfarm::estimate::Picture;
use photonfarm::evaluation::{CompareError, compare};

const WIDTH: u32 = 30;
const HEIGHT: u32 = 45;

fn picture(value: impl Fn(u32, usize) -> f32) -> Picture {
    let pixel = |index: u32| [0, 1, 2].map(|channel| value(index, channel));
    Picture { width: WIDTH, height: HEIGHT, radiance: (0..WIDTH * HEIGHT).map(pixel).collect() }
}

fn reference_value(index: u32, channel: usize) -> f32 {
    let i = u64::from(index) * 3 + channel as u64;
    ((i * 7919 % 1000) + 1) as f32 / 512.0
}

fn image_value(index: u32, channel: usize) -> f32 {
    let i = u64::from(index) * 3 + channel as u64;
    match index == 3 * WIDTH + 5 {
        true => [40.0, 2.0, 7.0][channel],
        false => reference_value(index, channel) + ((i * 104_729 % 201) as f32 - 90.0) / 4096.0,
    }
}

fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found} where numpy has {expected}");
}

#[test]
fn every_metric_equals_numpys() {
    let standard_error = picture(|index, _| (index % 17) as f32 / 1024.0);
    let metrics = compare(&picture(image_value), &picture(reference_value), Some(&standard_error)).expect("same size");
    assert_close(metrics.rmse, 0.6068744263197211);
    assert_close(metrics.rel_rmse, 0.6211863366364685);
    assert_close(metrics.relmse, 0.13898189438987388);
    assert_close(metrics.relmse_trimmed, 0.0006240759456632025);
    assert_close(metrics.bias, 0.013628953636172976);
    assert_close(metrics.bias_rgb[0], 0.031188159111933178);
    assert_close(metrics.bias_rgb[1], 0.0030262133402543245);
    assert_close(metrics.bias_rgb[2], 0.00665439952657465);
    assert_close(metrics.block_bias_max, 0.2341905834851852);
    let noise = metrics.reference_noise.expect("a standard error was given");
    assert_close(noise.rmse, 0.009140703829491519);
    assert_close(noise.relmse, 0.00025916237272969743);
    assert_close(noise.relmse_left, 0.13898189438987388 - 0.00025916237272969743);
    assert_close(noise.mse_left, 0.6068744263197211f64.powi(2) - 0.009140703829491519f64.powi(2));
    assert_near(metrics.ssim.expect("the pictures are large enough"), 0.999089338692942, 1e-8);
    assert_near(metrics.flip, 0.01404221449047327, 1e-5);
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} where {expected} is expected");
}

/// Smooth stripes of several colors, shifted and with more blue where `changed`.
fn stripes(changed: bool) -> Picture {
    picture(|index, channel| {
        let (x, y) = (index % WIDTH, index / WIDTH);
        let period = 24 + channel as u32;
        let phase = (x * 3 + y * channel as u32 + if changed { 2 } else { 0 }) % period;
        let wave = (2.0 * f64::from(phase) - f64::from(period)).abs() / f64::from(period);
        let factor = if changed && channel == 2 { 1.2 } else { 1.0 };
        (0.25 + wave * 0.75 * factor) as f32
    })
}

#[test]
fn similarity_to_the_eye_is_that_of_other_programs() {
    let metrics = compare(&stripes(true), &stripes(false), None).expect("same size");
    assert_near(metrics.ssim.expect("the pictures are large enough"), 0.8624810426053074, 1e-8);
    assert_near(metrics.flip, 0.20235279202461243, 1e-4);
    let small = Picture { width: 10, height: 20, radiance: vec![[1.0; 3]; 200] };
    assert_eq!(compare(&small, &small, None).expect("same size").ssim, None, "no window fits");
}

#[test]
fn a_picture_equals_itself() {
    let reference = picture(reference_value);
    let metrics = compare(&reference, &reference, None).expect("same size");
    assert_eq!((metrics.rmse, metrics.relmse, metrics.bias, metrics.block_bias_max), (0.0, 0.0, 0.0, 0.0));
    assert_eq!((metrics.ssim, metrics.flip, metrics.reference_noise), (Some(1.0), 0.0, None));
}

#[test]
fn different_sizes_are_an_error() {
    let small = Picture { width: 1, height: 2, radiance: vec![[1.0; 3]; 2] };
    let error = compare(&small, &picture(reference_value), None).expect_err("sizes differ");
    assert!(matches!(error, CompareError::SizeMismatch { what: "image", .. }));
    assert!(error.to_string().contains("1 × 2"), "{error}");
}

#[test]
fn a_pixel_without_a_value_is_an_error_that_names_it() {
    let good = picture(reference_value);
    let (column, row) = (5, 2);
    for value in [f32::INFINITY, f32::NAN] {
        let mut bad = good.clone();
        bad.radiance[row * good.width as usize + column][1] = value;
        for (what, result) in [
            ("image", compare(&bad, &good, None)),
            ("reference", compare(&good, &bad, None)),
            ("standard error", compare(&good, &good, Some(&bad))),
        ] {
            let text = result.expect_err("nothing can be measured").to_string();
            let expected = [what, &value.to_string(), "column 5, row 2"];
            assert!(expected.iter().all(|part| text.contains(part)), "{text}");
        }
    }
}
