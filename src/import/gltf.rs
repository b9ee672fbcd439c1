//! glTF 2.0: `.gltf` with its buffers and images, and `.glb`.
//!
//! Meshes become meshes in memory, materials `principled`, nodes shapes with their transform to the world. What is
//! supported, approximated and refused stands in `docs/SCENES.md`; whatever a scene loses is in its notices.

mod accessor;
mod animation;
mod buffers;
mod camera;
mod container;
mod entry;
mod extensions;
mod lights;
mod material;
mod mesh;
mod nodes;
mod specular_glossiness;
mod tangents;
mod texture;
mod transmission;
mod unlit;
mod uri;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::default_environment;
use super::draft::{Draft, Reading};
use super::notices::Notices;
use super::resolve::resolve;
use super::substitution::refuse_defines;
use crate::scene::Scene;
use crate::scene::bundle::{Bundle, Generated, without_byte_order_mark};
use crate::scene::description::{PluginClass, SceneDescription};
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;
use animation::Poses;
use buffers::{Budget, Buffers};
use entry::Document;
use material::Materials;

pub(super) use container::MAGIC;
pub(super) use extensions::EXTENSIONS;

/// Where the meshes and files stand that the import makes.
const GENERATED_FOLDER: &str = "generated/";

/// What is wanted of a file.
pub(super) struct Wishes<'a> {
    /// The name or index of the camera; else the first.
    pub camera: Option<&'a str>,
    /// The moment that is shown, seconds.
    pub moment: Option<f64>,
    /// Whether a scene that is dark gets a white environment.
    pub default_environment: bool,
}

/// What is read.
struct Input<'a> {
    document: &'a Document,
    buffers: &'a Buffers,
    /// The files beside it.
    bundle: &'a Bundle,
}

/// What is made besides plugins.
struct Output {
    made: Generated,
    budget: Budget,
    notices: Notices,
}

/// Whether a JSON text is glTF: it says so in `asset.version`.
pub(super) fn is_gltf(text: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct Head {
        #[serde(rename = "asset")]
        _asset: Asset,
    }
    #[derive(Deserialize)]
    struct Asset {
        #[serde(rename = "version")]
        _version: IgnoredAny,
    }
    serde_json::from_slice::<Head>(without_byte_order_mark(text)).is_ok()
}

/// Reads a `.gltf` or `.glb` file, and the files that it refers to from `bundle`. Gives the scene and the files that
/// were made for it. glTF has no `$names`, so every define is an error. A scene that is dark gets a white environment if
/// `wishes` say so.
///
/// # Errors
/// On malformed, truncated and oversized content, with its path in the JSON; on required extensions that are not
/// supported.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
    wishes: &Wishes<'_>,
) -> Result<(Reading, Generated), SceneError> {
    refuse_defines(defines, location, "a glTF scene has no parameters")?;
    let (text, binary) = container::split(bytes, location)?;
    let document = Document::parse(text, location)?;
    check_version(&document)?;
    extensions::check_required(&document.root())?;
    let mut output = Output { made: Generated::default(), budget: Budget::new(), notices: Notices::default() };
    let mut includes = Vec::new();
    let buffers = Buffers::load(&document, bundle, binary, &mut output.budget, &mut includes)?;
    let input = Input { document: &document, buffers: &buffers, bundle };
    let poses = Poses::read(&input, wishes.moment, &mut output)?;
    let (mut root, emits) = scene(&input, wishes.camera, &poses, &mut output)?;
    if wishes.default_environment {
        root = lit(root, emits, bundle, &mut output);
    }
    let Output { made, notices, .. } = output;
    Ok((Reading { root, aliases: Vec::new(), includes, notices: notices.into_list(), moves: poses.span }, made))
}

fn check_version(document: &Document) -> Result<(), SceneError> {
    let root = document.root();
    let asset = root.child("asset")?;
    let version = asset.as_ref().map(|asset| asset.text("version")).transpose()?.flatten().unwrap_or_default();
    if version.starts_with("2.") {
        return Ok(());
    }
    let version: String = version.chars().take(20).collect();
    Err(asset.unwrap_or(root).error(format!("the version of glTF is {version:?}"), "export it as glTF 2.0"))
}

/// The scene without a default environment, and whether anything in it emits.
fn scene(
    input: &Input<'_>,
    camera: Option<&str>,
    poses: &Poses,
    output: &mut Output,
) -> Result<(Draft, bool), SceneError> {
    let file = input.document.root();
    extensions::report_unread(&file, output)?;
    let mut materials = Materials::default();
    let contents = nodes::read(input, poses, &mut materials, output)?;
    let location = file.location();
    let files = input.bundle.clone().with_generated(output.made.clone());
    let emits = contents.emits(&files);
    let sensor = match camera::choose(&contents.cameras, camera, &location, output)? {
        Some(sensor) => sensor,
        None => camera::framing(contents.bounds, &location, output),
    };
    let scene = Draft::new(PluginClass::Scene, "scene", &location).with_child("", sensor);
    let plugins = materials.plugins.into_iter().chain(contents.shapes).chain(contents.emitters);
    Ok((plugins.fold(scene, |scene, plugin| scene.with_child("", plugin)), emits))
}

/// A scene with a white environment where its own lights leave it dark, as in programs that show models.
fn lit(root: Draft, emits: bool, bundle: &Bundle, output: &mut Output) -> Draft {
    let explanation = if !emits {
        "a white environment of radiance 1 lights the scene, in which nothing emits"
    } else if leaves_dark(&root, bundle, output) {
        "what emits in the scene leaves most of what is seen dark, so that a white environment of radiance 1 is added; \
         --environment off leaves it out"
    } else {
        return root;
    };
    let location = root.location.clone();
    output.notices.add(Notice::approximated(&location, "the missing light", explanation));
    root.with_child("", default_environment::emitter(&location))
}

/// Whether the lights of a scene leave it dark. A scene that cannot be prepared is left as it is: preparing it tells why.
fn leaves_dark(root: &Draft, bundle: &Bundle, output: &Output) -> bool {
    let Ok(root) = resolve(root, &[]) else { return false };
    let bundle = bundle.clone().with_generated(output.made.clone());
    let description = SceneDescription { root, bundle, notices: Vec::new(), moves: None };
    Scene::prepare(&description).is_ok_and(|scene| default_environment::is_dark(&scene))
}
