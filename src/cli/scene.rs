//! `scene check`: whether a scene can be rendered, and what it contains.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};
use serde_json::json;

use super::exit_code::CliError;
use super::import::notice_json;
use super::scene_input::scene_help;
use super::scene_options::SceneOptions;
use super::terminal;
use crate::farm::coordinator::request::{ResolvedMethod, resolve_method};
use crate::farm::job::JobRequest;
use crate::method::SceneTraits;
use crate::scene::description::{Node, PluginClass, SceneDescription};
use crate::scene::light::groups::OTHERS;
use crate::scene::prepare::Scene as PreparedScene;

/// Look into a scene without rendering it.
#[derive(Clone, Debug, Args)]
pub(super) struct Scene {
    #[command(subcommand)]
    command: SceneCommand,
}

#[derive(Clone, Debug, Subcommand)]
enum SceneCommand {
    /// Check that a scene can be rendered; print what it contains and what was approximated or ignored.
    Check(Check),
}

/// Check that a scene can be rendered; print what it contains and what was approximated or ignored.
#[derive(Clone, Debug, Args)]
struct Check {
    #[arg(help = scene_help())]
    scene: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: SceneOptions,
}

impl Scene {
    pub(super) fn run(self) -> Result<(), CliError> {
        let SceneCommand::Check(check) = self.command;
        check.run()
    }
}

impl Check {
    fn run(self) -> Result<(), CliError> {
        let start = Instant::now();
        let description = self.options.load(&self.scene)?;
        let read = start.elapsed();
        let scene = PreparedScene::prepare(&description)?;
        let built = start.elapsed() - read;
        let pixels = u64::from(scene.width) * u64::from(scene.height);
        let method = resolve_method(&default_request(), scene.integrator.as_ref(), pixels, SceneTraits::of(&scene))
            .map_err(|error| CliError::BadInput(error.to_string()))?;
        let found = Found { contents: contents(&description), description, scene, method, read, built };
        let text = if self.json { found.json() } else { found.table() };
        terminal::result(&text?)
    }
}

/// What `render` asks for when it is told nothing but the scene.
fn default_request() -> JobRequest {
    JobRequest::of_scene("")
}

/// What is counted, in the order in which it is told.
const CLASSES: [&str; 5] = ["shapes", "materials", "lights", "textures", "media"];

/// How many plugins of each kind there are, by class. Shared ones count once.
type Contents = BTreeMap<&'static str, BTreeMap<String, usize>>;

fn contents(description: &SceneDescription) -> Contents {
    fn count(node: &Node, seen: &mut HashSet<*const Node>, contents: &mut Contents) {
        for child in &node.children {
            if !seen.insert(Arc::as_ptr(&child.node)) {
                continue;
            }
            let class = match child.node.class {
                PluginClass::Shape => "shapes",
                PluginClass::Bsdf => "materials",
                PluginClass::Emitter => "lights",
                PluginClass::Texture => "textures",
                PluginClass::Medium => "media",
                _ => "other",
            };
            *contents.entry(class).or_default().entry(child.node.plugin.clone()).or_insert(0) += 1;
            count(&child.node, seen, contents);
        }
    }
    let mut contents = CLASSES.map(|class| (class, BTreeMap::new())).into();
    count(&description.root, &mut HashSet::new(), &mut contents);
    contents.remove("other");
    contents
}

/// Everything that the check tells.
struct Found {
    description: SceneDescription,
    scene: PreparedScene,
    method: ResolvedMethod,
    contents: Contents,
    read: Duration,
    built: Duration,
}

impl Found {
    /// Notices of preparing, of which those of the import are a part, and of choosing the method.
    fn notices(&self) -> impl Iterator<Item = &String> {
        self.scene.notices.iter().chain(&self.method.notices)
    }

    fn table(&self) -> Result<String, CliError> {
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{name:<11}{value}");
        };
        let scene = &self.scene;
        line("method", self.method.method.choice.name.clone());
        line("picture", format!("{} × {} pixels", scene.width, scene.height));
        for class in CLASSES {
            line(class, kinds(&self.contents[class]));
        }
        let groups = scene.lights.groups().names();
        if groups != [OTHERS] {
            line("groups", groups.join(", "));
        }
        line("primitives", scene.geometry.primitive_count().to_string());
        line("read", format!("{:.3} s", self.read.as_secs_f64()));
        line("built", format!("{:.3} s", self.built.as_secs_f64()));
        if let Some(bytes) = peak_memory() {
            line("memory", format!("{:.1} MiB at most", bytes as f64 / f64::from(1 << 20)));
        }
        for notice in self.notices() {
            line("note", notice.clone());
        }
        Ok(text.trim_end().to_owned())
    }

    fn json(&self) -> Result<String, CliError> {
        let import: Vec<_> = self.description.notices.iter().map(notice_json).collect();
        let document = json!({
            "method": self.method.method.choice,
            "width": self.scene.width,
            "height": self.scene.height,
            "contents": self.contents,
            "light_groups": self.scene.lights.groups().names(),
            "primitives": self.scene.geometry.primitive_count(),
            "read_seconds": self.read.as_secs_f64(),
            "build_seconds": self.built.as_secs_f64(),
            "peak_memory_bytes": peak_memory(),
            "import_report": import,
            "notices": self.notices().collect::<Vec<_>>(),
        });
        serde_json::to_string_pretty(&document).map_err(CliError::failed)
    }
}

/// `7: 2 cube, 5 rectangle`.
fn kinds(counts: &BTreeMap<String, usize>) -> String {
    let total: usize = counts.values().sum();
    let each: Vec<String> = counts.iter().map(|(plugin, count)| format!("{count} {plugin}")).collect();
    if each.is_empty() { total.to_string() } else { format!("{total}: {}", each.join(", ")) }
}

/// The most memory that this process has had so far, bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
