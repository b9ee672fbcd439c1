//! Pictures to look at: tone curves against their sources, exposures against their formula, formats through real decoders.

use image::{DynamicImage, ImageFormat};
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::{
    Display, DisplayFormat, Exposure, JPEG_QUALITY, TONES, ToneCurve, encode_display, encode_png,
};

fn row(radiance: Vec<[f32; 3]>) -> Picture {
    Picture { width: radiance.len() as u32, height: 1, radiance }
}

fn grey(luminances: &[f32]) -> Picture {
    row(luminances.iter().map(|luminance| [*luminance; 3]).collect())
}

/// Colors that change slowly, brighter than 1 towards the right.
fn gradient() -> Picture {
    let pixel = |index: u32| {
        let (x, y) = ((index % 64) as f32 / 64.0, (index / 64) as f32 / 48.0);
        [1.5 * x, y, 0.5 * (1.0 - x)]
    };
    Picture { width: 64, height: 48, radiance: (0..64 * 48).map(pixel).collect() }
}

fn decoded(bytes: &[u8], format: ImageFormat) -> DynamicImage {
    image::load_from_memory_with_format(bytes, format).expect("decodes")
}

fn encoded(picture: &Picture, tone: ToneCurve, format: DisplayFormat) -> Vec<u8> {
    encode_display(picture, Display { tone, ..Display::default() }, format).expect("encodes")
}

fn assert_close(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let is_close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= tolerance);
    assert!(is_close, "{found:?} for {expected:?}");
}

#[test]
fn tones_are_found_by_name() {
    for (index, row) in TONES.iter().enumerate() {
        assert_eq!(row.tone as usize, index, "the table has the order of the kinds");
        assert_eq!(row.tone.row().name, row.name);
    }
    assert_eq!(TONES[0].tone, ToneCurve::default());
}

/// Values of IEC 61966-2-1.
#[test]
fn linear_is_srgb() {
    let values = ToneCurve::Linear.code_values([0.18, 0.001, 0.5]);
    assert_close(values, [0.461_356, 0.012_92, 0.735_357], 1e-5);
}

/// Values of the published polynomials, computed elsewhere in double precision: middle grey gets darker, 11.2 / 2 is white.
#[test]
fn filmic_is_the_published_curve() {
    let srgb = |linear: f32| ToneCurve::Linear.code_values([linear; 3])[0];
    let filmic = |linear: f32| ToneCurve::Filmic.code_values([linear; 3])[0];
    for (linear, expected) in [(0.0, 0.0), (0.01, 0.007_663_66), (0.18, 0.128_338_45), (1.0, 0.492_918_55), (5.6, 1.0)]
    {
        assert!((filmic(linear) - srgb(expected)).abs() < 2e-5, "{linear}: {}", filmic(linear));
    }
    assert_eq!([filmic(100.0), filmic(f32::INFINITY)], [filmic(5.6); 2]);
    assert_eq!(filmic(-1.0), filmic(0.0));
}

/// Values of the published matrix, logarithm and sigmoid, computed elsewhere in double precision.
#[test]
fn agx_is_the_published_transform() {
    for (color, expected) in [
        // Middle grey goes to 0.5 of the display's code values.
        ([0.18, 0.18, 0.18], [0.500_024, 0.499_994, 0.499_992]),
        ([1.0, 1.0, 1.0], [0.787_535, 0.787_510, 0.787_508]),
        ([0.001, 0.001, 0.001], [0.015_156, 0.015_154, 0.015_154]),
        ([1.0, 0.0, 0.0], [0.761_799, 0.256_303, 0.256_471]),
        ([0.02, 0.4, 3.0], [0.580_856, 0.704_774, 0.905_135]),
        ([0.0, 0.0, 8.0], [0.716_611, 0.716_492, 0.970_568]),
        ([-1.0, 0.5, 0.25], [0.308_469, 0.662_688, 0.563_614]),
        ([0.0, -1.0, f32::NAN], [0.0, 0.0, 0.0]),
        ([1e6, 1e6, f32::INFINITY], [1.0, 1.0, 1.0]),
    ] {
        assert_close(ToneCurve::Agx.code_values(color), expected, 1e-5);
    }
}

