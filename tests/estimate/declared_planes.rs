//! What methods declare is what is stored; ratios converge with the job; snapshots restore the same bits.

use std::sync::Arc;

use crate::progressive::{Job, reference_scene};
use photonfarm::estimate::declaration::{PHOTONS_EMITTED, RADIANCE};
use photonfarm::estimate::snapshot::{self, SnapshotError};
use photonfarm::estimate::{
    Declaration, Estimate, PlaneDeclaration, PlaneRule, RadiusRule, Region, ScalarDeclaration, ScalarRule, Shard,
    Tally, Twin,
};

const BOTH: [Twin; 2] = [Twin::Even, Twin::Odd];

#[test]
fn methods_store_only_what_they_declare() {
    let scene = reference_scene("cornell-glass");
    let cases = [
        ("path", "{}", 48, 1),
        ("bdpt", "{}", 48, 1),
        ("light_tracing", "{}", 48, 1),
        ("photon_map", r#"{"photons_per_pass": 1000}"#, 48, 1),
        ("vcm", r#"{"merge": "off"}"#, 48, 1),
        ("vcm", "{}", 128, 4),
        ("sppm", r#"{"photons_per_pass": 1000}"#, 128, 4),
        ("sppm", r#"{"photons_per_pass": 1000, "radius_rule": "schedule"}"#, 120, 3),
        ("sppm", r#"{"photons_per_pass": 1000, "radius_rule": "uniformity"}"#, 176, 6),
        ("ppm", r#"{"photons_per_pass": 1000}"#, 128, 4),
        ("pbdpm", r#"{"photons_per_pass": 1000}"#, 128, 4),
        ("bdpm", r#"{"photons_per_pass": 1000}"#, 120, 3),
    ];
    for (method, parameters, bytes, planes) in cases {
        let job = Job::new(&scene, method, parameters);
        let estimate = job.begin().estimate;
        assert_eq!(estimate.bytes_per_pixel(), bytes, "{method} {parameters}");
        assert_eq!(estimate.declaration().planes.len(), planes, "{method} {parameters}");
        let radii = estimate.radius_field(job.region()).radius_squared.len();
        assert_eq!(job.method.choice.name, method);
        assert_eq!(radii > 0, estimate.declaration().has_radii(), "{method} {parameters}");
    }
}

fn plane(name: &str, channels: usize, rule: PlaneRule, in_picture: bool) -> PlaneDeclaration {
    PlaneDeclaration { name: name.to_owned(), channels, rule, in_picture, light_group: None }
}

fn ratio(denominator: &str) -> PlaneRule {
    PlaneRule::Ratio { denominator: denominator.to_owned() }
}

/// Radiance, a chain's picture over its normalization, and a share of which each pixel knows its own denominator.
fn with_ratios() -> Declaration {
    let mut declaration = Declaration::radiance_only();
    declaration.scalars.push(ScalarDeclaration { name: "chain_weight".to_owned(), rule: ScalarRule::Sum });
    declaration.planes.extend([
        plane("chain", 3, ratio("chain_weight"), true),
        plane("visible", 1, ratio("tried"), false),
        plane("tried", 1, PlaneRule::Sum, false),
    ]);
    declaration
}

const REGIONS: [Region; 2] = [Region { row_start: 0, row_end: 1 }, Region { row_start: 1, row_end: 3 }];

/// A tally whose chain is known only up to `factor`.
fn with_factor(declaration: &Arc<Declaration>, region: Region, first_pass: u32, factor: f32) -> Tally {
    let mut tally = Tally::zero(Shard { first_pass, passes: 1, region }, 2, declaration);
    tally.plane_mut(RADIANCE).expect("declared").fill(1.0);
    tally.plane_mut("chain").expect("declared").fill(3.0 * factor);
    tally.plane_mut("visible").expect("declared").fill(factor);
    tally.plane_mut("tried").expect("declared").fill(4.0 * factor);
    tally.plane_mut("tried").expect("declared")[0] = 0.0;
    tally.set_scalar("chain_weight", f64::from(2.0 * factor));
    tally
}

#[test]
fn ratios_are_of_sums_and_not_means_of_ratios() {
    let declaration = Arc::new(with_ratios());
    let mut estimate = Estimate::new(2, 3, &REGIONS, declaration.clone(), &[]).expect("no radii are needed");
    for (pass, factor) in [1.0, 8.0, 0.5, 64.0].into_iter().enumerate() {
        for region in REGIONS {
            let tally = with_factor(&declaration, region, pass as u32, factor);
            estimate.merge(&tally, &estimate.radius_field(region)).expect("the tally fits");
        }
    }
    // Whatever the factors: 1 and 3/2.
    assert!(estimate.picture().radiance.iter().flatten().all(|value| *value == 2.5));
    assert!(estimate.twin_picture(Twin::Odd).radiance.iter().flatten().all(|value| *value == 2.5));
    let visible = estimate.mean("visible", &BOTH).expect("it is declared");
    assert_eq!(visible, [0.0, 0.25, 0.0, 0.25, 0.25, 0.25], "0 where nothing was tried, else a quarter");
    assert_eq!(estimate.error().map(|error| (error.noise, error.bias)), Some((0.0, 0.0)));

    // A pass with other contents counts as much as its weight.
    let mut other = with_factor(&declaration, REGIONS[0], 4, 1.0);
    other.plane_mut("chain").expect("declared").fill(0.0);
    estimate.merge(&other, &estimate.radius_field(REGIONS[0])).expect("the tally fits");
    let expected = 1.0 + 3.0 * 73.5 / (2.0 * 74.5);
    assert!((f64::from(estimate.picture().radiance[0][0]) - expected).abs() < 1e-6);
}

#[test]
fn declarations_that_contradict_themselves_are_refused() {
    let refused = |extra: PlaneDeclaration| {
        let mut declaration = with_ratios();
        declaration.planes.push(extra);
        declaration.check().is_err()
    };
    assert!(with_ratios().check().is_ok());
    assert!(!refused(plane("more", 3, PlaneRule::Sum, true)));
    assert!(refused(plane("chain", 3, PlaneRule::Sum, true)), "a name twice");
    assert!(refused(plane("more", 1, PlaneRule::Sum, true)), "one channel in the picture");
    assert!(refused(plane("more", 0, PlaneRule::Sum, false)), "no channel");
    assert!(refused(plane("more", 3, ratio("nothing"), true)), "an unknown denominator");
    assert!(refused(plane("more", 1, ratio("chain"), false)), "a ratio as denominator");
    assert!(refused(plane("more", 1, ratio("radiance"), false)), "more channels below than above");
    assert!(refused(plane("more", 2, PlaneRule::Count, false)), "a count of two channels");
    let mut without = Declaration::gathering(RadiusRule::Statistics, 0.5);
    without.scalars.retain(|scalar| scalar.name != PHOTONS_EMITTED);
    assert!(without.check().is_err(), "flux without photons");
}

/// Saving, restoring and going on gives the bits of a job that was never interrupted.
#[test]
fn snapshots_restore_the_same_bits() {
    let scene = reference_scene("cornell-glass");
    for (method, parameters) in [
        ("sppm", r#"{"photons_per_pass": 2000}"#),
        ("sppm", r#"{"photons_per_pass": 2000, "radius_rule": "schedule"}"#),
        ("ppm", r#"{"photons_per_pass": 2000, "radius_rule": "uniformity"}"#),
        ("path", "{}"),
    ] {
        let job = Job::new(&scene, method, parameters);
        let mut estimate = job.run(5, 2);
        let bytes = snapshot::encode(&estimate).expect("it can be written");
        let mut restored = snapshot::decode(&bytes).expect("just written");
        assert_eq!(restored, estimate, "{method}");
        for first_pass in 5..8 {
            let shard = Shard { first_pass, passes: 1, region: job.region() };
            for estimate in [&mut estimate, &mut restored] {
                let field = estimate.radius_field(job.region());
                let tally = job.renderer.trace(shard, &field, &job.never).expect("nobody cancels");
                estimate.merge(&tally, &field).expect("tallies come in order");
            }
        }
        assert_eq!(restored, estimate, "{method}");
        assert_eq!(restored.picture(), estimate.picture(), "{method}");
        assert_eq!(snapshot::encode(&restored).expect("written"), snapshot::encode(&estimate).expect("written"));
    }
}

#[test]
fn damaged_snapshots_are_refused() {
    let estimate = Estimate::new(2, 3, &REGIONS, Arc::new(with_ratios()), &[]).expect("no radii are needed");
    let bytes = snapshot::encode(&estimate).expect("it can be written");
    for length in 0..bytes.len() {
        assert!(snapshot::decode(&bytes[..length]).is_err(), "cut off after {length} bytes");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(snapshot::decode(&longer).is_err(), "a byte too many");
    let mut later = bytes.clone();
    later[4] = 2;
    assert!(matches!(snapshot::decode(&later), Err(SnapshotError::OtherVersion { found: 2 })));
    // Any byte of the header may be wrong: whatever is read must fit together.
    for place in 0..bytes.len().min(900) {
        let mut damaged = bytes.clone();
        damaged[place] = damaged[place].wrapping_add(1);
        if let Ok(read) = snapshot::decode(&damaged) {
            let _ = read.picture();
        }
    }
}
