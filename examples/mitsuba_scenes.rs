//! Makes the table of `docs/measured/MITSUBA-SCENES.md`: small scenes, one for each plugin, default and main parameter, beside Mitsuba's pictures.
//!
//! `cargo run --release --example mitsuba_scenes -- 256` renders all with 256 passes of the method that their integrator asks for; a
//! second argument renders only those whose names start with it. `tools/mitsuba_scenes/make_references.py` makes the scenes and their references.

use std::error::Error;

#[path = "../tests/support/mitsuba_scenes.rs"]
mod mitsuba_scenes;

use mitsuba_scenes::{Judged, Reference, judge, names};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (passes, start) = match arguments.as_slice() {
        [passes] => (passes.parse()?, ""),
        [passes, start] => (passes.parse()?, start.as_str()),
        _ => return Err("usage: mitsuba_scenes PASSES [START OF NAMES]".into()),
    };
    println!("| scene | mean | ± | worst block beyond noise | noise of blocks | |\n|---|---:|---:|---:|---:|---|");
    let (mut rendered, mut agree) = (0, 0);
    let mut versions = std::collections::BTreeSet::new();
    for name in names(start) {
        match judge(&name, passes) {
            Ok(judged) => {
                rendered += 1;
                agree += u32::from(Judged::reason(&name).is_empty() && judged.holds(&name));
                versions.insert(format!("{} {}", judged.reference.mitsuba, judged.reference.variant));
                println!("{}", row(&name, &judged));
            }
            Err(error) => println!("| {name} | not rendered | | | | {error} |"),
        }
    }
    let versions = versions.into_iter().collect::<Vec<_>>().join(", ");
    println!(
        "\n{rendered} scenes are rendered; {agree} agree: the mean within 1 %, no block off by more than 3 %, both beyond noise."
    );
    println!("The references are of Mitsuba {versions}.");
    Ok(())
}

fn row(name: &str, judged: &Judged) -> String {
    let percent = |value: f64, digits: usize| format!("{:+.digits$} %", 100.0 * value);
    let worst = match judged.worst {
        0.0 => "–".to_owned(),
        worst => format!("{} at {}, {}", percent(worst, 1), judged.place[0], judged.place[1]),
    };
    let Reference { variant, samples, .. } = &judged.reference;
    let mut remarks = vec![Judged::reason(name).to_owned()];
    if !judged.holds(name) {
        remarks.push("**differs**".to_owned());
    }
    if variant != "scalar_rgb" {
        remarks.push(format!("beside {samples} samples of `{variant}`"));
    }
    remarks.extend(
        judged
            .notices
            .iter()
            .map(|notice| notice.split_once("): ").map_or(notice.as_str(), |(_, rest)| rest).to_owned()),
    );
    remarks.retain(|remark| !remark.is_empty());
    let (mean, noise) = (percent(judged.mean, 2), 100.0 * judged.mean_noise);
    format!("| {name} | {mean} | {noise:.2} % | {worst} | {:.1} % | {} |", 100.0 * judged.noise, remarks.join("; "))
}
