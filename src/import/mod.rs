//! One file per format, all into the same description.
//!
//! A format's reader makes `draft` nodes: plugins as they stand in the file, with references by id. `resolve` turns the
//! drafts of every format into the description tree. `values` and `transform` hold what the formats' values mean,
//! `plugins` the names of all plugins. `pack` makes the bytes that travel over HTTP, [`native`] writes a description as JSON,
//! and `report` is what an import could not represent.

mod batch;
pub(crate) mod camera_path;
mod ceng795;
pub mod changes;
pub mod compatibility;
mod default_environment;
mod draft;
pub mod formats;
mod gltf;
mod gzip;
mod json_text;
mod mgf;
mod mitsuba_json;
mod mitsuba_old;
pub mod mitsuba_plugins;
mod mitsuba_xml;
mod motion;
pub mod native;
mod notices;
mod pack;
mod pbrt;
mod plugins;
mod resolve;
mod spectra;
mod substitution;
mod transform;
mod values;
mod xml_element;
mod xml_tags;

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use crate::scene::bundle::{Bundle, read_file};
use crate::scene::description::{Node, SceneDescription, Value};
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;
use changes::Changes;
use draft::Reading;
use formats::{Format, format};
pub use formats::{scene_file, scene_in_archive};

pub use pack::{UNNAMED, pack, pack_read, packed_names};

/// How deep plugins and values may nest, and how long a chain of references may be.
const DEPTH_LIMIT: usize = 64;

/// Reads the scene file (of one of the [`formats`], or a zip archive with one) at `path`.
///
/// `defines` are names and values that take the place of the scene's `<default>` parameters. Files that the scene
/// refers to are looked up in the folder that holds it.
///
/// # Errors
/// Whatever is wrong with the scene's syntax, structure, references and included files; a define that nothing uses.
pub fn load_file(path: &Path, defines: &[(String, String)]) -> Result<SceneDescription, SceneError> {
    read_source(path)?.import(defines).map(|imported| imported.description)
}

/// [`load_file`] with `changes`, which count before those that an archive brings along.
///
/// # Errors
/// As [`load_file`]; when the scene has no such camera, or the picture no such part.
pub fn load_changed(
    path: &Path,
    defines: &[(String, String)],
    changes: &Changes,
) -> Result<SceneDescription, SceneError> {
    let mut source = read_source(path)?;
    source.changes = changes.clone().over(source.changes);
    source.import(defines).map(|imported| imported.description)
}

/// Reads a scene from memory: of one of the [`formats`] that stands alone, or a zip archive.
///
/// An archive's scene file is the one that its comment names, the one at its top level with a format's standard name, or else the
/// only file there with one of the formats' extensions. `name` is what errors call the file. See [`load_file`] for `defines`.
///
/// # Errors
/// As [`load_file`]; also when the archive is malformed or its scene file is missing or ambiguous.
pub fn load_bytes(name: &str, bytes: &[u8], defines: &[(String, String)]) -> Result<SceneDescription, SceneError> {
    Source::from_bytes(name, bytes.into())?.import(defines).map(|imported| imported.description)
}

/// [`load_bytes`] with `changes`, which count before those that an archive brings along.
///
/// # Errors
/// As [`load_changed`].
pub fn load_changed_bytes(name: &str, bytes: &[u8], changes: &Changes) -> Result<SceneDescription, SceneError> {
    let mut source = Source::from_bytes(name, bytes.into())?;
    source.changes = changes.clone().over(source.changes);
    source.import(&[]).map(|imported| imported.description)
}

/// A scene file that was found and read, but not yet looked into.
struct Source {
    name: String,
    text: Arc<[u8]>,
    bundle: Bundle,
    changes: Changes,
}

/// What importing a scene gives: the description, and the names of the files that were included on the way.
struct Imported {
    description: SceneDescription,
    files: Vec<(String, Location)>,
}

impl Source {
    fn from_bytes(name: &str, bytes: Arc<[u8]>) -> Result<Self, SceneError> {
        let location = Location { file: name.to_owned(), ..Location::default() };
        if format(&bytes, &location)? != Format::Zip {
            let (name, bundle, changes) = (name.to_owned(), Bundle::empty(), Changes::default());
            return Ok(Self { name, text: bytes, bundle, changes });
        }
        let Archive { bundle, scene } = Archive::open(&bytes, &location)?;
        let text = bundle.read(&scene, &location)?;
        let changes = changes::read(&bundle)?;
        let (folder, name) = scene.rsplit_once('/').unwrap_or(("", &scene));
        Ok(Self { name: name.to_owned(), text, bundle: bundle.seen_from(folder), changes })
    }

    /// A scene file of `folder`, or an archive, which has all its files inside.
    fn read_in(folder: &Path, name: &str, bytes: Arc<[u8]>) -> Result<Self, SceneError> {
        let location = Location { file: name.to_owned(), ..Location::default() };
        if format(&bytes, &location)? == Format::Zip {
            return Self::from_bytes(name, bytes);
        }
        let bundle = Bundle::Folder(folder.to_owned());
        Ok(Self { name: name.to_owned(), text: bytes, bundle, changes: Changes::default() })
    }

