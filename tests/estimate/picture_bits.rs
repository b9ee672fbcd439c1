//! The bits of pictures, layers and error estimates are those of the committed table `tests/estimate/picture_bits/hashes.txt`.
//!
//! Bits on one target are a promise: a job that is rendered again, or finished by a later build of the same format, looks the
//! same. A change that means to change bits renews the table with
//! `PHOTONFARM_RENEW_BITS=1 cargo test --test estimate picture_bits` and says in its commit message why.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::estimate::{Estimate, RadiusField, Region, Twin};
use photonfarm::farm::rules::plan::Plan;
use photonfarm::import::load_file;
use photonfarm::method::{self, CheckedMethod, METHODS, MethodChoice};
use photonfarm::render::Renderer;
use photonfarm::render::first_surface::first_surface_layers;
use photonfarm::scene::Scene;

const SCENES: [&str; 6] =
    ["cornell-glass-mirror", "caustic-point", "pool", "cornell-ward", "still-life", "concert-hall"];
const SIZE: &str = "24";
/// A row at which the picture is cut into two regions of different size.
const CUT: u32 = 10;
const PASSES: u32 = 26;
const SEED: u64 = 5;

fn table_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/estimate/picture_bits/hashes.txt")
}

fn scene(name: &str) -> Arc<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).join("scene.xml");
    let description = load_file(&path, &[("size".to_owned(), SIZE.to_owned())]).expect("an own scene loads");
    Arc::new(Scene::prepare(&description).expect("an own scene is good"))
}

/// Both radius rules take turns, and few photons keep the test short.
fn checked(scene: &Scene, index: usize, name: &str) -> CheckedMethod {
    let takes = |parameter: &str| {
        method::entry(name).expect("in the table").parameters.iter().any(|known| known.name == parameter)
    };
    let mut parameters = serde_json::Map::new();
    if takes("photons_per_pass") {
        parameters.insert("photons_per_pass".to_owned(), 3000.into());
    }
    if takes("radius_rule") {
        let rule = if index.is_multiple_of(2) { "statistics" } else { "schedule" };
        parameters.insert("radius_rule".to_owned(), rule.into());
    }
    let choice = MethodChoice { name: name.to_owned(), parameters };
    method::check(&choice, scene.pixel_count() as u64).expect("the parameters are good")
}

/// A job in two regions, with shards that grow and radius fields that are an epoch late, as the farm merges it.
fn run(scene: &Arc<Scene>, checked: &CheckedMethod) -> Estimate {
    let never = AtomicBool::new(false);
    let renderer = Renderer::new(scene.clone(), checked, SEED).expect("the method can be prepared");
    let regions = vec![Region { row_start: 0, row_end: CUT }, Region { row_start: CUT, row_end: scene.height }];
    let mut plan = Plan::new(scene.width, scene.height, 1, Some(PASSES), renderer.declaration().radius_rule);
    (plan.regions, plan.passes_per_shard, plan.shards_per_epoch) = (regions, 2, 4);
    let (mut estimate, renderer) = begin(scene, &renderer, &plan.regions);
    let mut fields: BTreeMap<(u32, u32), RadiusField> = BTreeMap::new();
    let take_fields = |estimate: &Estimate, epoch: u32, fields: &mut BTreeMap<(u32, u32), RadiusField>| {
        for (index, region) in plan.regions.iter().enumerate() {
            fields.entry((epoch, index as u32)).or_insert_with(|| estimate.radius_field(*region));
        }
    };
    take_fields(&estimate, 0, &mut fields);
    for index in 0..plan.shard_count() {
        let planned = plan.shard(index).expect("inside the plan");
        let field = &fields[&(planned.field_epoch, planned.region)];
        let tally = renderer.trace(planned.shard, field, &never).expect("nobody cancels");
        estimate.merge(&tally, field).expect("tallies come in order");
        let next = plan.epoch_of(index + 1);
        if next > plan.epoch_of(index) {
            take_fields(&estimate, plan.field_epoch(next + plan.epoch_lag), &mut fields);
        }
    }
    estimate
}

/// The estimate before the first pass, and the renderer of the passes.
fn begin(scene: &Scene, renderer: &Renderer, regions: &[Region]) -> (Estimate, Renderer) {
    let pilot = renderer.pilot(&AtomicBool::new(false)).expect("nobody cancels");
    let declaration = renderer.declaration().clone();
    let estimate = Estimate::new(scene.width, scene.height, regions, declaration, pilot.radius_squared());
    let renderer = renderer.guided(&pilot.guides()).expect("the pilot fits the lights");
    (estimate.expect("the pilot fits"), renderer)
}

fn radius_and_photons(estimate: &Estimate) -> [Vec<f32>; 2] {
    let radius = estimate.pixels().iter().map(|pixel| pixel.radius_squared.sqrt() as f32).collect();
    [radius, estimate.pixels().iter().map(|pixel| pixel.photons as f32).collect()]
}

fn hash(values: impl IntoIterator<Item = f32>) -> String {
    let bytes: Vec<u8> = values.into_iter().flat_map(|value| value.to_bits().to_le_bytes()).collect();
    blake3::hash(&bytes).to_hex()[..24].to_owned()
}

/// One line for everything that a user can get of an estimate.
fn hashes(estimate: &Estimate) -> String {
    let picture = |picture: photonfarm::estimate::Picture| hash(picture.radiance.into_iter().flatten());
    let [radius, photons] = radius_and_photons(estimate);
    let error =
        estimate.error().map_or([f64::NAN; 4], |error| [error.noise, error.sampled_noise, error.bias, error.bound]);
    let error: Vec<u8> = error.iter().flat_map(|value| value.to_bits().to_le_bytes()).collect();
    format!(
        "picture {} even {} odd {} radius {} photons {} standard-error {} error {} emitted {}",
        picture(estimate.picture()),
        picture(estimate.twin_picture(Twin::Even)),
        picture(estimate.twin_picture(Twin::Odd)),
        hash(radius),
        hash(photons),
        hash(estimate.standard_error().unwrap_or_default()),
        &blake3::hash(&error).to_hex()[..24],
        estimate.photons_emitted(),
    )
}

fn first_surface_hash(scene: &Scene) -> String {
    let seen = first_surface_layers(scene);
    hash(seen.iter().flat_map(|pixel| {
        let ([r, g, b], [x, y, z]) = (pixel.albedo.to_array(), pixel.normal.to_array());
        [r, g, b, x, y, z, pixel.depth]
    }))
}

#[test]
fn picture_bits_are_those_of_the_table() {
    let mut found = String::new();
    for (index, name) in SCENES.into_iter().enumerate() {
        let scene = scene(name);
        writeln!(found, "{name} first-surface {}", first_surface_hash(&scene)).expect("a string");
        for entry in METHODS {
            let checked = checked(&scene, index, entry.name);
            let line = hashes(&run(&scene, &checked));
            writeln!(found, "{name} {} {line}", entry.name).expect("a string");
        }
    }
    if std::env::var_os("PHOTONFARM_RENEW_BITS").is_some() {
        std::fs::write(table_path(), &found).expect("the table can be written");
    }
    let expected = std::fs::read_to_string(table_path()).expect("the table is committed");
    let different: Vec<String> = (expected.lines().zip(found.lines()))
        .filter(|(expected, found)| expected != found)
        .map(|(expected, found)| format!("- {expected}\n+ {found}"))
        .collect();
    assert_eq!(expected.lines().count(), found.lines().count(), "a row for each scene and method");
    assert!(different.is_empty(), "bits have changed:\n{}", different.join("\n"));
}