/// The sixth-order polynomial of [Wrensch 2023] was fitted to the same curve by somebody else, with a mean squared error of 4e-6 by its own account.
#[test]
fn agx_agrees_with_its_published_fit() {
    let fit = [-0.002_32, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
    let mut squares = 0.0;
    for step in 0..=200 {
        let x = f64::from(step) / 200.0;
        let polynomial = fit.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
        let luminance = 0.18 * f64::exp2(16.5 * x - 10.0);
        let found = f64::from(ToneCurve::Agx.code_values([luminance as f32; 3])[1]);
        assert!((found - polynomial).abs() < 0.006, "{x}: {found}, {polynomial}");
        squares += (found - polynomial).powi(2) / 201.0;
    }
    assert!(squares < 9e-6, "{squares}");
}

#[test]
fn every_tone_grows_with_light() {
    for tone in TONES {
        let mut last = [-1.0; 3];
        for step in -1400..=900 {
            let luminance = f32::exp2(step as f32 / 100.0);
            let found = tone.tone.code_values([luminance; 3]);
            assert!((0..3).all(|channel| found[channel] >= last[channel]), "{} at {luminance}: {found:?}", tone.name);
            last = found;
        }
        assert!(last.iter().all(|value| *value >= 0.999_99), "{}: {last:?}", tone.name);
    }
}

/// A color keeps the order of its channels however bright it is, and ends in white. Clipped colors do not: orange becomes yellow.
#[test]
fn agx_does_not_turn_hues_when_it_clips() {
    for color in [[1.0, 0.3, 0.02], [0.02, 1.0, 0.3], [0.3, 0.02, 1.0], [1.0, 0.02, 0.3], [0.0, 0.2, 1.0]] {
        let order = |values: [f32; 3]| {
            let mut channels = [0, 1, 2];
            channels.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
            channels
        };
        let mut colorfulness = f32::INFINITY;
        for stops in -6..=14 {
            let found = ToneCurve::Agx.code_values(color.map(|channel| channel * f32::exp2(stops as f32)));
            let [most, middle, least] = order(color).map(|channel| found[channel]);
            assert!(most >= middle && middle >= least, "{color:?} at {stops} stops: {found:?}");
            assert!(most < 1.0 || stops > 3, "{color:?} is clipped at {stops} stops already");
            if stops >= 2 {
                assert!(most - least <= colorfulness, "{color:?} at {stops} stops: {found:?}");
                colorfulness = most - least;
            }
        }
        assert!(colorfulness < 0.01, "{color:?} ends in white");
    }
    let clipped = ToneCurve::Linear.code_values([16.0, 4.8, 0.32]).map(|value| value.min(1.0));
    assert_eq!(clipped[0], clipped[1]);
}

#[test]
fn automatic_exposure_is_the_key_over_the_log_average() {
    let close = |found: f32, expected: f32| assert!((found / expected - 1.0).abs() < 1e-5, "{found} for {expected}");
    for luminance in [1e-5, 0.02, 0.18, 7.0, 1e6] {
        close(Exposure::Auto.factor(&grey(&[luminance; 50])), 0.18 / luminance);
    }
    // The geometric mean of 0.1 and 10 is 1.
    close(Exposure::Auto.factor(&grey(&[0.1, 10.0].repeat(50))), 0.18);
    // Luminance weighs channels as Rec. 709 does.
    close(Exposure::Auto.factor(&row(vec![[1.0, 0.0, 0.0]; 9])), 0.18 / 0.2126);
}

#[test]
fn automatic_exposure_withstands_black_and_fireflies() {
    let scene: Vec<f32> = (0..1000).map(|pixel| 0.1 + pixel as f32 / 1000.0).collect();
    let plain = Exposure::Auto.factor(&grey(&scene));
    let with = |further: f32, count: usize| {
        Exposure::Auto.factor(&grey(&[scene.as_slice(), &vec![further; count]].concat())) / plain
    };
    // What has no light or no number is left out, however much of it there is.
    for nothing in [0.0, -0.5, f32::NAN, f32::INFINITY, 1e-42] {
        assert_eq!(with(nothing, 5000), 1.0, "{nothing}");
    }
    for firefly in [1e3, 1e9, 1e38] {
        assert!((with(firefly, 8) - 1.0).abs() < 0.01, "{firefly}: {}", with(firefly, 8));
    }
    assert!((with(1e-30, 8) - 1.0).abs() < 0.02, "{}", with(1e-30, 8));
}

#[test]
fn a_black_picture_stays_black_under_automatic_exposure() {
    let black = grey(&[0.0; 4]);
    assert_eq!(Exposure::Auto.factor(&black), 1.0);
    let display = Display { exposure: Exposure::Auto, ..Display::default() };
    let png = encode_display(&black, display, DisplayFormat::Png).expect("encodes");
    assert!(decoded(&png, ImageFormat::Png).to_rgb8().iter().all(|byte| *byte == 0));
}

#[test]
fn exposures_are_stops_or_auto() {
    assert_eq!("auto".parse(), Ok(Exposure::Auto));
    assert_eq!("-1.5".parse(), Ok(Exposure::Stops(-1.5)));
    assert!("bright".parse::<Exposure>().expect_err("no number").to_string().contains("auto"));
    for exposure in [Exposure::Auto, Exposure::Stops(0.1), Exposure::Stops(-64.0)] {
        assert_eq!(exposure.to_string().parse(), Ok(exposure));
        assert!(exposure.is_possible());
    }
    for stops in [64.1, -65.0, f32::NAN, f32::INFINITY] {
        assert!(!Exposure::Stops(stops).is_possible(), "{stops}");
    }
    assert_eq!(Exposure::Stops(3.0).factor(&grey(&[5.0])), 8.0);
}

/// Whoever asks for nothing new gets the file of before.
#[test]
fn the_default_is_the_plain_png() {
    let picture = gradient();
    let plain = encode_png(&picture, 0.0).expect("encodes");
    assert!(encoded(&picture, ToneCurve::Linear, DisplayFormat::Png) == plain);
    assert!(encoded(&picture, ToneCurve::Agx, DisplayFormat::Png) != plain);
}

#[test]
fn png_of_16_bits_has_their_code_values() {
    let picture = row(vec![[0.5, 0.18, 1.0 / 3.0], [-1.0, 1.0, 70.0]]);
    let png = encoded(&picture, ToneCurve::Linear, DisplayFormat::Png16);
    let DynamicImage::ImageRgb16(found) = decoded(&png, ImageFormat::Png) else { panic!("16 bits") };
    let pixel = |x: u32, expected: [u16; 3]| {
        let close = found.get_pixel(x, 0).0.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= 1);
        assert!(close, "{:?} for {expected:?}", found.get_pixel(x, 0));
    };
    pixel(0, [48192, 30235, 40140]);
    pixel(1, [0, 65535, 65535]);
    let wrong = encoded(&grey(&[f32::NAN]), ToneCurve::Filmic, DisplayFormat::Png16);
    assert!(decoded(&wrong, ImageFormat::Png).into_rgb16().iter().all(|value| *value == 0), "no number is black");
    // The same picture in fewer bits.
    let (picture, tone) = (gradient(), ToneCurve::Filmic);
    let fine = decoded(&encoded(&picture, tone, DisplayFormat::Png16), ImageFormat::Png).into_rgb16();
    let coarse = decoded(&encoded(&picture, tone, DisplayFormat::Png), ImageFormat::Png).into_rgb8();
    let close = |(fine, coarse): (&u16, &u8)| fine.abs_diff(u16::from(*coarse) * 257) <= 129;
    assert!(fine.iter().zip(coarse.iter()).all(close));
}

