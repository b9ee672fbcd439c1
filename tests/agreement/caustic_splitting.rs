//! More caustic photons than others, and a global map of photons that are looked for: the same picture with less noise, or from less memory.

use std::sync::Arc;

use photonfarm::estimate::{PixelTally, RadiusField, Region, Shard, Tally};
use photonfarm::method::{MethodChoice, check};
use photonfarm::scene::Scene;

use crate::batches::{assert_same, bits_of_threads, mean_and_error, repository_scene};
use crate::progressive::{Job, reference_scene};
use crate::scene_text::prepare;

const SPLITTINGS: [&str; 3] = ["brute", "projection", "metropolis"];

/// Estimates over discs that never hold k photons are linear in the photons: their expectation does not know how many there are.
const FIXED_DISCS: &str =
    r#""neighbors": 65536, "caustic_neighbors": 65536, "largest_radius": 0.08, "final_gather": 1"#;

fn split(factor: u32, splitting: &str, more: &str) -> String {
    format!(r#"{{{FIXED_DISCS}, "caustic_splitting": {factor}, "splitting": "{splitting}"{more}}}"#)
}

/// The first pass of a job.
fn first_pass(scene: &Arc<Scene>, parameters: &str) -> Tally {
    let job = Job::new(scene, "photon_map", parameters);
    let begun = job.begin();
    let field = begun.estimate.radius_field(job.region());
    let shard = Shard { first_pass: 0, passes: 1, region: job.region() };
    begun.renderer.trace(shard, &field, &job.never).expect("nobody cancels")
}

fn bits(pixels: &[PixelTally]) -> Vec<u32> {
    bytemuck::cast_slice(pixels).to_vec()
}

/// The sun and the sky, a spot, a lamp, a lamp in glass, instances, a group of lamps: no photon that would make a caustic is left out.
#[test]
fn projection_loses_no_caustic_photon() {
    let kinds = [
        ("pool", "power"),
        ("caustic-point", "power"),
        ("caustic-point", "guided"),
        ("scene5", "power"),
        ("still-life", "power"),
        ("table-and-spheres", "power"),
        ("house-of-lamps", "guided"),
        ("lamp-in-glass", "power"),
    ];
    for (name, emission) in kinds {
        let scene = repository_scene(&format!("{name}/scene.xml"), "24");
        let pass = |splitting: &str| {
            let more = format!(r#", "photons_per_pass": 8000, "emission": "{emission}""#);
            first_pass(&scene, &split(6, splitting, &more))
        };
        let [brute, projection] = ["brute", "projection"].map(pass);
        assert!(bits(&brute.pixels()) == bits(&projection.pixels()), "{name}: caustic photons are missing");
        let stored = [&brute, &projection].map(|tally| tally.scalar("photons_stored"));
        assert_eq!(stored[0], stored[1], "{name}");
        assert_eq!(brute.scalar("photons_emitted"), 6.0 * 8000.0, "{name}");
        let [all, some] = [&brute, &projection].map(|tally| tally.scalar("rays"));
        println!("{name}: {all} rays by brute force, {some} with projection");
        let spares = !matches!(name, "lamp-in-glass");
        assert!(if spares { some < 0.97 * all } else { some == all }, "{name}: {some} rays instead of {all}");
    }
}

/// A floor in the shadow of a glass ball, lit by caustics alone: of a spot whose cone is uneven, or of a lamp.
fn floor_behind_glass(light: &str) -> Arc<Scene> {
    let body = format!(
        "<sensor type='perspective'><float name='fov' value='7'/><transform name='to_world'>\
        <lookat origin='1.2, 0, 0.5' target='0, 0, 0' up='0, 0, 1'/></transform><film type='hdrfilm'>\
        <integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>\
        <shape type='rectangle'><transform name='to_world'><scale value='4'/></transform><bsdf type='diffuse'/></shape>\
        <shape type='sphere'><point name='center' value='0, 0, 1'/><float name='radius' value='0.3'/>\
        <bsdf type='dielectric'/></shape>{light}"
    );
    Arc::new(prepare(&body, &[]).expect("the scene is good"))
}

const SPOT: &str = "<emitter type='spot'><rgb name='intensity' value='3, 2, 2'/><float name='cutoff_angle' value='20'/>\
    <float name='beam_width' value='3'/><transform name='to_world'><lookat origin='0, 0.2, 3' target='0, 0, 1' up='0, 1, 0'/>\
    </transform></emitter>";
const LAMP: &str = "<shape type='rectangle'><transform name='to_world'><scale value='0.2'/><rotate x='1' angle='180'/>\
    <translate z='3'/></transform><emitter type='area'><rgb name='radiance' value='40, 30, 20'/></emitter></shape>";

/// Each way brings the light that the photons of the pass bring.
#[test]
fn split_caustics_are_as_bright() {
    // A lamp sends less of its light through the ball.
    let cases = [("spot", SPOT, "power", 8000), ("spot", SPOT, "guided", 8000), ("lamp", LAMP, "power", 24_000)];
    for (name, light, emission, photons) in cases {
        let scene = floor_behind_glass(light);
        let more = format!(r#", "photons_per_pass": {photons}, "emission": "{emission}", "max_depth": 5"#);
        let plain = mean_and_error(&scene, "photon_map", &split(1, "brute", &more), 3);
        for splitting in SPLITTINGS {
            let found = mean_and_error(&scene, "photon_map", &split(16, splitting, &more), 3);
            assert_same(found, plain, 0.0, &format!("{name}, photons by {emission}, {splitting}"));
            assert!(plain[1] < 0.02 * plain[0], "{name}: the test is blind, {} of {}", plain[1], plain[0]);
        }
    }
}

/// Sixteen times as many independent photons have a sixteenth of the variance. Mutations depend on each other, and at so small an S
/// brute force is better, as the thesis says.
#[test]
fn split_caustics_have_less_noise() {
    let scene = floor_behind_glass(SPOT);
    let more = r#", "photons_per_pass": 500, "max_depth": 4"#;
    let [plain, brute, projection, metropolis] = [(1, "brute"), (16, "brute"), (16, "projection"), (16, "metropolis")]
        .map(|(factor, splitting)| {
            let [_, _, noise] = mean_and_error(&scene, "photon_map", &split(factor, splitting, more), 1);
            println!("{splitting}, S = {factor}: {noise}");
            noise
        });
    // Some of the noise is that of camera paths.
    assert!(brute < 0.25 * plain, "noise {brute} of {plain}");
    assert!(projection == brute, "{projection} is not {brute}");
    assert!(brute < metropolis && metropolis < 1.1 * plain, "mutations: noise {metropolis} of {plain}");
}

/// Mutations explore what has one characteristic, so that many of them must bring as much light as its photons.
#[test]
fn long_chains_of_mutations_stay_right() {
    let scene = repository_scene("caustic-point/scene.xml", "16");
    let more = r#", "photons_per_pass": 2000, "max_depth": 6"#;
    let plain = mean_and_error(&scene, "photon_map", &split(64, "brute", more), 4);
    let found = mean_and_error(&scene, "photon_map", &split(256, "metropolis", more), 4);
    assert_same(found, plain, 0.0, "256 mutations");
    let emitted = |splitting: &str| first_pass(&scene, &split(64, splitting, more)).scalar("photons_emitted");
    let (all, mutated) = (emitted("brute"), emitted("metropolis"));
    assert!(mutated > 2000.0 && mutated < 0.6 * all, "{mutated} photons were emitted, {all} by brute force");
}

#[test]
fn split_caustics_of_threads_and_regions() {
    let scene = repository_scene("caustic-point/scene.xml", "24");
    let ways = [
        r#"{"photons_per_pass": 6000, "caustic_splitting": 5, "splitting": "projection"}"#,
        r#"{"photons_per_pass": 6000, "caustic_splitting": 5, "splitting": "metropolis", "structure": "kdtree"}"#,
        r#"{"photons_per_pass": 6000, "caustic_splitting": 2, "storage": "importance"}"#,
        r#"{"photons_per_pass": 6000, "final_gather": 0, "storage": "importance"}"#,
    ];
    for parameters in ways {
        let bits_of = bits_of_threads(&scene, "photon_map", parameters);
        assert!(bits_of[0] == bits_of[1] && bits_of[1] == bits_of[2], "{parameters}: threads change the picture");
        let job = Job::new(&scene, "photon_map", parameters);
        let trace = |region: Region| {
            let field = job.begin().estimate.radius_field(job.region());
            let radius_squared = vec![1.0; region.pixel_count(scene.width)];
            let shard = Shard { first_pass: 3, passes: 2, region };
            let tally = job.renderer.trace(shard, &RadiusField { radius_squared, ..field }, &job.never);
            bits(&tally.expect("nobody cancels").pixels())
        };
        let whole = trace(job.region());
        let band = trace(Region { row_start: 8, row_end: 16 });
        let row = whole.len() / 24;
        assert!(whole[8 * row..16 * row] == band[..], "{parameters}: regions change the picture");
    }
}

/// The thesis's hundred rooms: few photons lie where rays from the one that is seen end.
#[test]
fn photons_by_importance_make_the_same_picture() {
    let stored = |scene: &Arc<Scene>, storage: &str, more: &str| {
        first_pass(scene, &format!(r#"{{{FIXED_DISCS}{more}, "storage": "{storage}"}}"#)).scalar("photons_stored")
    };
    let rooms = repository_scene("scene10/scene.xml", "32");
    let more = r#", "photons_per_pass": 20000, "emission": "power""#;
    let [all, important] = ["all", "importance"].map(|storage| stored(&rooms, storage, more));
    println!("{all} photons, {important} by importance");
    assert!(important < 0.15 * all, "{important} of {all} photons are stored");
    let picture = |scene: &Arc<Scene>, storage: &str, more: &str, passes: u32| {
        let parameters = format!(r#"{{{FIXED_DISCS}{more}, "storage": "{storage}"}}"#);
        mean_and_error(scene, "photon_map", &parameters, passes)
    };
    let [all, important] = ["all", "importance"].map(|storage| picture(&rooms, storage, more, 4));
    assert_same(important, all, 0.0, "scene10, photons by importance and all");
    let box_with_glass = reference_scene("cornell-glass");
    for rays in [0, 2] {
        let more = format!(r#", "photons_per_pass": 8000, "final_gather": {rays}"#);
        let parameters = |storage: &str| {
            let discs = r#""neighbors": 65536, "caustic_neighbors": 65536, "largest_radius": 0.08"#;
            format!(r#"{{{discs}{more}, "storage": "{storage}"}}"#)
        };
        let [all, important] =
            ["all", "importance"].map(|storage| mean_and_error(&box_with_glass, "photon_map", &parameters(storage), 1));
        assert_same(important, all, 0.0, &format!("cornell-glass, {rays} rays, photons by importance and all"));
    }
}

#[test]
fn splittings_that_cannot_be() {
    let refused = [
        (
            r#"{"splitting": "metropolis"}"#,
            "\"splitting\" is given, but \"caustic_splitting\" is 1: nothing is split; give \"caustic_splitting\" of at least 2",
        ),
        (r#"{"splitting": "projection", "caustic_splitting": 1}"#, "\"splitting\" is given, but"),
        (
            r#"{"caustic_splitting": 5, "max_depth": 2}"#,
            "\"caustic_splitting\" is 5, but paths of 2 segments have no caustic; give \"max_depth\" of at least 3",
        ),
        (
            r#"{"caustic_splitting": 4000, "photons_per_pass": 2000000}"#,
            "2000000 photons in \"caustic_splitting\" 4000 are too many for a pass; give \"caustic_splitting\" of at most 2147",
        ),
        (r#"{"caustic_splitting": 0}"#, "\"caustic_splitting\" is 0; allowed: 1 to 4096"),
        (r#"{"splitting": "random"}"#, "\"splitting\" is \"random\"; allowed: brute, metropolis, projection"),
        (r#"{"storage": "some"}"#, "\"storage\" is \"some\"; allowed: all, importance"),
    ];
    for (parameters, expected) in refused {
        let parameters = serde_json::from_str(parameters).expect("an object");
        let choice = MethodChoice { name: "photon_map".to_owned(), parameters };
        let message = check(&choice, 100).expect_err("refused").to_string();
        assert!(message.starts_with(&format!("method \"photon_map\": {expected}")), "{message}");
    }
}
