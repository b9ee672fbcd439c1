//! What lamps cost that light nothing which is seen: makes `docs/measured/HIDDEN-LAMPS.md`.
//!
//! `cargo run --release --example hidden_lamps -- 10 > docs/measured/HIDDEN-LAMPS.md` gives each cell 10 processor-seconds of one thread and each
//! reference two hundred: about 40 minutes. Names of rows after the number choose among them.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use photonfarm::estimate::Picture;
use photonfarm::evaluation::{Machine, ProcessStopwatch, compare, follow};
use photonfarm::import::load_file;
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use serde_json::{Map, Value};

/// Pixels on each side.
const SIZE: u32 = 96;
const METHODS: [&str; 5] = ["path", "bdpt", "sppm", "vcm", "photon_map"];
/// What methods did before they learnt from a pilot what is hidden.
const BEFORE: [(&str, &str); 3] = [("light_picks", "importance"), ("emission", "power"), ("occlusion", "off")];

/// A scene, the same without the lamps that light nothing seen, and the method of its reference.
struct Row {
    name: &'static str,
    scene: &'static str,
    alone: &'static str,
    reference: &'static str,
}

const ROWS: [Row; 5] = [
    Row {
        name: "a lamp 400 times as strong in the sealed room beside",
        scene: "sealed-lamp/scene.xml",
        alone: "sealed-lamp/alone.xml",
        reference: "path",
    },
    Row {
        name: "a thin sheet, 200 times as bright below",
        scene: "thin-sheet/scene.xml",
        alone: "thin-sheet/alone.xml",
        reference: "path",
    },
    Row { name: "25 rooms", scene: "many-rooms/scene.xml", alone: "many-rooms/alone.xml", reference: "path" },
    Row { name: "100 rooms", scene: "many-rooms/100.xml", alone: "many-rooms/100-alone.xml", reference: "path" },
    Row {
        name: "a glass ball beside a house of 40 lamps",
        scene: "house-of-lamps/scene.xml",
        alone: "house-of-lamps/alone.xml",
        reference: "vcm",
    },
];

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut arguments = std::env::args().skip(1);
    let seconds: f64 = arguments.next().map_or(Ok(10.0), |text| text.parse())?;
    let chosen: Vec<String> = arguments.collect();
    let Machine { processor, .. } = Machine::here();
    println!("{HEADER}\n{seconds} processor-seconds of one thread a cell, {SIZE} × {SIZE} pixels, {processor}.\n");
    println!(
        "| scene | method | alone | before | now | before ÷ alone | now ÷ alone | now: mean | worst 8 × 8 block |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|");
    for row in ROWS.iter().filter(|row| chosen.is_empty() || chosen.iter().any(|name| row.scene.starts_with(name))) {
        let (scene, alone) = (load(row.scene)?, load(row.alone)?);
        let reference = render(&alone, row.reference, &Map::new(), 7, 20.0 * seconds)?;
        for name in METHODS {
            let before = |name: &str| known(name, &BEFORE);
            let without = compare(&render(&alone, name, &before(name), 1, seconds)?, &reference, None)?;
            let before = compare(&render(&scene, name, &before(name), 1, seconds)?, &reference, None)?;
            let now = compare(&render(&scene, name, &Map::new(), 1, seconds)?, &reference, None)?;
            println!(
                "| {} | `{name}` | {:.5} | {:.5} | {:.5} | {:.1} | {:.2} | {:+.2} % | {:.1} % |",
                row.name,
                without.relmse,
                before.relmse,
                now.relmse,
                before.relmse / without.relmse,
                now.relmse / without.relmse,
                100.0 * now.bias,
                100.0 * now.block_bias_max,
            );
        }
    }
    Ok(())
}

fn load(path: &str) -> Result<Arc<Scene>, Box<dyn Error>> {
    let description = load_file(&Path::new("scenes").join(path), &[("size".to_owned(), SIZE.to_string())])?;
    Ok(Arc::new(Scene::prepare(&description)?))
}

/// Those of the parameters that a method has.
fn known(method: &str, parameters: &[(&str, &str)]) -> Map<String, Value> {
    let has = |name: &str| method::entry(method).is_ok_and(|entry| entry.parameters.iter().any(|it| it.name == name));
    let those = parameters.iter().filter(|(name, _)| has(name));
    those.map(|(name, value)| ((*name).to_owned(), Value::from(*value))).collect()
}

fn render(
    scene: &Arc<Scene>,
    method: &str,
    parameters: &Map<String, Value>,
    seed: u64,
    seconds: f64,
) -> Result<Picture, Box<dyn Error>> {
    let choice = MethodChoice { name: method.to_owned(), parameters: parameters.clone() };
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    let snapshots = follow(scene, &checked, seed, &[seconds], &mut ProcessStopwatch::start()?, &mut |_| ())?;
    Ok(snapshots.into_iter().next_back().ok_or("the budget was never spent")?.picture)
}

const HEADER: &str = "\
# What hidden lamps cost

Made by `cargo run --release --example hidden_lamps -- 10 > docs/measured/HIDDEN-LAMPS.md` (about 40 minutes on one core).

Scenes with lamps that light nothing which is seen, each also *alone*: without those lamps. Both have the same picture. relMSE after equal time: *alone*
as methods were before they learnt from a pilot what is hidden (`light_picks: importance`, `emission: power`, `occlusion: off`); *before*, the same with the hidden lamps; *now*, with
them and all defaults. References are pictures of the scene alone after twenty times the time. Means and blocks are of *now* against the
reference.
";