    fn import(&self, defines: &[(String, String)]) -> Result<Imported, SceneError> {
        let location = Location { file: self.name.clone(), ..Location::default() };
        substitution::refuse_repeated(defines, &location)?;
        let mut bundle = self.bundle.clone();
        let Changes { camera, environment, time, .. } = &self.changes;
        let camera = camera.as_deref();
        let found = format(&self.text, &location)?;
        let reading = match found {
            Format::Xml => mitsuba_xml::read(&self.text, &location, &self.bundle, defines, *time)?,
            Format::Ceng795 => {
                let (reading, generated) = ceng795::read(&self.text, &location, defines, camera)?;
                bundle = bundle.with_generated(generated);
                reading
            }
            Format::Json => Reading::complete(mitsuba_json::read(&self.text, &location, defines)?),
            Format::Gltf | Format::Glb => {
                let wishes = gltf::Wishes { camera, moment: *time, default_environment: environment.is_none() };
                let (reading, generated) = gltf::read(&self.text, &location, &self.bundle, defines, &wishes)?;
                bundle = bundle.with_generated(generated);
                reading
            }
            Format::Mgf => {
                let (reading, generated) = mgf::read(&self.text, &location, &self.bundle, defines)?;
                bundle = bundle.with_generated(generated);
                reading
            }
            Format::Pbrt => {
                let (reading, generated) = pbrt::read(&self.text, &location, &self.bundle, defines, *time)?;
                bundle = bundle.with_generated(generated);
                reading
            }
            Format::Zip => {
                return Err(SceneError::new(&location, "an archive inside an archive", "pack the scene file"));
            }
        };
        let Reading { mut root, aliases, includes: mut files, mut notices, moves } = reading;
        if !matches!(found, Format::Xml | Format::Json) {
            root.state_plain_defaults();
        }
        let mut root = resolve::resolve(&root, &aliases)?;
        batch::unfold(&mut root, &mut notices)?;
        // The others choose while they read.
        if !matches!(found, Format::Gltf | Format::Glb | Format::Ceng795) {
            changes::choose_sensor(&mut root, &self.changes, &mut notices)?;
        } else if let Some(way) = &self.changes.between_cameras {
            let problem = format!("there is no way from camera {:?} to another in scenes of this format", way.from);
            return Err(SceneError::new(&location, problem, "leave it out; scenes of Mitsuba have such ways"));
        }
        if let (Some(time), None) = (time, moves) {
            let subject = format!("the moment {time}");
            notices.push(Notice::ignored(&location, subject, "nothing in the scene moves"));
        }
        self.changes.apply(&mut root, &mut notices)?;
        collect_file_names(&root, &mut HashSet::new(), &mut files);
        files.retain(|(name, _)| bundle.generated().is_none_or(|generated| !generated.contains(name)));
        Ok(Imported { description: SceneDescription { root, bundle, notices, moves }, files })
    }
}

/// [`load_changed`] of a scene that was read already; files that it refers to are looked up in `folder`.
///
/// # Errors
/// As [`load_changed`].
pub fn load_read(
    scene: ReadScene<'_>,
    defines: &[(String, String)],
    changes: &Changes,
) -> Result<SceneDescription, SceneError> {
    let mut source = Source::read_in(scene.folder, scene.name, scene.bytes.into())?;
    source.changes = changes.clone().over(source.changes);
    source.import(defines).map(|imported| imported.description)
}

/// A scene that was read already, for example from standard input.
#[derive(Clone, Copy, Debug)]
pub struct ReadScene<'a> {
    /// What errors call it.
    pub name: &'a str,
    /// Its text, or a zip archive.
    pub bytes: &'a [u8],
    /// Where files are looked up that it refers to.
    pub folder: &'a Path,
}

fn read_source(path: &Path) -> Result<Source, SceneError> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let location = Location { file: path.display().to_string(), ..Location::default() };
    if !path.is_file() {
        let problem = if path.exists() { "this is not a file" } else { "there is no such file" };
        return Err(SceneError::new(&location, problem, "give the name of a scene file"));
    }
    let bytes = read_file(path)
        .map_err(|error| SceneError::new(&location, format!("the file cannot be read: {error}"), ""))?
        .ok_or_else(|| SceneError::new(&location, "the file is larger than 1 GiB", "split it"))?;
    format(&bytes, &location)?;
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    Source::read_in(folder, &name, bytes)
}

/// An archive that was unpacked, with the name of its scene file.
struct Archive {
    bundle: Bundle,
    scene: String,
}

impl Archive {
    fn open(bytes: &[u8], location: &Location) -> Result<Self, SceneError> {
        let bundle = Bundle::from_zip(bytes, location)?;
        let scene = scene_in_archive(bytes, bundle.names().iter().map(String::as_str)).map_err(|problem| {
            SceneError::new(location, problem, "put one scene file, such as scene.xml, at the top level")
        })?;
        Ok(Self { bundle, scene })
    }
}

/// Every string parameter called `filename` below `node`, with its place; shared plugins once.
fn collect_file_names(node: &Node, seen: &mut HashSet<*const Node>, files: &mut Vec<(String, Location)>) {
    for parameter in &node.parameters {
        if let (Value::String(name), "filename") = (&parameter.value, parameter.name.as_str()) {
            files.push((name.clone(), parameter.location.clone()));
        }
    }
    for child in &node.children {
        if seen.insert(Arc::as_ptr(&child.node)) {
            collect_file_names(&child.node, seen, files);
        }
    }
}