#[test]
fn webp_loses_nothing() {
    let picture = gradient();
    for row in TONES {
        let webp = encoded(&picture, row.tone, DisplayFormat::Webp);
        let png = encoded(&picture, row.tone, DisplayFormat::Png);
        let [webp, png] =
            [decoded(&webp, ImageFormat::WebP), decoded(&png, ImageFormat::Png)].map(|file| file.to_rgb8());
        assert!(webp == png, "{}", row.name);
    }
}

#[test]
fn jpeg_loses_little_and_less_with_more_quality() {
    let picture = gradient();
    let exact = decoded(&encoded(&picture, ToneCurve::Agx, DisplayFormat::Png), ImageFormat::Png).to_rgb8();
    let loss = |quality: u8| {
        let jpeg = encoded(&picture, ToneCurve::Agx, DisplayFormat::Jpeg { quality });
        let found = decoded(&jpeg, ImageFormat::Jpeg).to_rgb8();
        assert_eq!(found.dimensions(), (64, 48));
        let squares = found.iter().zip(exact.iter()).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        (jpeg.len(), (squares.sum::<f64>() / exact.len() as f64).sqrt())
    };
    let [(small, coarse), (usual, fine), (large, finest)] = [10, JPEG_QUALITY, 100].map(loss);
    assert!(small < usual && usual < large, "{small}, {usual}, {large} bytes");
    assert!(coarse > fine && fine > finest && fine < 3.0, "{coarse}, {fine}, {finest} of 255");
    for quality in [0, 101] {
        let format = DisplayFormat::Jpeg { quality };
        let error = encode_display(&picture, Display::default(), format).expect_err("no such quality");
        assert!(error.to_string().contains("1 to 100"), "{error}");
    }
}

#[test]
fn a_picture_that_a_format_cannot_number_is_an_error() {
    let long = Picture { width: 70_000, height: 1, radiance: vec![[0.5; 3]; 70_000] };
    for format in [DisplayFormat::Jpeg { quality: 90 }, DisplayFormat::Webp] {
        assert!(format.largest_side() < long.width);
        encode_display(&long, Display::default(), format).expect_err("too long");
    }
    let png = encoded(&long, ToneCurve::Linear, DisplayFormat::Png);
    assert_eq!(decoded(&png, ImageFormat::Png).width(), 70_000);
}

#[test]
fn display_bytes_are_the_same_every_time() {
    let display = Display { exposure: Exposure::Auto, tone: ToneCurve::Agx };
    let formats = [DisplayFormat::Png, DisplayFormat::Png16, DisplayFormat::Jpeg { quality: 75 }, DisplayFormat::Webp];
    for format in formats {
        let encode = || encode_display(&gradient(), display, format).expect("encodes");
        assert!(encode() == encode(), "{format:?}");
    }
}
