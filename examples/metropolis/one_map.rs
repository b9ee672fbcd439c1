//! Table 1 of the paper: one photon map for a picture, with its numbers of photons, gather rays and changes of each kind. Figures 4 to 6 are the pictures.

use std::error::Error;

use photonfarm::estimate::Picture;
use photonfarm::evaluation::compare;
use serde_json::{Value, json};

use crate::contenders::{Contender, Subject, acceptance, save};

/// Pixels on each side; the paper's pictures have eight times as many in all.
const SIZE: u32 = 192;
/// Processor-seconds of a reference.
const REFERENCE: f64 = 100.0;

/// What the paper tells of a scene.
pub(crate) struct Row {
    pub(crate) scene: &'static str,
    reference: &'static str,
    /// Metropolis photon sampling, photon mapping: photons.
    photons: [u32; 2],
    /// Relative root mean square errors.
    errors: [f64; 2],
    /// s.
    seconds: [f64; 2],
    gather_rays: u32,
    /// Of changes by bidirectional paths, to other places of the film, to places nearby, of caustics, of gather rays, by user paths; %.
    changes: [u32; 6],
    /// States of chains that leave about as many photons as the paper has.
    states: u32,
}

/// The scenes of table 1.
pub(crate) const ROWS: [Row; 3] = [
    Row {
        scene: "rooms",
        reference: "bdpt",
        photons: [81_004, 300_000],
        errors: [0.036, 0.4239],
        seconds: [480.0, 478.0],
        gather_rays: 40,
        changes: [30, 20, 20, 0, 20, 10],
        states: 500_000,
    },
    Row {
        scene: "jack-o-lantern",
        reference: "bdpt",
        photons: [8_675, 37_160],
        errors: [0.0728, 1.165],
        seconds: [206.0, 202.0],
        gather_rays: 30,
        changes: [40, 20, 20, 0, 20, 0],
        states: 60_000,
    },
    Row {
        scene: "mirror-box",
        reference: "vcm",
        photons: [47_798, 250_000],
        errors: [0.0214, 0.0227],
        seconds: [243.0, 242.0],
        gather_rays: 40,
        changes: [30, 20, 8, 12, 20, 10],
        states: 300_000,
    },
];

/// The head of the table.
pub(crate) const HEAD: &str = "\
| scene | method | paper: photons | error | s | here: photons stored | processor-seconds | error | mean | accepted |
|---|---|---:|---:|---:|---:|---:|---:|---:|---|";

impl Row {
    /// Prints the rows of a scene and saves their pictures.
    pub(crate) fn print(&self) -> Result<(), Box<dyn Error>> {
        let subject = Subject::load(self.scene, SIZE)?;
        let (reference, _) = subject.traced(&Contender::plain(self.reference), 7, REFERENCE)?;
        let noise = reference.error().map_or(0.0, |error| error.noise);
        let reference = reference.picture();
        save(&format!("{}-reference.png", self.scene), &reference)?;
        let sampling = || Contender::with("mps", self.sampling());
        let mapping = self.as_long_as(&subject, subject.traced(&sampling(), 1, 0.0)?.1)?;
        let hinted = subject.hints.is_some().then(|| sampling().hinted());
        for contender in [Some(sampling()), hinted, Some(mapping)].into_iter().flatten() {
            self.print_row(&subject, &contender, &reference, noise)?;
        }
        Ok(())
    }

    fn print_row(
        &self,
        subject: &Subject,
        contender: &Contender,
        reference: &Picture,
        noise: f64,
    ) -> Result<(), Box<dyn Error>> {
        let (run, seconds) = subject.traced(contender, 1, 0.0)?;
        let found = compare(&run.picture(), reference, None)?;
        let of_paper = usize::from(contender.method == "photon_map");
        println!(
            "| {} | {} | {} | {} | {:.0} | {:.0} | {seconds:.1} | {:.4} | {:+.2} % | {} |",
            self.scene,
            contender.label(),
            self.photons[of_paper],
            self.errors[of_paper],
            self.seconds[of_paper],
            run.count("photons_stored"),
            (found.relmse - noise).max(0.0).sqrt(),
            100.0 * found.bias,
            acceptance(&run)
        );
        save(&contender.file(self.scene, "one-map-"), &run.picture())
    }

    /// What both methods have.
    fn gather(&self) -> Vec<(&'static str, Value)> {
        vec![("camera_paths", json!(4)), ("final_gather", json!(self.gather_rays)), ("neighbors", json!(60))]
    }

    fn sampling(&self) -> Vec<(&'static str, Value)> {
        const KINDS: [&str; 6] = ["bidirectional", "lens_subpath", "lens", "caustic", "photon_map", "user_path"];
        let changes = KINDS.into_iter().zip(self.changes.map(Value::from));
        self.gather().into_iter().chain(changes).chain([("photons_per_pass", json!(self.states))]).collect()
    }

    /// A photon map of photons by power that takes about as long: four times as many photons as long as there is time, and then what lies between.
    fn as_long_as(&self, subject: &Subject, seconds: f64) -> Result<Contender, Box<dyn Error>> {
        let mapping = |photons: f64| {
            let own = [("emission", json!("power")), ("photons_per_pass", json!(photons as u32))];
            Contender::with("photon_map", self.gather().into_iter().chain(own).collect())
        };
        let mut before = (FEWEST, 0.0);
        let mut now = (FEWEST, subject.traced(&mapping(FEWEST), 1, 0.0)?.1);
        while now.1 < seconds && now.0 < MOST {
            before = now;
            now = (4.0 * now.0, subject.traced(&mapping(4.0 * now.0), 1, 0.0)?.1);
        }
        let share = ((seconds - before.1) / (now.1 - before.1).max(1e-3)).clamp(0.0, 1.0);
        Ok(mapping(before.0 + share * (now.0 - before.0)))
    }
}

/// Photons that a map has at least and at most, to take as long as another method.
const FEWEST: f64 = 1000.0;
const MOST: f64 = 4e6;

/// Links to the pictures of a scene.
pub(crate) fn show(row: &Row) {
    for (name, file) in [
        ("Metropolis photon sampling", format!("{}-one-map-mps.png", row.scene)),
        ("with user paths", format!("{}-one-map-mps-user-paths.png", row.scene)),
        ("photon map", format!("{}-one-map-photon_map-power.png", row.scene)),
        ("reference", format!("{}-reference.png", row.scene)),
    ] {
        if std::path::Path::new("docs/measured/metropolis").join(&file).exists() {
            println!("![{}, {name}](metropolis/{file})", row.scene);
        }
    }
}
