//! Scenes, and methods that render them.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photonfarm::estimate::{Picture, picture_files};
use photonfarm::evaluation::{ProcessStopwatch, Run, Stopwatch};
use photonfarm::import::load_file;
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use photonfarm::transport::counters::Step;
use serde_json::{Map, Value};

/// A method with parameters that are not at their defaults, and perhaps the hints beside the scene.
pub(crate) struct Contender {
    pub(crate) method: &'static str,
    pub(crate) parameters: Vec<(&'static str, Value)>,
    pub(crate) is_hinted: bool,
}

impl Contender {
    pub(crate) fn plain(method: &'static str) -> Self {
        Self { method, parameters: Vec::new(), is_hinted: false }
    }

    pub(crate) fn with(method: &'static str, parameters: Vec<(&'static str, Value)>) -> Self {
        Self { method, parameters, is_hinted: false }
    }

    pub(crate) fn hinted(self) -> Self {
        Self { is_hinted: true, ..self }
    }

    /// What a table calls it: the method, and parameters that are words.
    pub(crate) fn label(&self) -> String {
        let words = self.parameters.iter().filter_map(|(name, value)| Some(format!(", `{name}: {}`", value.as_str()?)));
        format!("`{}`{}{}", self.method, words.collect::<String>(), if self.is_hinted { ", user paths" } else { "" })
    }

    /// The name of its picture of a scene, after which words `kind`.
    pub(crate) fn file(&self, scene: &str, kind: &str) -> String {
        let words = self.parameters.iter().filter_map(|(_, value)| Some(format!("-{}", value.as_str()?)));
        let hinted = if self.is_hinted { "-user-paths" } else { "" };
        format!("{scene}-{kind}{}{}{hinted}.png", self.method, words.collect::<String>())
    }
}

/// A scene of `scenes`, and the hints beside it.
pub(crate) struct Subject {
    pub(crate) name: &'static str,
    pub(crate) scene: Arc<Scene>,
    pub(crate) hints: Option<Value>,
}

impl Subject {
    /// At `size` pixels a side.
    pub(crate) fn load(name: &'static str, size: u32) -> Result<Self, Box<dyn Error>> {
        let folder = Path::new("scenes").join(name);
        let description = load_file(&folder.join("scene.xml"), &[("size".to_owned(), size.to_string())])?;
        let file = folder.join("user-paths.json");
        let hints = file.exists().then(|| std::fs::read_to_string(file)).transpose()?;
        let hints = hints.map(|text| serde_json::from_str(&text)).transpose()?;
        Ok(Self { name, scene: Arc::new(Scene::prepare(&description)?), hints })
    }

    /// A run of at least one pass that lasted for so many processor-seconds, its pilot included; and how many it took.
    pub(crate) fn traced(&self, contender: &Contender, seed: u64, seconds: f64) -> Result<(Run, f64), Box<dyn Error>> {
        let own = contender.parameters.iter().map(|(name, value)| ((*name).to_owned(), value.clone()));
        let hints = self.hints.iter().filter(|_| contender.is_hinted);
        let hints = hints.map(|hints| ("user_paths".to_owned(), hints.clone()));
        let parameters: Map<String, Value> = own.chain(hints).collect();
        let choice = MethodChoice { name: contender.method.to_owned(), parameters };
        let checked = method::check(&choice, self.scene.pixel_count() as u64)?;
        let mut stopwatch = ProcessStopwatch::start()?;
        let mut run = Run::start(&self.scene, &checked, seed)?;
        loop {
            run.pass()?;
            let spent = stopwatch.spent()?.processor;
            if spent >= seconds {
                return Ok((run, spent));
            }
        }
    }
}

/// The share of each kind of change that was taken.
pub(crate) fn acceptance(run: &Run) -> String {
    let share = |step: &Step| {
        let [proposed, accepted] = ["proposed", "accepted"].map(|what| run.count(&format!("{}_{what}", step.name())));
        (proposed > 0.0).then(|| format!("{} {:.0} %", step.name().replace('_', " "), 100.0 * accepted / proposed))
    };
    let shares: Vec<String> = Step::ALL.iter().filter_map(share).collect();
    shares.join(", ")
}

/// Writes a picture to where the document shows it.
pub(crate) fn save(file: &str, picture: &Picture) -> Result<(), Box<dyn Error>> {
    Ok(std::fs::write(picture_folder()?.join(file), picture_files::encode_png(picture, 0.0)?)?)
}

/// Where the document's pictures are.
pub(crate) fn picture_folder() -> std::io::Result<PathBuf> {
    let folder = PathBuf::from("docs/measured/metropolis");
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}
