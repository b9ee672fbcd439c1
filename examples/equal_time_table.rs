//! The second table of `docs/ACCURACY.md`: every method on every reference after the same processor time.
//!
//! `cargo run --release --example equal_time_table -- 30 [reference …]` gives each cell 30 processor-seconds of one thread: with 9
//! methods and 11 references that is 50 minutes. Processor time is Linux's own count for this process.

#[path = "support/processor_time.rs"]
mod processor_time;

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::estimate::picture_files::read_exr;
use photonfarm::estimate::{Estimate, Picture, Region, Shard};
use photonfarm::evaluation::compare;
use photonfarm::method::{self, MethodChoice, SceneTraits};
use photonfarm::render::Renderer;
use photonfarm::scene::{Scene, import};
use processor_time::processor_seconds;

const REFERENCES: &str = "tests/references";
/// Passes traced with one radius field, as many as a small farm has in flight.
const PASSES_PER_FIELD: u32 = 16;

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut arguments = std::env::args().skip(1);
    let seconds: f64 =
        arguments.next().ok_or("say how many processor-seconds a cell takes, for example 30")?.parse()?;
    let mut names: Vec<String> = arguments.collect();
    if names.is_empty() {
        names = all_references()?;
    }
    println!("| scene | method | passes | relMSE | mean bias | worst 8×8 block | |");
    println!("|---|---|---:|---:|---:|---:|---|");
    for name in names {
        let folder = Path::new(REFERENCES).join(&name);
        let scene = Arc::new(Scene::prepare(&import::load_file(&folder.join("scene.xml"), &[])?)?);
        let mut reference = read_exr(&folder.join("ref.exr"))?;
        if name.starts_with("furnace") {
            reference.radiance.fill([1.0; 3]);
        }
        for entry in method::table() {
            println!("{}", row(&name, &scene, &reference, entry.name, seconds)?);
        }
    }
    Ok(())
}

fn all_references() -> Result<Vec<String>, Box<dyn Error>> {
    let mut names: Vec<String> = std::fs::read_dir(REFERENCES)?
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|name| Path::new(REFERENCES).join(name).join("scene.xml").exists())
        .collect();
    names.sort();
    Ok(names)
}

fn row(
    name: &str,
    scene: &Arc<Scene>,
    reference: &Picture,
    method: &str,
    seconds: f64,
) -> Result<String, Box<dyn Error>> {
    let choice = MethodChoice { name: method.to_owned(), parameters: serde_json::Map::new() };
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    let start = processor_seconds()?;
    let renderer = Renderer::new(scene.clone(), &checked, 1)?;
    let go_on = AtomicBool::new(false);
    let region = Region { row_start: 0, row_end: scene.height };
    let first = renderer.pilot(&go_on)?.radius_squared;
    let mut estimate = Estimate::new(scene.width, scene.height, &[region], &first, checked.radius_rule, checked.alpha);
    let mut field = estimate.radius_field(region);
    while processor_seconds()? - start < seconds {
        let first_pass = estimate.passes();
        if first_pass.is_multiple_of(PASSES_PER_FIELD) {
            field = estimate.radius_field(region);
        }
        let tally = renderer.trace(Shard { first_pass, passes: 1, region }, &field, &go_on)?;
        estimate.merge(&tally, &field)?;
    }
    let metrics = compare(&estimate.picture(), reference, None)?;
    let blind = method::blind_spot(&checked, SceneTraits::of(scene)).map_or("", |_| "some light not sampled");
    Ok(format!(
        "| {name} | {method} | {} | {:.5} | {:+.2} % | {:.1} % | {blind} |",
        estimate.passes(),
        metrics.relmse,
        100.0 * metrics.bias,
        100.0 * metrics.block_bias_max
    ))
}
