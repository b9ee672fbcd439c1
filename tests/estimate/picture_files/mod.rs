//! Picture files: what is written can be read again, is always the same, and never replaces a good file by half a one.

mod camera_matrices;
mod cryptomatte;
mod display;
mod exr_header;
mod half_precision;

use std::path::Path;

use crate::exr_channels::exr_channels;
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::{
    LAYERS, Layer, LayerRow, NOTHING_SEEN, PictureFileError, PictureFormat, PictureLayer, PictureMetadata,
    UnknownLayer, check_writable, decode_channels, decode_exr, encode_exr, encode_png, read_exr, read_standard_error,
    write_file,
};

fn picture() -> Picture {
    let pixel = |i: u32| [i as f32 * 0.01, 1.0 / (i + 1) as f32, (i * i) as f32];
    Picture { width: 37, height: 23, radiance: (0..37 * 23).map(pixel).collect() }
}

fn metadata() -> PictureMetadata {
    let mut parameters = serde_json::Map::new();
    parameters.insert("alpha".to_owned(), 0.7.into());
    parameters.insert("note".to_owned(), "größer".into());
    PictureMetadata {
        job: "job-1".to_owned(),
        method: "sppm".to_owned(),
        parameters,
        passes: 12,
        photons_emitted: u64::MAX,
        seed: 3,
        scene: "ab".repeat(32),
        ..PictureMetadata::default()
    }
}

#[test]
fn exr_keeps_every_bit_and_the_layers() {
    let values = |row: &LayerRow| (0..row.channels.len()).map(|channel| vec![channel as f32 + 0.5; 37 * 23]).collect();
    let layer = |row: LayerRow| {
        let light_groups = if row.layer == Layer::LightGroups { vec!["NAME".to_owned()] } else { Vec::new() };
        PictureLayer { layer: row.layer, channels: values(&row), light_groups }
    };
    let layers = LAYERS.map(layer);
    let bytes = encode_exr(&picture(), &layers, &metadata()).expect("encodes");
    assert_eq!(decode_exr(&bytes).expect("decodes"), picture());
    let found = exr_channels(&bytes);
    assert_eq!(found.len(), 3 + LAYERS.iter().map(|row| row.channels.len()).sum::<usize>());
    for (index, channel) in LAYERS.iter().flat_map(|row| row.channels.iter().enumerate()) {
        assert_eq!(found[*channel], vec![index as f32 + 0.5; 37 * 23], "{channel}");
    }
}

#[test]
fn layers_are_found_by_name() {
    for (index, row) in LAYERS.iter().enumerate() {
        assert_eq!((row.layer as usize, row.layer.row()), (index, row), "the table has the order of the kinds");
        assert_eq!(Layer::parse_list(row.name), Ok(vec![row.layer]));
    }
    assert_eq!(Layer::parse_list(" depth, radius,,depth"), Ok(vec![Layer::Radius, Layer::Depth]));
    assert_eq!(Layer::parse_list(""), Ok(Vec::new()));
    assert_eq!(Layer::parse_list("radius,detph"), Err(UnknownLayer("detph".to_owned())));
}

#[test]
fn channels_are_read_by_the_names_of_layers() {
    let layers = [
        PictureLayer::new(Layer::Depth, vec![[vec![2.0; 850], vec![NOTHING_SEEN]].concat()]),
        PictureLayer::new(Layer::Albedo, vec![vec![1.0; 851], vec![0.5; 851], vec![0.25; 851]]),
        PictureLayer::new(Layer::Normal, vec![vec![0.0; 851], vec![-1.0; 851], vec![1.0; 851]]),
    ];
    let bytes = encode_exr(&picture(), &layers, &metadata()).expect("encodes");
    let channels = decode_channels(&bytes).expect("decodes");
    assert_eq!((channels.width, channels.height), (37, 23));
    assert_eq!(channels.layer_names(), ["luminance", "albedo", "depth", "normal.X", "normal.Y", "normal.Z"]);
    let depth = channels.layer("depth").expect("the layer");
    assert_eq!((depth.values[0], depth.values[850].is_nan(), depth.unit), (2.0, true, "m"));
    let close = |found: f32, expected: f32| assert!((found - expected).abs() < 1e-5 * expected, "{found}, {expected}");
    close(channels.layer("albedo").expect("the layer").values[3], 0.2126 + 0.5 * 0.7152 + 0.25 * 0.0722);
    close(channels.layer("luminance").expect("the picture").values[0], 0.7152);
    assert_eq!(channels.layer("R").expect("a channel").values[5], 5.0 * 0.01);
    assert_eq!(channels.layer("normal.Y").expect("a channel").values, vec![-1.0; 851]);
    for name in ["normal", "radius", "albedo.X", ""] {
        let error = channels.layer(name).expect_err("no such layer").to_string();
        assert!(error.contains(name) && error.contains("luminance, albedo, depth, normal.X"), "{error}");
    }
    // Another program's picture of one channel.
    let noise = std::fs::read("tests/references/cornell-glass/stderr.exr").expect("a reference");
    let noise = decode_channels(&noise).expect("decodes");
    assert_eq!(noise.layer("luminance").expect("grey").values.len(), 128 * 128);
}

