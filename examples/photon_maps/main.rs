//! The experiments of the photon-map thesis, run here: makes `docs/measured/PHOTON-MAPS.md` and the pictures beside it.
//!
//! `cargo run --release --example photon_maps > docs/measured/PHOTON-MAPS.md` runs all chapters; names behind `--` choose among them. How long
//! each takes stands in [`CHAPTERS`].

mod caustic_splitting;
mod choice_of_k;
mod direct_light;
mod hierarchy;
mod importance;
mod laboratory;
mod local_pass;
mod many_maps;
mod plausibility;
mod radii;
mod storage;
mod structures;

use std::error::Error;

use photonfarm::evaluation::Machine;

type Fallible<T> = Result<T, Box<dyn Error>>;

/// A chapter of the thesis.
struct Chapter {
    /// What it is chosen by.
    name: &'static str,
    /// Its heading, with the thesis' section in brackets.
    heading: &'static str,
    /// Processor time on one core, min.
    minutes: u32,
    /// Prints its claim, our figures beside its figures, and whether the claim holds.
    run: fn() -> Fallible<()>,
}

const CHAPTERS: &[Chapter] = &[
    Chapter {
        name: "structures",
        heading: "Structures to look photons up in (2.2 to 2.4)",
        minutes: 6,
        run: structures::run,
    },
    Chapter {
        name: "plausibility",
        heading: "Photons that could not have come here (4.1)",
        minutes: 4,
        run: plausibility::run,
    },
    Chapter {
        name: "direct_light",
        heading: "Separate calculation of direct light (4.2)",
        minutes: 5,
        run: direct_light::run,
    },
    Chapter {
        name: "local_pass",
        heading: "Local pass with irradiance caching (4.3)",
        minutes: 6,
        run: local_pass::run,
    },
    Chapter { name: "many_maps", heading: "Many photon maps (4.4)", minutes: 4, run: many_maps::run },
    Chapter { name: "hierarchy", heading: "The hierarchical photon map (4.5)", minutes: 3, run: hierarchy::run },
    Chapter {
        name: "caustic_splitting",
        heading: "Splitting of caustic photons (4.6)",
        minutes: 4,
        run: caustic_splitting::run,
    },
    Chapter { name: "storage", heading: "Storage by importance (4.7)", minutes: 4, run: storage::run },
    Chapter { name: "importance", heading: "Photons where they are needed (4.7)", minutes: 4, run: importance::run },
    Chapter { name: "choice_of_k", heading: "Choosing k (4.8)", minutes: 2, run: choice_of_k::run },
    Chapter {
        name: "radii",
        heading: "Discs that shrink where photons are uneven (after 4.8)",
        minutes: 4,
        run: radii::run,
    },
];

fn main() -> Fallible<()> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    if let Some(unknown) = chosen.iter().find(|name| !CHAPTERS.iter().any(|chapter| chapter.name == **name)) {
        let names: Vec<&str> = CHAPTERS.iter().map(|chapter| chapter.name).collect();
        return Err(format!("there is no chapter \"{unknown}\"; there are {}", names.join(", ")).into());
    }
    let minutes: u32 = CHAPTERS.iter().map(|chapter| chapter.minutes).sum();
    println!("{HEADER}\n{}, one thread; about {minutes} minutes for all of it.", Machine::here().processor);
    for chapter in CHAPTERS.iter().filter(|chapter| chosen.is_empty() || chosen.iter().any(|name| name == chapter.name))
    {
        println!("\n## {}\n", chapter.heading);
        (chapter.run)()?;
    }
    println!("\nKeys in brackets: [REFERENCES.md](../REFERENCES.md).");
    Ok(())
}

const HEADER: &str = "\
# Photon maps: what the thesis found, and what is found here

Wald's thesis [Wald 1999] names what is wrong with photon maps and tries remedies, chapter by chapter: its claim, its figures beside ours, our picture, and whether
the claim holds. Its machines were a DEC Alpha at 333 MHz and a Celeron at 450 MHz, so only ratios of times compare; its scenes are modelled anew, so only ratios of
errors do.

Made by `cargo run --release --example photon_maps > docs/measured/PHOTON-MAPS.md`; one chapter by its name behind `--`.
";
