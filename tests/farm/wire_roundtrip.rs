//! The workers' protocol: what is written is what is read, and hostile bytes are refused without harm.

use std::sync::Arc;

use photonfarm::estimate::picture_files::{Matte, Mattes};
use photonfarm::estimate::{Declaration, PixelTally, RadiusField, RadiusRule, Region, Shard, Tally};
use photonfarm::farm::ids::{Fencing, JobId, LeaseId};
use photonfarm::farm::rules::lease::Errand;
use photonfarm::farm::rules::plan::Plan;
use photonfarm::farm::wire::first_surfaces;
use photonfarm::farm::wire::guides;
use photonfarm::farm::wire::lease::{
    ChoiceTerms, JobDescription, LeasedWork, ShardTerms, WorkerLease, decode_lease, encode_lease,
};
use photonfarm::farm::wire::mattes;
use photonfarm::farm::wire::messages;
use photonfarm::farm::wire::planes;
use photonfarm::farm::wire::radius;
use photonfarm::farm::wire::result::{decode_checked_tally, decode_pilot, decode_tally, encode_pilot, encode_tally};
use photonfarm::math::{Rgb, Vec3};
use photonfarm::method::{self, FIRST_RADIUS_SQUARED, MethodChoice, PilotField};
use photonfarm::render::first_surface::FirstSurface;
use photonfarm::render::{Guides, Pilot};
use proptest::prelude::*;
use prost::Message;

const REGION: Region = Region { row_start: 1, row_end: 3 };
const SHARD: Shard = Shard { first_pass: 5, passes: 2, region: REGION };

fn gathering() -> Arc<Declaration> {
    Arc::new(Declaration::gathering(RadiusRule::Statistics, 2.0 / 3.0))
}

fn tally() -> Tally {
    let pixel = |index: usize| PixelTally {
        radiance: [index as f32, 0.5, -0.0],
        flux: [1e-30, 3.0e7, 1.0 / 3.0],
        photons: index as f32 * 1.5,
        inner_flux: 0.25 * index as f32,
    };
    let pixels: Vec<PixelTally> = (0..REGION.pixel_count(700)).map(pixel).collect();
    Tally { scalars: vec![9.0, 8.0, 7.0, 6.0], ..Tally::from_sums(SHARD, 700, &gathering(), &pixels.into()) }
}

fn pilot(fields: Vec<PilotField>, cost_per_pass: u64) -> Pilot {
    Pilot::new(fields, cost_per_pass)
}

fn first_radii(values: Vec<f32>) -> PilotField {
    PilotField { name: FIRST_RADIUS_SQUARED.to_owned(), values }
}

fn job() -> JobDescription {
    let parameters = serde_json::Map::from_iter([("passes".into(), 64.into())]);
    let method = method::check(&MethodChoice { name: "sppm".into(), parameters }, 4096).expect("good parameters");
    JobDescription {
        id: JobId::new(77),
        scene: "ab".repeat(32),
        method: Some(method),
        seed: u64::MAX,
        light_groups: vec!["key".to_owned(), "others".to_owned()],
        width: 64,
        height: 64,
    }
}

#[test]
fn tallies_keep_every_bit() {
    let tally = tally();
    let message = messages::Tally::decode(&encode_tally(&tally).encode_to_vec()[..]).expect("just encoded");
    let read = decode_checked_tally(&message, SHARD, 700, &gathering()).expect("just encoded");
    assert_eq!(read, tally);
    assert_eq!(read.pixels()[0].radiance[2].to_bits(), (-0.0f32).to_bits());
}

#[test]
fn radius_fields_and_pilots_keep_every_bit() {
    let field = RadiusField {
        radius_squared: (1..=1400).map(|index| 1.0 / index as f32).collect(),
        base_pass: 12,
        typical_radius_squared: 0.25,
    };
    assert_eq!(radius::decode(&radius::encode(&field), 1400), Ok(field.clone()));
    let map = PilotField { name: "importance".to_owned(), values: vec![-1.0, 0.0, 1e30] };
    let mut found = pilot(vec![first_radii(field.radius_squared), map], 77);
    found.counts.push(("paths".to_owned(), u64::MAX));
    let read = decode_pilot(&encode_pilot(&found), 1400, &gathering()).expect("just encoded");
    assert_eq!(read, found);
    assert_eq!(
        (read.cost_per_pass(), read.count("paths"), read.field("importance")),
        (77, Some(u64::MAX), Some(&[-1.0, 0.0, 1e30][..]))
    );
}

