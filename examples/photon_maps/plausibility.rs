//! Section 4.1: tests of what photons may count, beside a thin sheet with a floor 200 times as bright behind it, and with stray photons of glass.

use serde_json::{Value, json};

use crate::Fallible;
use crate::laboratory::{Experiment, Rendered, errors, reference, scene, show};

/// Pixels on a side.
const SIZE: u32 = 96;
/// Passes of each picture.
const PASSES: u32 = 16;
/// Passes of the truth.
const TRUTH_PASSES: u32 = 2048;

/// Tests, and the parameters that ask for them.
const TESTS: [(&str, &str); 5] = [
    ("none", r#"{}"#),
    ("arrival angle below 90°", r#"{"arrival_angle": 90}"#),
    ("culling plane", r#"{"culling_plane": "on"}"#),
    ("occlusion where unclear", r#"{"occlusion": "unclear"}"#),
    ("occlusion of all photons", r#"{"occlusion": "all"}"#),
];

/// Prints the chapter.
pub(crate) fn run() -> Fallible<()> {
    println!("{CLAIM}");
    behind_a_sheet()?;
    println!("{AFTER_SHEET}");
    stray_photons()?;
    println!("{VERDICT}");
    Ok(())
}

/// Renders with `photon_map`; parameters of `more` come on top of those that all pictures share.
fn render(file: &str, passes: u32, shared: Value, more: Value) -> Fallible<Rendered> {
    let mut parameters = shared;
    if let (Some(all), Value::Object(more)) = (parameters.as_object_mut(), more) {
        all.extend(more);
    }
    Experiment { method: "photon_map", parameters, passes, seed: 1 }.render(&scene(file, SIZE)?)
}

fn behind_a_sheet() -> Fallible<()> {
    let truth = reference(&scene("thin-sheet/alone.xml", SIZE)?, "path", TRUTH_PASSES)?;
    println!("| look-ups | test | mean | worst block | relMSE | time, s |");
    println!("|---|---|---:|---:|---:|---:|");
    for (look_ups, rays) in [("local pass, 4 rays", 4), ("map looked at directly", 0)] {
        for (test, parameters) in TESTS {
            let shared = json!({ "final_gather": rays, "occlusion": "off", "emission": "power" });
            let rendered = render("thin-sheet/scene.xml", PASSES, shared, serde_json::from_str(parameters)?)?;
            let metrics = errors(&rendered.picture, &truth)?;
            println!(
                "| {look_ups} | {test} | {:+.1} % | {:.0} % | {:.4} | {:.1} |",
                100.0 * metrics.bias,
                100.0 * metrics.block_bias_max,
                metrics.relmse,
                rendered.seconds
            );
            if rays == 0 && (test == "none" || test.ends_with("unclear")) {
                let name = if test == "none" { "plausibility-none" } else { "plausibility-unclear" };
                show(&rendered.picture, name, &format!("Map looked at directly, test: {test}"))?;
            }
        }
    }
    Ok(())
}

fn stray_photons() -> Fallible<()> {
    let truth = reference(&scene("scene5/scene.xml", SIZE)?, "bdpt", TRUTH_PASSES / 4)?;
    println!("| fewest of 50 photons | mean | relMSE | without the worst 0.1 % | time, s |");
    println!("|---:|---:|---:|---:|---:|");
    for fewest in [0, 10, 30] {
        let shared = json!({ "caustic_neighbors": 50, "photons_per_pass": 100_000 });
        let rendered = render("scene5/scene.xml", PASSES, shared, json!({ "fewest_photons": fewest }))?;
        let metrics = errors(&rendered.picture, &truth)?;
        println!(
            "| {} | {:+.2} % | {:.5} | {:.5} | {:.1} |",
            50 * fewest / 100,
            100.0 * metrics.bias,
            metrics.relmse,
            metrics.relmse_trimmed,
            rendered.seconds
        );
    }
    Ok(())
}

const CLAIM: &str = "\
Claim: photons that could not have come to a point can be told by tests. The angle between a photon's direction and the normal, and a culling plane through the
point, cost little and are only heuristics: \"cases of bad classifications can be easily constructed\". Too few photons within a largest radius (less than 10 % of k) are stray ones; to drop them
takes their noise away, and their energy. To see whether the point sees the photon's origin is right, and dear: with a local pass INVISIBLEDATE took 9 hours instead of 6, by skipping 15
instead of 2½.

Here `photon_map` has all of them (`arrival_angle`, `culling_plane`, `fewest_photons`, `occlusion`), and occlusion is tested only where something that stands on the surface bars the way
to a photon ([METHODS.md](METHODS.md#photons-behind-walls)); the progressive methods have that, too. Photons on surfaces that face another way (more than 45°) never count. A thin sheet with
a floor 200 times as bright behind it, `photon_map` after 16 passes at 96²:
";

const AFTER_SHEET: &str = "
The photons of SCENE5's glass ball, caustic look-ups with 50 photons, 16 passes at 96²:
";

const VERDICT: &str = "\
";
