//! All methods at equal time.

use std::error::Error;

use photonfarm::evaluation::compare;
use serde_json::Value;

use crate::contenders::{Contender, Subject, acceptance, save};

/// Pixels on each side.
const SIZE: u32 = 96;
/// So many times as long a reference takes.
const REFERENCE: f64 = 30.0;
/// Methods whose pictures are shown.
const PICTURES: [&str; 4] = ["mps", "mlt", "photon_map", "sppm"];

fn contenders() -> Vec<Contender> {
    let emitting = |method, emission: &str| Contender::with(method, vec![("emission", Value::from(emission))]);
    let plain = Contender::plain;
    vec![
        plain("mps"),
        plain("mps").hinted(),
        emitting("photon_map", "power"),
        emitting("photon_map", "metropolis"),
        plain("mlt"),
        plain("mlt").hinted(),
        plain("mmlt"),
        emitting("sppm", "power"),
        emitting("sppm", "guided"),
        emitting("sppm", "metropolis"),
        plain("bdpt"),
        emitting("vcm", "auto"),
        emitting("vcm", "metropolis"),
        plain("path"),
    ]
}

/// Prints the table of a scene and saves its pictures; the reference is one of `reference`.
pub(crate) fn print(name: &'static str, reference: &'static str, seconds: f64) -> Result<(), Box<dyn Error>> {
    let subject = Subject::load(name, SIZE)?;
    println!("\n### {name}\n");
    let (run, _) = subject.traced(&Contender::plain(reference), 7, REFERENCE * seconds)?;
    let reference = run.picture();
    println!(
        "| method | passes | relative RMS error | relMSE | mean | worst 8 × 8 block | photons stored in a pass | accepted |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---|");
    let contenders: Vec<Contender> =
        contenders().into_iter().filter(|contender| !contender.is_hinted || subject.hints.is_some()).collect();
    for contender in &contenders {
        let (run, _) = subject.traced(contender, 1, seconds)?;
        let found = compare(&run.picture(), &reference, None)?;
        println!(
            "| {} | {} | {:.4} | {:.5} | {:+.2} % | {:.1} % | {:.0} | {} |",
            contender.label(),
            run.passes(),
            found.relmse.sqrt(),
            found.relmse,
            100.0 * found.bias,
            100.0 * found.block_bias_max,
            run.count("photons_stored") / f64::from(run.passes()),
            acceptance(&run)
        );
        save(&contender.file(name, ""), &run.picture())?;
    }
    println!();
    for contender in contenders.iter().filter(|contender| PICTURES.contains(&contender.method)) {
        println!("![{}](metropolis/{})", contender.label(), contender.file(name, ""));
    }
    Ok(())
}