#[test]
fn guides_keep_every_bit() {
    let emission = [vec![], vec![-1.0, 0.25, 0.75], (0..100_000).map(|index| 1.0 / (1 + index) as f32).collect()];
    for emission in emission {
        for visibility in [vec![], vec![-3.0, 1.5, 0.25, 1.0, 1e-6, 0.5]] {
            let guides = Guides { emission: emission.clone(), visibility };
            assert_eq!(guides::decode(&guides::encode(&guides)), Ok(guides));
        }
    }
    let message = guides::encode(&Guides { emission: vec![-1.0, 0.25, 0.75], visibility: vec![1.0, 0.5, 0.25] });
    for length in [0, 2, 4, 1 << 30, u64::MAX] {
        let wrong = [
            messages::Guides { emission_length: length, ..message.clone() },
            messages::Guides { visibility_length: length, ..message.clone() },
        ];
        assert!(wrong.iter().all(|wrong| guides::decode(wrong).is_err()), "{length} numbers");
    }
}

fn lease(work: LeasedWork) -> WorkerLease {
    WorkerLease { id: LeaseId::new(3), fencing: Fencing::new(4), job: job(), work }
}

fn shard_work(index: u64) -> LeasedWork {
    let planned = Plan::new(64, 64, 1000, None, RadiusRule::Statistics).shard(index).expect("endless");
    LeasedWork::Shard(ShardTerms { planned, generation: 2 })
}

#[test]
fn leases_say_what_to_do() {
    let parameters = serde_json::Map::from_iter([("max_depth".to_owned(), 3.into())]);
    let choice = LeasedWork::Choice(ChoiceTerms { parameters, error: 0.01 });
    let errands = [Errand::FirstSurfaces, Errand::Mattes].map(LeasedWork::Errand);
    for work in [choice, LeasedWork::Pilot, shard_work(100)].into_iter().chain(errands) {
        let mut lease = lease(work);
        assert_eq!(decode_lease(encode_lease(&lease)).as_ref(), Ok(&lease));
        lease.job.method = None;
        let needs_method = matches!(lease.work, LeasedWork::Pilot | LeasedWork::Shard(_));
        assert_eq!(decode_lease(encode_lease(&lease)).is_err(), needs_method, "{lease:?}");
    }
}

#[test]
fn first_surfaces_keep_every_bit() {
    let pixel = |index: usize| FirstSurface {
        albedo: Rgb::new(0.1, index as f32, 1.0 / 3.0),
        normal: Vec3::new(-0.0, 0.5, -1.0),
        depth: index as f32,
        position: Vec3::new(index as f32, -1e-20, 3e7),
    };
    let seen: Vec<FirstSurface> = (0..500).map(pixel).collect();
    assert_eq!(first_surfaces::decode(&first_surfaces::encode(&seen), 500), Ok(seen.clone()));
    assert!(first_surfaces::decode(&first_surfaces::encode(&seen), 499).is_err());
    let wrong = [FirstSurface { depth: f32::NAN, ..seen[0] }];
    assert!(first_surfaces::decode(&first_surfaces::encode(&wrong), 1).is_err());
}

#[test]
fn mattes_are_what_was_seen_and_impossible_ones_are_refused() {
    let names = vec!["шар".to_owned(), "\"".to_owned(), "out of view".to_owned()];
    let mut objects = Matte { names, ..Matte::default() };
    for met in [[1; 16].as_mut_slice(), &mut [0, 1, 1], &mut []] {
        objects.push_pixel(met);
    }
    let seen = Mattes { materials: objects.clone(), objects };
    let message = mattes::encode(seen.clone()).expect("a message");
    assert_eq!(mattes::decode(message.clone(), 3), Ok(seen));
    assert!(mattes::decode(message.clone(), 2).is_err(), "another picture");
    assert!(mattes::decode(messages::Mattes { materials: None, ..message.clone() }, 3).is_err());
    let good = message.objects.clone().expect("the objects");
    for wrong in [
        messages::Matte { names: good.names[..1].to_vec(), ..good.clone() },
        messages::Matte { things: good.things[1..].to_vec(), ..good.clone() },
        messages::Matte { rays: vec![16, 16, 1].into(), ..good.clone() },
        messages::Matte { counts: vec![2, 2, 0].into(), ..good.clone() },
        messages::Matte { counts: vec![0, 0, 7].into(), things: vec![0; 7], rays: vec![1; 7].into(), ..good.clone() },
    ] {
        assert!(
            mattes::decode(messages::Mattes { objects: Some(wrong.clone()), ..message.clone() }, 3).is_err(),
            "{wrong:?}"
        );
    }
    let long = Matte { names: vec!["n".repeat(mattes::MOST_NAME_BYTES)], ..Matte::default() };
    assert!(
        mattes::encode(Mattes { objects: long, ..Mattes::default() }).is_err_and(|problem| problem.contains("16 MiB"))
    );
}

#[test]
fn a_result_that_does_not_fit_its_shard_is_refused() {
    let message = encode_tally(&tally());
    assert!(decode_tally(&message, SHARD, 701, &gathering()).is_err(), "another width");
    let other = Shard { region: Region { row_start: 0, row_end: 1 }, ..SHARD };
    assert!(decode_tally(&message, other, 700, &gathering()).is_err(), "another region");
    for (wrong, text) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (-1.0, "-1")] {
        let mut tally = tally();
        tally.plane_mut("photons").expect("declared")[17] = wrong;
        let problem =
            decode_checked_tally(&encode_tally(&tally), SHARD, 700, &gathering()).expect_err("an impossible value");
        assert!(problem.to_string().contains(text) && problem.to_string().contains("pixel 17"), "{problem}");
    }
}

