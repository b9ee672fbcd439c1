//! The second table of `docs/measured/ACCURACY.md`: every method on every reference after the same processor time.
//!
//! `cargo run --release --example equal_time_table -- 30 [reference …]` gives each cell 30 processor-seconds of one thread: with 9
//! methods and 11 references that is 50 minutes.

use std::error::Error;
use std::path::{Path, PathBuf};

use photonfarm::evaluation::{ProcessStopwatch, Reference, compare, follow, reference_folders};
use photonfarm::method::{self, MethodChoice, SceneTraits};

const REFERENCES: &str = "tests/references";

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut arguments = std::env::args().skip(1);
    let seconds: f64 =
        arguments.next().ok_or("say how many processor-seconds a cell takes, for example 30")?.parse()?;
    let mut folders: Vec<PathBuf> = arguments.map(|name| Path::new(REFERENCES).join(name)).collect();
    if folders.is_empty() {
        folders = reference_folders(Path::new(REFERENCES))?;
    }
    println!("| scene | method | passes | relMSE | mean bias | worst 8×8 block | |");
    println!("|---|---|---:|---:|---:|---:|---|");
    for folder in folders {
        let reference = Reference::load(&folder)?;
        for entry in method::table() {
            println!("{}", row(&reference, entry.name, seconds)?);
        }
    }
    Ok(())
}

fn row(reference: &Reference, method: &str, seconds: f64) -> Result<String, Box<dyn Error>> {
    let choice = MethodChoice { name: method.to_owned(), parameters: serde_json::Map::new() };
    let Reference { name, scene, picture, .. } = reference;
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    let snapshots = follow(scene, &checked, 1, &[seconds], &mut ProcessStopwatch::start()?, &mut |_| ())?;
    let last = snapshots.last().ok_or("the budget was never spent")?;
    let metrics = compare(&last.picture, picture, None)?;
    let blind = method::blind_spot(&checked, SceneTraits::of(scene)).map_or("", |_| "some light not sampled");
    Ok(format!(
        "| {name} | {method} | {} | {:.5} | {:+.2} % | {:.1} % | {blind} |",
        last.passes,
        metrics.relmse,
        100.0 * metrics.bias,
        100.0 * metrics.block_bias_max
    ))
}