/// Groups have channels of their own, in the order in which they are given.
#[test]
fn light_groups_are_layers_of_their_own() {
    let light_groups = vec!["key".to_owned(), "others".to_owned()];
    let channels: Vec<Vec<f32>> = (0..6).map(|channel| vec![channel as f32; 851]).collect();
    let layer = PictureLayer { layer: Layer::LightGroups, channels, light_groups };
    let bytes = encode_exr(&picture(), &[layer], &metadata()).expect("encodes");
    let channels = decode_channels(&bytes).expect("decodes");
    assert_eq!(channels.layer_names(), ["luminance", "light_group.key", "light_group.others"]);
    let found = exr_channels(&bytes);
    for (index, name) in ["key.R", "key.G", "key.B", "others.R", "others.G", "others.B"].iter().enumerate() {
        assert_eq!(found[&format!("light_group.{name}")], vec![index as f32; 851], "{name}");
    }
    let key = channels.layer("light_group.key").expect("the layer");
    assert!((key.values[7] - (0.7152 + 2.0 * 0.0722)).abs() < 1e-5 && key.unit == "W/(sr·m²)", "{}", key.values[7]);
    let wrong =
        PictureLayer { light_groups: vec!["key".to_owned()], ..PictureLayer::new(Layer::LightGroups, Vec::new()) };
    let error = encode_exr(&picture(), &[wrong], &metadata()).expect_err("no channel for three").to_string();
    assert!(error.contains("light_groups has 0 channels where 3 belong"), "{error}");
}

/// A picture whose layer `error` is known brings its own noise; a look at a job that has just begun does not.
#[test]
fn pictures_bring_their_standard_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("picture.exr");
    let found = |errors: Option<Vec<f32>>| {
        let layers = errors.map(|errors| PictureLayer::new(Layer::Error, vec![errors]));
        let bytes = encode_exr(&picture(), layers.as_slice(), &metadata()).expect("encodes");
        write_file(&path, &bytes).expect("writes");
        read_standard_error(&path).expect("reads")
    };
    let errors: Vec<f32> = (0..851).map(|pixel| pixel as f32).collect();
    let known = found(Some(errors.clone())).expect("the layer");
    assert_eq!((known.width, known.height), (37, 23));
    assert!(known.radiance.iter().zip(errors).all(|(pixel, error)| *pixel == [error; 3]));
    assert_eq!(found(Some(vec![f32::NAN; 851])), None);
    assert_eq!(found(None), None);
}

#[test]
fn exr_header_tells_the_job() {
    let bytes = encode_exr(&picture(), &[], &metadata()).expect("encodes");
    let header = String::from_utf8_lossy(&bytes[..2000.min(bytes.len())]).into_owned();
    for expected in ["photonfarm.job", "job-1", "sppm", r#"{"alpha":0.7,"note":"gr\u00f6\u00dfer"}"#] {
        assert!(header.contains(expected), "{expected}");
    }
    assert!(header.contains(&u64::MAX.to_string()));
}

#[test]
fn exr_bytes_are_the_same_every_time() {
    let encode = || encode_exr(&picture(), &[], &metadata()).expect("encodes");
    let first = encode();
    // The attributes pass through a hash map with a random order per map.
    assert!((0..20).all(|_| encode() == first));
}