#[test]
fn impossible_radii_are_refused() {
    for wrong in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(radius::decode_radii(&radius::encode_radii(&[1.0, wrong]), 2).is_err(), "{wrong}");
    }
    let refused =
        |found: &Pilot, declaration: &Declaration| decode_pilot(&encode_pilot(found), 1, declaration).is_err();
    assert!(!refused(&pilot(vec![first_radii(vec![1.0])], 1), &gathering()));
    assert!(refused(&pilot(vec![first_radii(vec![1.0])], 0), &gathering()), "no cost");
    assert!(refused(&pilot(vec![first_radii(vec![0.0])], 1), &gathering()), "no radius");
    assert!(refused(&pilot(vec![first_radii(vec![1.0; 2])], 1), &gathering()), "too many radii");
    assert!(refused(&pilot(Vec::new(), 1), &gathering()), "no radii");
    let radiance_only = Declaration::radiance_only();
    assert!(!refused(&pilot(Vec::new(), 1), &radiance_only));
    assert!(refused(&pilot(vec![first_radii(vec![1.0])], 1), &radiance_only), "radii that nobody needs");
    let wrong_map = PilotField { name: "importance".to_owned(), values: vec![f32::NAN] };
    assert!(refused(&pilot(vec![wrong_map], 1), &radiance_only), "not a number");
}

#[test]
fn impossible_leases_are_refused() {
    let good = encode_lease(&lease(shard_work(1)));
    let broken = |spoil: &dyn Fn(&mut messages::ShardWork)| {
        let mut message = good.clone();
        if let Some(messages::lease::Work::Shard(shard)) = message.work.as_mut() {
            spoil(shard);
        }
        decode_lease(message).is_err()
    };
    assert!(broken(&|shard| shard.row_end = 65));
    assert!(broken(&|shard| shard.row_end = shard.row_start));
    assert!(broken(&|shard| shard.passes = 0));
    assert!(broken(&|shard| (shard.first_pass, shard.passes) = (u32::MAX, 2)));
    assert!(decode_lease(messages::Lease { job: None, ..good.clone() }).is_err());
    assert!(decode_lease(messages::Lease { work: None, ..good }).is_err());
}

/// A few bytes that claim to be a large picture are refused before memory is spent on it.
#[test]
fn a_short_message_does_not_become_a_large_allocation() {
    assert!(planes::decompress(&[0; 100], usize::MAX / 1000).is_err());
    assert!(planes::decompress(&[], 1).is_err());
    assert!(planes::decompress(&[0; 100], usize::MAX).is_err());
}

/// More than one chunk, and none at all; nothing may be missing or left over.
#[test]
fn chunks_join_without_a_seam() {
    let values: Vec<f32> = (0..140_000).map(|index| index as f32).collect();
    let mut bytes = planes::compress(&values);
    assert_eq!(planes::decompress(&bytes, 140_000), Ok(values));
    assert!(planes::decompress(&bytes, 139_999).is_err());
    bytes.push(0);
    assert!(planes::decompress(&bytes, 140_000).is_err());
    assert_eq!(planes::decompress(&planes::compress(&[]), 0), Ok(Vec::new()));
}

proptest! {
    #[test]
    fn planes_are_exact_for_any_count(bits in prop::collection::vec(any::<u32>(), 0..9000)) {
        let values: Vec<f32> = bits.iter().map(|bits| f32::from_bits(*bits)).collect();
        let read = planes::decompress(&planes::compress(&values), values.len()).expect("just compressed");
        let read: Vec<u32> = read.iter().map(|value| value.to_bits()).collect();
        prop_assert_eq!(read, bits);
    }

    #[test]
    fn hostile_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..2000), count in 0usize..5000) {
        let _ = planes::decompress(&bytes, count);
        let _ = radius::decode_radii(&bytes, count);
        let _ = messages::ResultRequest::decode(&bytes[..]);
        if let Ok(message) = messages::Lease::decode(&bytes[..]) {
            let _ = decode_lease(message);
        }
        if let Ok(message) = messages::Tally::decode(&bytes[..]) {
            let _ = decode_checked_tally(&message, SHARD, 700, &gathering());
        }
        if let Ok(message) = messages::Pilot::decode(&bytes[..]) {
            let _ = decode_pilot(&message, count, &gathering());
        }
    }

    #[test]
    fn a_damaged_tally_never_panics(position in 0usize..1000, value in any::<u8>()) {
        let mut bytes = encode_tally(&tally()).encode_to_vec();
        let position = position % bytes.len();
        bytes[position] = value;
        if let Ok(message) = messages::Tally::decode(&bytes[..]) {
            let _ = decode_checked_tally(&message, SHARD, 700, &gathering());
        }
    }
}
