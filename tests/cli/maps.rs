//! False-color maps, weight maps and time shares, as users of the command line meet them.

use std::collections::BTreeMap;
use std::path::Path;

use crate::command_line::{failure, success, text};
use crate::exr_channels::exr_channels;
use photonfarm::estimate::picture_files::{Channels, PictureMetadata, encode_channels, write_file};

/// Closed, every surface shines: whatever is seen has radiance 1, and every strategy finds all of it.
const FURNACE: &str = "tests/references/furnace-closed/scene.xml";
const NO_VALUE: [u8; 3] = [150; 3];

fn channels_of(path: &Path) -> BTreeMap<String, Vec<f32>> {
    exr_channels(&std::fs::read(path).expect("a picture"))
}

/// Four by two pixels: radii of 0.1 to 0.4, one of 0, one infinite; a depth where nothing is seen.
fn write_picture(path: &Path) {
    let radii = vec![0.1, 0.2, 0.3, 0.4, 0.0, f32::INFINITY, 0.1, 0.4];
    let depths = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 1e10];
    let named =
        [("B", vec![1.0; 8]), ("G", vec![1.0; 8]), ("R", vec![0.0; 8]), ("radius.Y", radii), ("depth.Z", depths)];
    let named = named.into_iter().chain([("normal.X", vec![-1.0; 8]), ("normal.Z", vec![0.5; 8])]);
    let named = named.map(|(name, values)| (name.to_owned(), values)).collect();
    let bytes = encode_channels(Channels { width: 4, height: 2, named }, &PictureMetadata::default());
    write_file(path, &bytes.expect("encodes")).expect("writes");
}

#[test]
fn a_layer_becomes_a_map_with_a_scale() {
    let folder = tempfile::tempdir().expect("a folder");
    let [image, png, svg] = ["image.exr", "map.png", "map.svg"].map(|name| folder.path().join(name));
    write_picture(&image);
    let outputs = ["-o", text(&png), "-o", text(&svg)];
    success(
        &[["map", text(&image), "--layer", "radius", "--log", "--low", "0.1", "--high", "0.4"].as_slice(), &outputs]
            .concat(),
    );
    let map = image::open(&png).expect("a PNG").to_rgb8();
    // Each pixel is 256 wide in the PNG; the map begins at (28, 120).
    let color = |column: u32, row: u32| map.get_pixel(28 + 256 * column + 128, 120 + 256 * row + 128).0;
    let ends = [color(0, 0), color(3, 0)];
    assert_eq!([color(2, 1), color(3, 1)], ends, "equal values have equal colors");
    assert!(ends[0].iter().max() < Some(&80) && ends[1].iter().min() > Some(&140), "dark to light: {ends:?}");
    assert_eq!([color(0, 1), color(1, 1)], [NO_VALUE; 2], "0 has no logarithm, infinity no place");
    assert!(![color(1, 0), color(2, 0), ends[0], ends[1]].contains(&NO_VALUE));
    let drawing = std::fs::read_to_string(&svg).expect("text");
    assert_eq!(drawing.matches("data:image/png;base64,").count(), 2, "the map and its scale");
    for expected in ["radius: gather radius", "image.exr", "no value", "0.2"] {
        assert!(drawing.contains(expected), "{expected}");
    }
    let document = roxmltree::Document::parse(&drawing).expect("XML");
    let first = document.root_element().first_element_child().expect("the ground");
    assert_eq!(first.tag_name().name(), "rect");
    // What is not seen has no depth, and does not stretch the scale.
    success(&[["map", text(&image), "--layer", "depth"].as_slice(), &outputs].concat());
    let map = image::open(&png).expect("a PNG").to_rgb8();
    assert_eq!(map.get_pixel(28 + 256 * 3 + 128, 120 + 256 + 128).0, NO_VALUE);
    assert_ne!(map.get_pixel(28 + 128, 120 + 128), map.get_pixel(28 + 256 * 2 + 128, 120 + 256 + 128));
}

#[test]
fn maps_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let [image, png] = ["image.exr", "map.png"].map(|name| folder.path().join(name));
    write_picture(&image);
    let failed =
        |options: &[&str], code| failure(&[["map", text(&image), "-o", text(&png)].as_slice(), options].concat(), code);
    let map = |options: &[&str]| failed(options, 3);
    let unknown = map(&["--layer", "raduis"]);
    assert!(unknown.contains("luminance, depth, normal.X, normal.Z, radius"), "{unknown}");
    assert!(map(&["--layer", "normal"]).contains("normal.X"));
    assert!(failed(&["--low", "3", "--high", "2"], 2).contains("from 3 to 2"));
    assert!(failed(&["--log", "--low", "0"], 2).contains("above 0"));
    assert!(map(&["--layer", "normal.X", "--log"]).contains("no pixel has a value above 0"));
    assert!(!png.exists());
    assert!(failure(&["map", text(&image), "-o", "a.jpg"], 2).contains(".svg or .png"));
    failure(&["map", text(&image), "-o", text(&png), "--log", "--linear"], 2);
    failure(&["map", FURNACE, "-o", text(&png)], 5);
}