#[test]
fn exr_with_a_wrong_layer_or_no_pixels_is_refused() {
    let layer = |layer, channels| [PictureLayer::new(layer, channels)];
    let error = encode_exr(&picture(), &layer(Layer::Radius, vec![vec![0.5; 3]]), &metadata());
    let error = error.expect_err("three radii for 851 pixels");
    assert!(error.to_string().contains("radius.Y"), "{error}");
    let error = encode_exr(&picture(), &layer(Layer::Normal, vec![vec![0.5; 37 * 23]]), &metadata());
    let error = error.expect_err("one channel for three");
    assert!(error.to_string().contains("normal has 1 channels"), "{error}");
    let empty = Picture { width: 0, height: 0, radiance: Vec::new() };
    encode_exr(&empty, &[], &metadata()).expect_err("no pixels");
}

#[test]
fn reads_other_programs_exr_files() {
    let folder = Path::new("tests/references/cornell-glass");
    if !folder.exists() {
        return;
    }
    let reference = read_exr(&folder.join("ref.exr")).expect("RGB");
    let noise = read_exr(&folder.join("stderr.exr")).expect("one channel");
    assert_eq!((reference.width, reference.height), (128, 128));
    assert_eq!((noise.width, noise.height), (128, 128));
    assert!(noise.radiance.iter().all(|pixel| pixel[0] == pixel[2]));
}

#[test]
fn png_is_srgb_with_exposure_in_stops() {
    let grey = |value: f32| Picture { width: 1, height: 1, radiance: vec![[value; 3]] };
    let byte = |value: f32, exposure: f32| {
        let png = encode_png(&grey(value), exposure).expect("encodes");
        image::load_from_memory(&png).expect("decodes").to_rgb8().get_pixel(0, 0).0
    };
    assert_eq!(byte(0.215_861, 0.0), [128; 3]);
    assert_eq!(byte(0.215_861 / 8.0, 3.0), [128; 3]);
    assert_eq!(byte(1.0, 0.0), [255; 3]);
    assert_eq!(byte(50.0, 0.0), [255; 3]);
    assert_eq!(byte(-1.0, 0.0), [0; 3]);
    assert_eq!(byte(0.001, 0.0), [3; 3]);
}

#[test]
fn the_extension_names_the_format() {
    assert_eq!(PictureFormat::of_path(Path::new("a/b.EXR")).ok(), Some(PictureFormat::Exr));
    assert_eq!(PictureFormat::of_path(Path::new("b.png")).ok(), Some(PictureFormat::Png));
    for name in ["a.jpg", "a.jpeg", "A.JPG"] {
        assert_eq!(PictureFormat::of_path(Path::new(name)).ok(), Some(PictureFormat::Jpeg), "{name}");
    }
    assert_eq!(PictureFormat::of_path(Path::new("a.webp")).ok(), Some(PictureFormat::Webp));
    assert!(PictureFormat::of_path(Path::new("exr")).is_err());
    let unknown = PictureFormat::of_path(Path::new("a.gif")).expect_err("no such format").to_string();
    assert!(unknown.contains(".exr, .png, .jpg or .webp"), "{unknown}");
}

#[test]
fn writing_leaves_only_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("picture.exr");
    check_writable(&path).expect("writable");
    assert!(!path.exists(), "a check writes nothing");
    write_file(&path, b"one").expect("writes");
    write_file(&path, b"two").expect("replaces");
    assert_eq!(std::fs::read(&path).expect("reads"), b"two");
    assert_eq!(std::fs::read_dir(folder.path()).expect("lists").count(), 1);
}

#[test]
fn an_impossible_place_is_told_with_the_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = check_writable(&folder.path().join("no/such/picture.exr")).expect_err("no folder");
    assert!(missing.to_string().contains("create the folder first"), "{missing}");
    let a_folder = check_writable(folder.path()).expect_err("a folder");
    assert!(a_folder.to_string().contains("name a file"), "{a_folder}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_with_the_remedy() {
    let error = write_file(Path::new("/dev/full"), b"picture").expect_err("/dev/full is always full");
    assert!(matches!(error, PictureFileError::Write { .. }));
    assert!(error.to_string().contains("make room"), "{error}");
}

#[test]
fn what_is_no_exr_is_told() {
    let error = decode_exr(b"not a picture").expect_err("no EXR");
    assert!(error.to_string().contains("OpenEXR"), "{error}");
}
