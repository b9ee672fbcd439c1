//! Means of eight pictures beside references.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use photonfarm::estimate::picture_files;
use photonfarm::evaluation::compare;
use photonfarm::import::load_file;
use photonfarm::scene::Scene;
use serde_json::Value;

use crate::contenders::{Contender, Subject};

/// References of diffuse and glossy surfaces, glass, a lens, an environment, and light that comes through a slit.
const REFERENCES: [&str; 6] =
    ["cornell-diffuse", "cornell-glass", "dof", "textured-env", "glossy-blocks-a010", "door-ajar"];
/// Pictures of each.
const SEEDS: u64 = 8;

/// Prints the errors of means, where each picture takes `seconds`.
pub(crate) fn print(seconds: f64) -> Result<(), Box<dyn Error>> {
    println!("| reference | method | mean error | of single pictures | relMSE |\n|---|---|---:|---:|---:|");
    let chained = |method| Contender::with(method, vec![("emission", Value::from("metropolis"))]);
    let plain = Contender::plain;
    let contenders = [plain("mmlt"), plain("mlt"), plain("mps"), chained("sppm"), chained("vcm")];
    for name in REFERENCES {
        let folder = Path::new("tests/references").join(name);
        let description = load_file(&folder.join("scene.xml"), &[])?;
        let subject = Subject { name, scene: Arc::new(Scene::prepare(&description)?), hints: None };
        let reference = picture_files::read_exr(&folder.join("ref.exr"))?;
        for contender in &contenders {
            let (mut means, mut error) = (Vec::new(), 0.0);
            for seed in 1..=SEEDS {
                let found = compare(&subject.traced(contender, seed, seconds)?.0.picture(), &reference, None)?;
                means.push(100.0 * found.bias);
                error += found.relmse / SEEDS as f64;
            }
            let count = means.len() as f64;
            let mean = means.iter().sum::<f64>() / count;
            let variance = means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let [low, high] = [f64::min, f64::max].map(|of| means.iter().copied().reduce(of).unwrap_or(mean));
            println!(
                "| {} | {} | {mean:+.2} ± {:.2} % | {low:+.2} to {high:+.2} % | {error:.3} |",
                subject.name,
                contender.label(),
                (variance / count).sqrt()
            );
        }
    }
    Ok(())
}
