//! EXR files of 16-bit floats: what they round, and what they leave alone.

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::meta::MetaData;
use exr::prelude::SampleType;
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::{
    LAYERS, Layer, PictureLayer, PictureMetadata, decode_exr, encode_exr, encode_half_exr,
};

use crate::exr_channels::exr_channels;

const PIXELS: usize = 48 * 16;

/// From 1e-6 to 3e4, both signs.
fn value(pixel: usize) -> f32 {
    let sign = if pixel.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * 1e-6 * 10f32.powf(10.48 * pixel as f32 / PIXELS as f32)
}

fn picture() -> Picture {
    Picture {
        width: 48,
        height: 16,
        radiance: (0..PIXELS).map(|pixel| [value(pixel), 0.1, value(PIXELS - 1 - pixel)]).collect(),
    }
}

fn all_layers() -> Vec<PictureLayer> {
    let channel = |first: usize| (0..PIXELS).map(|pixel| value((pixel + first) % PIXELS)).collect();
    let layer = |layer: Layer, channels: usize| {
        let light_groups = if layer == Layer::LightGroups { vec!["NAME".to_owned()] } else { Vec::new() };
        PictureLayer { light_groups, ..PictureLayer::new(layer, (0..channels).map(channel).collect()) }
    };
    LAYERS.iter().map(|row| layer(row.layer, row.channels.len())).collect()
}

fn types(bytes: &[u8]) -> BTreeMap<String, SampleType> {
    let file = MetaData::read_from_buffered(Cursor::new(bytes), false).expect("an EXR");
    let channels = file.headers[0].channels.list.iter();
    channels.map(|channel| (channel.name.to_string(), channel.sample_type)).collect()
}

/// IEEE 754 binary16: 11 significant bits, and steps of 2^-24 below 2^-14.
fn assert_half(found: f32, exact: f32) {
    let step = (exact.abs() / 2048.0).max(1.0 / f32::powi(2.0, 25));
    assert!((found - exact).abs() <= step, "{found} for {exact}");
}

#[test]
fn colors_and_directions_are_rounded_and_all_else_keeps_its_bits() {
    let (picture, layers) = (picture(), all_layers());
    let exact = encode_exr(&picture, &layers, &PictureMetadata::default()).expect("encodes");
    let half = encode_half_exr(&picture, &layers, &PictureMetadata::default()).expect("encodes");
    assert!(half.len() < exact.len());
    assert!(types(&exact).values().all(|kind| *kind == SampleType::F32));
    let (types, expected) = (types(&half), exr_channels(&exact));
    for (name, values) in exr_channels(&half) {
        let is_color = ["R", "G", "B"].contains(&name.as_str());
        if is_color || ["albedo.", "normal.", "denoised.", "light_group."].iter().any(|layer| name.starts_with(layer)) {
            assert_eq!(types[&name], SampleType::F16, "{name}");
            values.iter().zip(&expected[&name]).for_each(|(found, exact)| assert_half(*found, *exact));
            assert!(values != expected[&name], "{name} is not rounded");
        } else {
            assert_eq!((types[&name], &values), (SampleType::F32, &expected[&name]), "{name}");
        }
    }
    let decoded = decode_exr(&half).expect("decodes");
    decoded.radiance.iter().flatten().zip(picture.radiance.iter().flatten()).for_each(|(a, b)| assert_half(*a, *b));
}

/// 65504 is the largest number; what rounds to it still fits.
#[test]
fn a_layer_with_larger_numbers_stays_at_32_bits() {
    let with = |brightest: f32| {
        let mut picture = picture();
        picture.radiance[7][1] = brightest;
        let bytes = encode_half_exr(&picture, &all_layers(), &PictureMetadata::default()).expect("encodes");
        let types = types(&bytes);
        assert_eq!(types["R"], types["B"], "a picture has one precision");
        assert_eq!(types["albedo.R"], SampleType::F16, "another layer is none of its business");
        (types["G"], exr_channels(&bytes)["G"][7])
    };
    assert_eq!(with(65504.0), (SampleType::F16, 65504.0));
    assert_eq!(with(65519.0), (SampleType::F16, 65504.0));
    assert_eq!(with(65520.0), (SampleType::F32, 65520.0));
    assert_eq!(with(-1e30), (SampleType::F32, -1e30));
    assert_eq!(with(f32::INFINITY), (SampleType::F16, f32::INFINITY));
    let (kind, found) = with(f32::NAN);
    assert!(kind == SampleType::F16 && found.is_nan());
}

#[test]
fn half_bytes_are_the_same_every_time() {
    let encode = || encode_half_exr(&picture(), &all_layers(), &PictureMetadata::default()).expect("encodes");
    let first = encode();
    assert!((0..10).all(|_| encode() == first));
}
