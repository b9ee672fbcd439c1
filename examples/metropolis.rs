//! Chains and other methods at equal time where photons are hard to come by: makes `docs/METROPOLIS.md`.
//!
//! `cargo run --release --example metropolis -- 3 > docs/METROPOLIS.md` gives each picture 3 processor-seconds of one thread and each reference thirty
//! times as many: about ten minutes. Names of scenes after the number choose among them. Its last chapters are written by hand.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use photonfarm::estimate::{Picture, picture_files};
use photonfarm::evaluation::{Machine, ProcessStopwatch, Run, Stopwatch, compare};
use photonfarm::import::load_file;
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use photonfarm::transport::counters::Step;
use serde_json::{Map, Value};

/// Pixels on each side.
const SIZE: u32 = 96;
/// So many times as long a reference takes.
const REFERENCE: f64 = 30.0;

/// A scene, and the method of its reference.
struct Row {
    scene: &'static str,
    reference: &'static str,
    /// The paper's relative root mean square errors: Metropolis photon sampling, photon mapping.
    paper: Option<[f64; 2]>,
}

const ROWS: [Row; 5] = [
    Row { scene: "rooms", reference: "bdpt", paper: Some([0.036, 0.424]) },
    Row { scene: "jack-o-lantern", reference: "bdpt", paper: Some([0.073, 1.165]) },
    Row { scene: "mirror-box", reference: "vcm", paper: Some([0.0214, 0.0227]) },
    Row { scene: "door-ajar", reference: "bdpt", paper: None },
    Row { scene: "invisible-date", reference: "bdpt", paper: None },
];

/// A method with one parameter that is not at its default, or with the hints beside the scene.
struct Contender {
    method: &'static str,
    parameter: Option<(&'static str, &'static str)>,
    is_hinted: bool,
}

const fn plain(method: &'static str) -> Contender {
    Contender { method, parameter: None, is_hinted: false }
}

const fn emitting(method: &'static str, emission: &'static str) -> Contender {
    Contender { method, parameter: Some(("emission", emission)), is_hinted: false }
}

const fn hinted(method: &'static str) -> Contender {
    Contender { method, parameter: None, is_hinted: true }
}

const CONTENDERS: [Contender; 12] = [
    plain("mps"),
    hinted("mps"),
    emitting("photon_map", "power"),
    plain("mlt"),
    hinted("mlt"),
    emitting("sppm", "power"),
    emitting("sppm", "guided"),
    emitting("sppm", "metropolis"),
    plain("mmlt"),
    plain("bdpt"),
    plain("vcm"),
    plain("path"),
];

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut arguments = std::env::args().skip(1);
    let seconds: f64 = arguments.next().map_or(Ok(20.0), |text| text.parse())?;
    let chosen: Vec<String> = arguments.collect();
    println!(
        "{HEADER}\n{seconds} processor-seconds of one thread, {SIZE} × {SIZE} pixels, {}.",
        Machine::here().processor
    );
    for row in ROWS.iter().filter(|row| chosen.is_empty() || chosen.iter().any(|name| row.scene == name)) {
        let path = Path::new("scenes").join(row.scene).join("scene.xml");
        let description = load_file(&path, &[("size".to_owned(), SIZE.to_string())])?;
        let scene = Arc::new(Scene::prepare(&description)?);
        println!("\n## {}\n", row.scene);
        if let Some([sampled, mapped]) = row.paper {
            println!("In the paper: Metropolis photon sampling {sampled}, photon mapping {mapped}.\n");
        }
        let reference = traced(&scene, &plain(row.reference), None, 7, REFERENCE * seconds)?.picture();
        println!(
            "| method | passes | relative RMS error | relMSE | mean | worst 8 × 8 block | photons stored in a pass | accepted |"
        );
        println!("|---|---:|---:|---:|---:|---:|---:|---|");
        let hints = hints(row)?;
        let contenders: Vec<&Contender> =
            CONTENDERS.iter().filter(|contender| !contender.is_hinted || hints.is_some()).collect();
        for contender in &contenders {
            let hints = hints.as_ref().filter(|_| contender.is_hinted);
            let run = traced(&scene, contender, hints, 1, seconds)?;
            let found = compare(&run.picture(), &reference, None)?;
            println!(
                "| {} | {} | {:.4} | {:.5} | {:+.2} % | {:.1} % | {:.0} | {} |",
                label(contender),
                run.passes(),
                found.relmse.sqrt(),
                found.relmse,
                100.0 * found.bias,
                100.0 * found.block_bias_max,
                run.count("photons_stored") / f64::from(run.passes().max(1)),
                acceptance(&run)
            );
            save(row, contender, &run.picture())?;
        }
        println!();
        for contender in contenders.iter().filter(|contender| PICTURES.contains(&contender.method)) {
            println!("![{}](metropolis/{})", label(contender), file(row, contender));
        }
    }
    Ok(())
}

