//! What the filter keeps and what it takes away.

use photonfarm::estimate::denoise::{DenoiseError, Denoised, denoise};

use crate::synthetic::{Synthetic, mean, synthetic};

fn denoised(synthetic: &Synthetic) -> Denoised {
    denoise(&synthetic.twins, &synthetic.features).expect("it can be denoised")
}

#[test]
fn a_constant_picture_stays() {
    let flat = synthetic([70, 30], |_, _| 3.0, |_, _| 0.5, |_, _| 0.0);
    let Denoised { picture, standard_error, relmse } = denoised(&flat);
    assert!(flat.squared_error(&picture.radiance, |_, _| true).sqrt() < 1e-5);
    assert!(relmse.abs() < 1e-10 && standard_error.iter().all(|error| *error < 1e-5), "{relmse}");
}

/// A window has 225 pixels; weights are not even, and the choice follows some of the noise.
#[test]
fn noise_falls_where_nothing_else_changes() {
    let noisy = |x: usize| if x < 48 { 0.1 } else { 0.4 };
    let flat = synthetic([96, 64], |_, _| 1.0, |_, _| 0.5, |x, _| noisy(x));
    let Denoised { picture, .. } = denoised(&flat);
    for (side, left) in [("left", true), ("right", false)] {
        let counts = |x: usize, _: usize| if left { x < 40 } else { x >= 56 };
        let [raw, new] = [&flat.raw(), &picture.radiance].map(|radiance| flat.squared_error(radiance, counts));
        let expected = (if left { 0.1f64 } else { 0.4 }).powi(2) / 2.0;
        assert!((raw / expected - 1.0).abs() < 0.1, "{side}: {raw} where {expected} was made");
        assert!(new < raw / 40.0, "{side}: {new} of {raw}");
    }
    let [raw, new] = [&flat.raw(), &picture.radiance].map(|radiance| mean(radiance));
    // The standard error of the raw mean is 0.4/√(2·3·96·64) at most.
    assert!((raw - new).abs() < 4.0 * 0.4 / (6.0f64 * 96.0 * 64.0).sqrt(), "{raw} became {new}");
}

#[test]
fn an_edge_between_colors_of_surfaces_stays() {
    let is_left = |x: usize| x < 32;
    let color = |x: usize, _: usize| if is_left(x) { 0.3 } else { 1.0 };
    let albedo = |x: usize, _: usize| if is_left(x) { 0.2 } else { 0.8 };
    let edge = synthetic([64, 48], color, albedo, |_, _| 0.3);
    let Denoised { picture, .. } = denoised(&edge);
    let beside = |x: usize, _: usize| x == 31 || x == 32;
    let [raw, new] = [&edge.raw(), &picture.radiance].map(|radiance| edge.squared_error(radiance, beside));
    assert!(new < raw / 10.0, "{new} of {raw}");
    let of_column =
        |column: usize| mean(&picture.radiance.iter().skip(column).step_by(64).copied().collect::<Vec<_>>());
    let step = of_column(32) - of_column(31);
    assert!((step / (0.7 * 0.8) - 1.0).abs() < 0.1, "the step of {} became {step}", 0.7 * 0.8);
}

#[test]
fn a_texture_that_features_know_stays() {
    let stripes = |x: usize, y: usize| if (x + y) % 4 < 2 { 0.2 } else { 0.8 };
    let texture = synthetic([64, 64], stripes, stripes, |_, _| 0.2);
    let Denoised { picture, .. } = denoised(&texture);
    let [raw, new] = [&texture.raw(), &picture.radiance].map(|radiance| texture.squared_error(radiance, |_, _| true));
    assert!(new < raw / 10.0, "{new} of {raw}");
}

#[test]
fn an_outlier_keeps_its_energy_and_is_spread() {
    let mut flat = synthetic([64, 64], |_, _| 1.0, |_, _| 0.5, |_, _| 0.2);
    for channel in &mut flat.twins.radiance[1] {
        channel[32 * 64 + 32] = 1e5;
    }
    let Denoised { picture, standard_error, relmse } = denoised(&flat);
    assert!(picture.radiance.iter().flatten().all(|value| value.is_finite() && *value >= 0.0));
    assert!(relmse.is_finite() && standard_error.iter().all(|error| error.is_finite()));
    let [raw, new] = [&flat.raw(), &picture.radiance].map(|radiance| mean(radiance));
    assert!((new / raw - 1.0).abs() < 0.2, "{raw} became {new}");
    let brightest = picture.radiance.iter().flatten().fold(0.0f32, |most, value| most.max(*value));
    assert!(brightest < 1e5 / 2.0 / 20.0, "{brightest}");
}

#[test]
fn black_pictures_stay_and_what_is_no_picture_is_refused() {
    let mut black = synthetic([20, 10], |_, _| 0.0, |_, _| 0.0, |_, _| 0.0);
    let Denoised { picture, standard_error, relmse } = denoised(&black);
    assert!(picture.radiance.iter().flatten().chain(&standard_error).all(|value| *value == 0.0) && relmse == 0.0);
    black.twins.radiance[0][1][7] = f32::INFINITY;
    assert_eq!(denoise(&black.twins, &black.features), Err(DenoiseError::NotFinite));
    black.twins.radiance[0][1].pop();
    let wrong = DenoiseError::WrongSize { what: "even twin", found: 199, expected: 200 };
    assert_eq!(denoise(&black.twins, &black.features), Err(wrong));
}

/// Bright and dark parts, noise in proportion, an edge and a slope.
fn room() -> Synthetic {
    let color = |x: usize, y: usize| if y < 40 { 0.2 + x as f32 / 60.0 } else { 0.05 };
    let albedo = |_: usize, y: usize| if y < 40 { 0.7 } else { 0.1 };
    synthetic([130, 70], color, albedo, move |x, y| 0.3 * color(x, y))
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let room = room();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| denoised(&room))
    };
    let [one, four] = [on(1), on(4)];
    assert_eq!(one.relmse.to_bits(), four.relmse.to_bits());
    let bits = |denoised: &Denoised| {
        let values = denoised.picture.radiance.iter().flatten().chain(&denoised.standard_error);
        values.map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    assert!(bits(&one) == bits(&four));
}

#[test]
fn the_error_that_is_told_is_about_right() {
    let room = room();
    let Denoised { picture, standard_error, relmse } = denoised(&room);
    let truth = |pixel: usize| (0..3).map(|c| f64::from(room.truth[c][pixel])).sum::<f64>() / 3.0;
    let count = standard_error.len();
    let floor = 1e-3 * ((0..count).map(truth).sum::<f64>() / count as f64).powi(2);
    let error = |pixel: usize| {
        let square = (0..3).map(|c| f64::from(picture.radiance[pixel][c] - room.truth[c][pixel]).powi(2)).sum::<f64>();
        square / 3.0 / (truth(pixel).powi(2) + floor)
    };
    let exact = (0..count).map(error).sum::<f64>() / count as f64;
    assert!((0.4..2.5).contains(&(relmse / exact)), "told {relmse}, found {exact}");
    let told = standard_error.iter().map(|error| f64::from(*error).powi(2)).sum::<f64>() / count as f64;
    let found = room.squared_error(&picture.radiance, |_, _| true);
    assert!((0.4..2.5).contains(&(told / found)), "told {told}, found {found}");
}
