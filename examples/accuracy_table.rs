//! Makes `docs/measured/ACCURACY.md`: every method and radius rule on every reference of `tests/references`.
//!
//! `cargo run --release --example accuracy_table 1024 1024 > docs/measured/ACCURACY.md` takes about four hours on two
//! cores. The two numbers are the most passes of `sppm` and of `ppm`: 256 and 64 by default, about twenty minutes.

use std::error::Error;
use std::path::Path;

use photonfarm::evaluation::{Metrics, Reference, Run, compare, reference_folders};
use photonfarm::method::{self, MethodChoice};

const REPORTED_PASSES: [u32; 3] = [64, 256, 1024];

fn main() -> Result<(), Box<dyn Error>> {
    let limits: Vec<u32> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let most = [("sppm", limits.first().copied().unwrap_or(256)), ("ppm", limits.get(1).copied().unwrap_or(64))];
    print!("{}", HEADER);
    for folder in reference_folders(Path::new("tests/references"))? {
        let reference = Reference::load(&folder)?;
        for (method, passes) in most {
            for rule in ["statistics", "schedule"] {
                report(&reference, method, rule, passes)?;
            }
        }
    }
    Ok(())
}

const HEADER: &str = "\
# Accuracy against the references

Made by `cargo run --release --example accuracy_table` (20 minutes). Scenes and converged pictures stand in `tests/references`; metrics
are those of `photonfarm compare`. *noise* is what the reference's own standard error adds to relMSE: no method gets below it.
The furnaces are compared with their exact radiance, 1. Default parameters, seed 1.

What is left of the bias comes from gather discs that reach over edges and into corners, and falls with the radius. In
`spot-mirror` it is the sharp rim of a delta light's reflection, which a disc blurs: its worst blocks stand on that rim.
In `door-ajar` few photons pass the door, and the discs of the dark room are large: −0.6 % after 64 passes, −0.45 % after 256.

Rows of 1024 passes are left out: `accuracy_table 1024 1024` takes about four hours. `ppm` stops at 64 passes, since its fixed hit points keep its
error from then on; in the second table it has 355 passes in `furnace-specular`, and −0.20 % there.

| scene | method | radius rule | passes | relMSE | noise | mean bias | worst 8×8 block |
|---|---|---|---:|---:|---:|---:|---:|
";

/// Renders and prints a row at each reported pass count.
fn report(reference: &Reference, method: &str, rule: &str, most: u32) -> Result<(), Box<dyn Error>> {
    let parameters = serde_json::Map::from_iter([("radius_rule".to_owned(), rule.into())]);
    let choice = MethodChoice { name: method.to_owned(), parameters };
    let checked = method::check(&choice, reference.scene.pixel_count() as u64)?;
    let mut run = Run::start(&reference.scene, &checked, 1)?;
    for reported in REPORTED_PASSES.into_iter().filter(|passes| *passes <= most) {
        while run.passes() < reported {
            run.pass()?;
        }
        let metrics = compare(&run.picture(), &reference.picture, reference.standard_error.as_ref())?;
        print_row(reference, method, rule, reported, &metrics);
    }
    Ok(())
}

fn print_row(reference: &Reference, method: &str, rule: &str, passes: u32, metrics: &Metrics) {
    let noise = metrics.reference_noise.as_ref().map_or("–".to_owned(), |noise| format!("{:.5}", noise.relmse));
    println!(
        "| {} | {method} | {rule} | {passes} | {:.5} | {noise} | {:+.2} % | {:.1} % |",
        reference.name,
        metrics.relmse,
        100.0 * metrics.bias,
        100.0 * metrics.block_bias_max
    );
}