/// Methods whose pictures are shown.
const PICTURES: [&str; 4] = ["mps", "mlt", "photon_map", "sppm"];

/// Paths that lead to where light comes from, if the scene has a file of them.
fn hints(row: &Row) -> Result<Option<Value>, Box<dyn Error>> {
    let file = Path::new("scenes").join(row.scene).join("user-paths.json");
    if !file.exists() {
        return Ok(None);
    }
    Ok(Some(serde_json::from_str(&std::fs::read_to_string(file)?)?))
}

/// A run that lasted for so many processor-seconds, its pilot included.
fn traced(
    scene: &Arc<Scene>,
    contender: &Contender,
    hints: Option<&Value>,
    seed: u64,
    seconds: f64,
) -> Result<Run, Box<dyn Error>> {
    let own = contender.parameter.iter().map(|(name, value)| ((*name).to_owned(), Value::from(*value)));
    let hints = hints.iter().map(|hints| ("user_paths".to_owned(), (*hints).clone()));
    let parameters: Map<String, Value> = own.chain(hints).collect();
    let choice = MethodChoice { name: contender.method.to_owned(), parameters };
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    let mut stopwatch = ProcessStopwatch::start()?;
    let mut run = Run::start(scene, &checked, seed)?;
    while stopwatch.spent()?.processor < seconds {
        run.pass()?;
    }
    Ok(run)
}

fn label(Contender { method, parameter, is_hinted }: &Contender) -> String {
    let of_parameter = parameter.map_or(String::new(), |(name, value)| format!(", `{name}: {value}`"));
    format!("`{method}`{of_parameter}{}", if *is_hinted { ", user paths" } else { "" })
}

fn acceptance(run: &Run) -> String {
    let share = |step: &Step| {
        let [proposed, accepted] = ["proposed", "accepted"].map(|what| run.count(&format!("{}_{what}", step.name())));
        (proposed > 0.0).then(|| format!("{} {:.0} %", step.name().replace('_', " "), 100.0 * accepted / proposed))
    };
    let shares: Vec<String> = Step::ALL.iter().filter_map(share).collect();
    shares.join(", ")
}

fn file(row: &Row, Contender { method, parameter, is_hinted }: &Contender) -> String {
    let value = parameter.map_or(String::new(), |(_, value)| format!("-{value}"));
    format!("{}-{method}{value}{}.png", row.scene, if *is_hinted { "-user-paths" } else { "" })
}

fn save(row: &Row, contender: &Contender, picture: &Picture) -> Result<(), Box<dyn Error>> {
    let folder = Path::new("docs/metropolis");
    std::fs::create_dir_all(folder)?;
    Ok(std::fs::write(folder.join(file(row, contender)), picture_files::encode_png(picture, 0.0)?)?)
}

const HEADER: &str = "\
# Markov chains

Made by `cargo run --release --example metropolis -- 3 > docs/METROPOLIS.md` (about ten minutes).

What chains bring where photons by power hardly come to the picture: photons of `sppm` by chains of whole paths (`emission: metropolis`) and Metropolis light transport (`mmlt`) beside
other methods at equal time. Scenes are those of the paper on Metropolis photon sampling, modelled anew, with its relative root mean square errors of about two hundred seconds of a machine of 2005, at four to
eight hundred pixels a side; and two more that are hard to light. References are pictures of `bdpt` or `vcm` after thirty times the time.
";
