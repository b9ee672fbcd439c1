//! Markov chains beside other methods, and table 1 and figures 1 to 5 of the paper on Metropolis photon sampling: makes `docs/measured/METROPOLIS.md`.
//!
//! `cargo run --release --example metropolis -- 2 > docs/measured/METROPOLIS.md` gives each picture of the equal-time tables 2 processor-seconds of one thread and
//! each of their references thirty times as many. Names of scenes after the number choose among them. What was found stands in `findings.md`.

mod contenders;
mod equal_time;
mod from_above;
mod means;
mod one_map;
mod where_paths_lead;

use std::error::Error;
use std::process::Command;

use photonfarm::evaluation::Machine;

/// Scenes of the equal-time tables, and the methods of their references.
const SCENES: [(&str, &str); 5] = [
    ("rooms", "bdpt"),
    ("jack-o-lantern", "bdpt"),
    ("mirror-box", "vcm"),
    ("door-ajar", "bdpt"),
    ("invisible-date", "bdpt"),
];

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut arguments = std::env::args().skip(1);
    let seconds: f64 = arguments.next().map_or(Ok(3.0), |text| text.parse())?;
    let chosen: Vec<String> = arguments.collect();
    let is_chosen = |scene: &str| chosen.is_empty() || chosen.iter().any(|name| scene == name);
    println!("{HEAD}\n{}, one thread of {}.", commit()?, Machine::here().processor);
    println!("\n## Table 1: one map\n\n{TABLE_ONE}\n\n{}", one_map::HEAD);
    let rows: Vec<&one_map::Row> = one_map::ROWS.iter().filter(|row| is_chosen(row.scene)).collect();
    for row in &rows {
        row.print()?;
    }
    println!();
    rows.iter().for_each(|row| one_map::show(row));
    if is_chosen("rooms") {
        println!("\n## Figures 1 and 2: where photons lie\n\n{FROM_ABOVE}\n");
        from_above::draw()?;
        println!("\n## Figure 3: what user paths do\n\n{WHERE_PATHS_LEAD}\n");
        where_paths_lead::print("rooms", seconds)?;
    }
    println!("\n## At equal time\n\n{seconds} processor-seconds each. {EQUAL_TIME}");
    for (scene, reference) in SCENES.into_iter().filter(|(scene, _)| is_chosen(scene)) {
        equal_time::print(scene, reference, seconds)?;
    }
    println!(
        "\n## Means\n\nEight pictures of {seconds} processor-seconds each, beside `tests/references`; the standard error is that of the mean.\n"
    );
    means::print(seconds)?;
    println!("\n{}", include_str!("findings.md").trim_end());
    Ok(())
}

/// Which commit this is, and of which day.
fn commit() -> Result<String, Box<dyn Error>> {
    let told = Command::new("git").args(["show", "--no-patch", "--format=Commit %h, %cs"]).output()?;
    Ok(String::from_utf8(told.stdout)?.trim().to_owned())
}

const HEAD: &str = "\
# Markov chains

Made by `cargo run --release --example metropolis -- 2 > docs/measured/METROPOLIS.md` (about forty minutes of one processor).

What chains bring where photons by power hardly come to the picture: Metropolis photon sampling (`mps`), Metropolis light transport of whole paths (`mlt`) and of random numbers (`mmlt`), and photons by
visibility (`emission: metropolis`), beside other methods. Rooms, jack-o'-lantern and mirror box are scenes of the paper on Metropolis photon sampling [Fan, Chenney & Lai 2005], modelled anew.
";

const TABLE_ONE: &str = "\
One photon map for a picture, four camera paths in a pixel, as many gather rays and changes of each kind as in the paper, 60 photons in a look-up, no irradiance cache; 192 × 192 pixels. `mps` leaves about as many
photons as in the paper, and the photon map of photons by power has as many as are traced in the same time. Errors are relative root mean square errors, here less the noise of the reference.";

const FROM_ABOVE: &str = "\
The plan of the rooms; the camera is in the lower room in the middle. Photons by power, and photons of whole paths.";

const WHERE_PATHS_LEAD: &str = "\
Errors near the ends of user paths on the film, and elsewhere. In the paper the share of changes that are taken rises from 58 to 65 % with user paths.";

const EQUAL_TIME: &str = "\
96 × 96 pixels; references are pictures of `bdpt` or `vcm` after thirty times the time, with noise of their own.";