#[test]
fn the_layer_error_is_as_large_as_errors_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let [picture, map] = ["picture.exr", "error.png"].map(|name| folder.path().join(name));
    let map = ["map", text(&picture), "--layer", "error", "-o", text(&map)];
    let job = ["render", FURNACE, "--method", "path", "--passes", "16", "--layers", "error", "-o", text(&picture)];
    success(&job);
    let channels = channels_of(&picture);
    let mean_square = |values: &[f32], truth: f64| {
        values.iter().map(|value| (f64::from(*value) - truth).powi(2)).sum::<f64>() / values.len() as f64
    };
    let (told, real) = (mean_square(&channels["error.Y"], 0.0), mean_square(&channels["G"], 1.0));
    // 4096 squares on either side: ± 3 % each if errors are normal, more with their longer tails.
    assert!((told / real - 1.0).abs() < 0.2, "variance {told} is told, {real} it is");
    success(&map);
    // One pass tells nothing.
    let job = ["render", FURNACE, "--method", "path", "--passes", "1", "--layers", "error", "--overwrite", "-o"];
    success(&[job.as_slice(), &[text(&picture)]].concat());
    assert!(channels_of(&picture)["error.Y"].iter().all(|error| error.is_nan()));
    assert!(failure(&map, 3).contains("no pixel has a value"));
}

#[test]
fn weights_of_all_strategies_add_up_to_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let [picture, maps] = ["picture.exr", "maps.exr"].map(|name| folder.path().join(name));
    let strategies =
        [("bdpt", vec!["s0t4", "s1t3", "s2t2", "s3t1"]), ("vcm", vec!["s0t4", "s1t2", "s1t3", "s2t1", "s2t2", "s3t1"])];
    for (method, names) in strategies {
        let method = ["--method", method, "--length", "3", "--passes", "2"];
        let outputs = ["-o", text(&picture), "--weight-maps", text(&maps)];
        success(&[["render", FURNACE].as_slice(), &method, &outputs].concat());
        let channels = channels_of(&maps);
        assert_eq!(channels["G"], channels_of(&picture)["G"], "the picture is there too");
        let found: Vec<&str> =
            channels.keys().filter_map(|name| name.strip_prefix("length3.")?.strip_suffix(".Y")).collect();
        assert_eq!(found, names);
        let weights: Vec<&Vec<f32>> =
            channels.iter().filter(|(name, _)| name.contains('.')).map(|(_, values)| values).collect();
        assert!(weights.iter().all(|values| values.iter().all(|weight| !(*weight < 0.0 || *weight > 1.0))));
        assert!(weights.iter().all(|values| values.iter().sum::<f32>() > 0.01 * 64.0 * 64.0), "none is idle");
        // The parts are those of the whole to the bit, but for the order in which they are added.
        for pixel in 0..64 * 64 {
            let sum: f32 = weights.iter().map(|values| values[pixel]).sum();
            assert!((sum - 1.0).abs() < 1e-4, "weights of {names:?} add up to {sum} in pixel {pixel}");
        }
        let sheet = image::open(maps.with_extension("png")).expect("a sheet").to_rgb8();
        assert!(sheet.width() > 2 * 64 * 2 * names.len() as u32 && sheet.height() > 2 * 64);
    }
}

#[test]
fn weight_maps_that_cannot_be_are_refused_before_rendering() {
    let folder = tempfile::tempdir().expect("a folder");
    let [picture, maps] = ["picture.exr", "maps.exr"].map(|name| folder.path().join(name));
    let render =
        |options: &[&str]| failure(&[["render", FURNACE, "-o", text(&picture)].as_slice(), options].concat(), 3);
    let without = render(&["--method", "path", "--weight-maps", text(&maps)]);
    assert!(without.contains("\"path\"") && without.contains("bdpt, bdpm, pbdpm, vcm"), "{without}");
    let none = render(&["--method", "bdpt", "--set", "max_depth=1", "--weight-maps", text(&maps)]);
    assert!(none.contains("max_depth"), "{none}");
    let png = ["render", FURNACE, "-o", text(&picture), "--method", "bdpt", "--weight-maps", "maps.png"];
    assert!(failure(&png, 2).contains("is no EXR"));
    assert!(!picture.exists() && !maps.exists());
}

/// Only parts that a method has are told; no share is the whole pass.
#[test]
fn time_shares_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("picture.png");
    for (method, parts) in [("vcm", 2), ("sppm", 1), ("path", 0)] {
        let told =
            success(&["render", FURNACE, "--method", method, "--passes", "2", "--time-shares", "-o", text(&output)]);
        let line = told.lines().find(|line| line.starts_with("a pass takes")).unwrap_or_else(|| panic!("{told}"));
        let words: Vec<&str> = line.trim_end_matches(" %").split([' ']).collect();
        assert!(words[3].parse::<f64>().is_ok_and(|seconds| seconds > 0.0), "{line}");
        let shares: Vec<f64> = line.split(" %").filter_map(|part| part.rsplit(' ').next()?.parse().ok()).collect();
        assert!(shares.len() == parts && shares.iter().all(|share| (0.0..100.0).contains(share)), "{method}: {line}");
    }
}
