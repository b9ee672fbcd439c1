//! Attributes that OpenEXR names, read back with the crate `exr`.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::Chromaticities;
use exr::prelude::{LayerAttributes, Vec2};
use photonfarm::estimate::picture_files::{PictureMetadata, encode_exr, encode_half_exr};

use super::{metadata, picture};

fn header(metadata: &PictureMetadata) -> (LayerAttributes, Option<Chromaticities>) {
    let bytes = encode_exr(&picture(), &[], metadata).expect("encodes");
    let header = MetaData::read_from_buffered(Cursor::new(bytes), true).expect("an EXR").headers[0].clone();
    (header.own_attributes, header.shared_attributes.chromaticities)
}

#[test]
fn what_is_known_of_a_job_is_in_the_header() {
    let matrix: [f32; 16] = std::array::from_fn(|index| index as f32 + 0.5);
    let (attributes, chromaticities) = header(&PictureMetadata {
        name: Some("kitchen, take 3".to_owned()),
        owner: Some("anna".to_owned()),
        submitted: Some(1_000_000_000),
        world_to_camera: Some(matrix),
        world_to_ndc: Some(matrix.map(|number| -number)),
        ..metadata()
    });
    let text = |text: &Option<exr::meta::attribute::Text>| text.as_ref().map(ToString::to_string);
    assert_eq!(text(&attributes.software_name), Some(format!("photonfarm {}", env!("CARGO_PKG_VERSION"))));
    assert_eq!(text(&attributes.owner).as_deref(), Some("anna"));
    let comments = text(&attributes.comments);
    assert_eq!(comments.as_deref(), Some("kitchen, take 3: 12 passes of sppm, radiance in W/(sr*m^2)"));
    // A billion seconds after the beginning of 1970.
    assert_eq!(text(&attributes.capture_date).as_deref(), Some("2001:09:09 01:46:40"));
    assert_eq!(attributes.utc_offset, Some(0.0));
    assert_eq!(attributes.world_to_camera, Some(matrix));
    assert_eq!(attributes.world_to_normalized_device, Some(matrix.map(|number| -number)));
    let rec_709 = Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    };
    assert_eq!(chromaticities, Some(rec_709));
}

#[test]
fn what_is_not_known_is_left_out() {
    let (attributes, _) = header(&PictureMetadata::default());
    assert_eq!((attributes.owner, attributes.comments, attributes.capture_date), (None, None, None));
    assert_eq!((attributes.utc_offset, attributes.world_to_camera), (None, None));
    assert_eq!(attributes.world_to_normalized_device, None);
}

#[test]
fn dates_follow_the_calendar() {
    for (seconds, expected) in [
        (0, Some("1970:01:01 00:00:00")),
        (951_782_399, Some("2000:02:28 23:59:59")),
        (951_782_400, Some("2000:02:29 00:00:00")),
        (253_402_300_799, Some("9999:12:31 23:59:59")),
        (253_402_300_800, None),
        (u64::MAX, None),
    ] {
        let (attributes, _) = header(&PictureMetadata { submitted: Some(seconds), ..metadata() });
        assert_eq!(attributes.capture_date.map(|date| date.to_string()).as_deref(), expected, "{seconds}");
        assert_eq!(attributes.utc_offset.is_some(), expected.is_some());
    }
}

#[test]
fn one_pass_is_no_plural() {
    let (attributes, _) = header(&PictureMetadata { passes: 1, ..metadata() });
    let comments = attributes.comments.map(|text| text.to_string());
    assert_eq!(comments.as_deref(), Some("1 pass of sppm, radiance in W/(sr*m^2)"));
}

#[test]
fn bytes_with_every_attribute_are_the_same_every_time() {
    let metadata = PictureMetadata {
        name: Some("größer".to_owned()),
        owner: Some("anna".to_owned()),
        submitted: Some(1),
        world_to_camera: Some([1.0; 16]),
        world_to_ndc: Some([2.0; 16]),
        ..metadata()
    };
    let encode = || encode_half_exr(&picture(), &[], &metadata).expect("encodes");
    let first = encode();
    assert!((0..20).all(|_| encode() == first));
}
