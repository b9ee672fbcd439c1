//! What experiments share: scenes, pictures after so many passes, their errors and times.

use std::path::Path;
use std::sync::Arc;

use photonfarm::estimate::declaration::PHOTONS_STORED;
use photonfarm::estimate::{Picture, picture_files};
use photonfarm::evaluation::{Metrics, ProcessStopwatch, Run, Stopwatch, compare};
use photonfarm::import::load_file;
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use serde_json::{Map, Value};

use crate::Fallible;

/// A scene of `scenes/`, `size` pixels wide.
pub(crate) fn scene(file: &str, size: u32) -> Fallible<Arc<Scene>> {
    let description = load_file(&Path::new("scenes").join(file), &[("size".to_owned(), size.to_string())])?;
    Ok(Arc::new(Scene::prepare(&description)?))
}

/// A method, its parameters and how many passes it makes.
pub(crate) struct Experiment<'a> {
    /// Name of the method.
    pub(crate) method: &'a str,
    /// Parameters as users write them in JSON; all others have their defaults.
    pub(crate) parameters: Value,
    /// Passes.
    pub(crate) passes: u32,
    /// Job seed.
    pub(crate) seed: u64,
}

/// A picture, and the processor time that it took, s.
pub(crate) struct Rendered {
    /// The picture.
    pub(crate) picture: Picture,
    /// Processor time, the pilot included, s.
    pub(crate) seconds: f64,
    /// Photons stored in a pass, on average.
    pub(crate) photons_stored: f64,
}

impl Experiment<'_> {
    /// Renders a scene.
    pub(crate) fn render(&self, scene: &Arc<Scene>) -> Fallible<Rendered> {
        let parameters: Map<String, Value> = serde_json::from_value(self.parameters.clone())?;
        let choice = MethodChoice { name: self.method.to_owned(), parameters };
        let checked = method::check(&choice, scene.pixel_count() as u64)?;
        let mut stopwatch = ProcessStopwatch::start()?;
        let mut run = Run::start(scene, &checked, self.seed)?;
        for _ in 0..self.passes {
            run.pass()?;
        }
        let photons_stored = run.count(PHOTONS_STORED) / f64::from(self.passes);
        Ok(Rendered { picture: run.picture(), seconds: stopwatch.spent()?.processor, photons_stored })
    }
}

/// The truth: many passes of a method without bias, with a seed of its own.
pub(crate) fn reference(scene: &Arc<Scene>, method: &str, passes: u32) -> Fallible<Picture> {
    Ok(Experiment { method, parameters: Value::Object(Map::new()), passes, seed: 1999 }.render(scene)?.picture)
}

/// How far a picture is from the truth.
pub(crate) fn errors(picture: &Picture, truth: &Picture) -> Fallible<Metrics> {
    Ok(compare(picture, truth, None)?)
}

/// Writes `docs/measured/photon-maps/NAME.png` and prints the line that shows it.
pub(crate) fn show(picture: &Picture, name: &str, caption: &str) -> Fallible<()> {
    let folder = Path::new("docs/measured/photon-maps");
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join(format!("{name}.png")), picture_files::encode_png(picture, 0.0)?)?;
    println!("![{caption}](photon-maps/{name}.png)");
    Ok(())
}
