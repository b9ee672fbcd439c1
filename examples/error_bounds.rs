//! How often a job's own error bound holds: makes `docs/measured/ERROR-BOUNDS.md`.
//!
//! `cargo run --release --example error_bounds -- 4 > docs/measured/ERROR-BOUNDS.md`: seeds per method and scene, 4 by default; about 25 minutes on
//! one core. Names of references after the number choose among them.

use std::error::Error;
use std::path::Path;

use photonfarm::estimate::ErrorEstimate;
use photonfarm::evaluation::{Reference, Run, compare, reference_folders};
use photonfarm::method::{self, MethodChoice, SceneTraits};

const METHODS: [&str; 4] = ["sppm", "path", "bdpt", "vcm"];
const LOOKS: [u32; 3] = [8, 16, 32];

/// A picture's error, and what its job said.
struct Look {
    passes: u32,
    real: f64,
    told: ErrorEstimate,
}

impl Look {
    fn holds(&self) -> bool {
        self.real <= self.told.bound
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(4), |text| text.parse())?;
    print!("{}", HEADER.replace("SEEDS", &seeds.to_string()));
    let mut all = Vec::new();
    let chosen: Vec<String> = std::env::args().skip(2).collect();
    for folder in reference_folders(Path::new("tests/references"))? {
        let reference = Reference::load(&folder)?;
        if !chosen.is_empty() && !chosen.contains(&reference.name) {
            continue;
        }
        for method in METHODS {
            let choice = MethodChoice { name: method.to_owned(), parameters: Default::default() };
            let checked = method::check(&choice, reference.scene.pixel_count() as u64)?;
            let blind = method::blind_spot(&checked, SceneTraits::of(&reference.scene)).is_some();
            let mut looks = Vec::new();
            for seed in 1..=seeds {
                looks.extend(look(&reference, Run::start(&reference.scene, &checked, seed)?)?);
            }
            print_row(&reference.name, method, blind, &looks);
            if !blind {
                all.extend(looks);
            }
        }
    }
    println!("\nOf {} pictures by methods that find all light, {:.1} % keep their bound.", all.len(), percent(&all));
    for passes in LOOKS {
        let some: Vec<Look> = all.extract_if(.., |look| look.passes == passes).collect();
        println!("After {passes} passes: {:.1} %.", percent(&some));
    }
    Ok(())
}

fn look(reference: &Reference, mut run: Run) -> Result<Vec<Look>, Box<dyn Error>> {
    let mut looks = Vec::new();
    for passes in LOOKS {
        while run.passes() < passes {
            run.pass()?;
        }
        let metrics = compare(&run.picture(), &reference.picture, reference.standard_error.as_ref())?;
        let real = metrics.reference_noise.map_or(metrics.relmse, |noise| noise.relmse_left);
        looks.push(Look { passes, real, told: run.error().ok_or("a black picture")? });
    }
    Ok(looks)
}

fn percent(looks: &[Look]) -> f64 {
    100.0 * looks.iter().filter(|look| look.holds()).count() as f64 / looks.len().max(1) as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn print_row(scene: &str, method: &str, blind: bool, looks: &[Look]) {
    let ratio =
        |told: fn(&ErrorEstimate) -> f64| median(looks.iter().map(|look| told(&look.told) / look.real).collect());
    let last = looks.iter().filter(|look| look.passes == LOOKS[LOOKS.len() - 1]).map(|look| look.real);
    println!(
        "| {scene} | {method}{} | {:.5} | {:.2} | {:.2} | {:.0} % |",
        if blind { " (blind)" } else { "" },
        median(last.collect()),
        ratio(|error| error.noise + error.bias),
        ratio(|error| error.bound),
        percent(looks)
    );
}

const HEADER: &str = "\
# A job's own error estimate, checked

Made by `cargo run --release --example error_bounds -- SEEDS > docs/measured/ERROR-BOUNDS.md` (about 6 minutes a seed on one busy core).

Every job makes two independent pictures, of its even and of its odd passes. Their difference gives the noise of the mean, in relMSE; what is found inside half of
each gather disc beside the whole disc gives the bias of density estimates (`src/estimate/error.rs` has the formulas). The **bound** is 1.15 times the estimate
plus 1.645 standard deviations of it over blocks of 16 × 16 pixels, and is meant to hold in 95 % of pictures. The factor is a
margin for Y, which an estimate without a reference takes from the pixels around: errors of dark pixels beside bright ones then look smaller than they are.

Y leaves the pixel itself out unless it is known to 10 %. Its own value rises and falls with its error: with it errors looked small where they
were large, by 14 % in the median of noisy pictures and by 63 % where few bright paths make all the noise, and the margin had to be 2. Correcting for the curvature of 1/Y² to second order
instead made it worse: noise is skewed.

It can only tell what its passes have seen. While the rare paths that carry much light have not been met (path tracing of caustics, light through a
door), both twins miss them alike, and estimate and bound are too small. Methods that are blind to some light never learn of it; jobs say so beforehand.

Where a disc reaches from the dark into bright light, the picture itself is no measure of how dark it should be: half discs find the squared bias of `sppm` in
`spot-mirror` (0.079 where 0.076 is right), but relative to the blurred picture that was an eighth of the error, and no bound held. Now Y is the picture less its bias there, and what
chance makes of that is told by turning one twin's sign around.

Each row: SEEDS seeds, looked at after 8, 16 and 32 passes. *relMSE* is the median after 32 passes, without the reference's noise; *told* and *bound* are medians of estimate and
bound over the true relMSE.

| scene | method | relMSE | told | bound | holds |
|---|---|---:|---:|---:|---:|
";
