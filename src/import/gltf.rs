//! glTF 2.0: `.gltf` with its buffers and images, and `.glb`.
//!
//! Meshes become PLY files in memory, materials `principled`, nodes shapes with their transform to the world. What is
//! supported, approximated and refused stands in `docs/SCENES.md`; whatever a scene loses is in its notices.

mod accessor;
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
mod texture;
mod uri;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::draft::{Draft, Reading};
use super::notices::Notices;
use super::substitution::refuse_defines;
use crate::scene::bundle::{Bundle, Files};
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;
use buffers::{Budget, Buffers};
use entry::Document;
use material::Materials;

pub(super) use container::MAGIC;

/// Where the files stand that the import makes.
const GENERATED_FOLDER: &str = "generated/";

/// What is read.
struct Input<'a> {
    document: &'a Document,
    buffers: &'a Buffers,
    /// The files beside it.
    bundle: &'a Bundle,
}

/// What is made besides plugins.
struct Output {
    generated: Files,
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
    serde_json::from_slice::<Head>(text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)).is_ok()
}

/// Reads a `.gltf` or `.glb` file, and the files that it refers to from `bundle`. Gives the scene and the files that
/// were made for it. glTF has no `$names`, so every define is an error.
///
/// # Errors
/// On malformed, truncated and oversized content, with its path in the JSON; on required extensions that are not
/// supported.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
) -> Result<(Reading, Files), SceneError> {
    refuse_defines(defines, location, "a glTF scene has no parameters")?;
    let (text, binary) = container::split(bytes, location)?;
    let document = Document::parse(text, location)?;
    check_version(&document)?;
    extensions::check_required(&document.root())?;
    let mut output = Output { generated: Files::new(), budget: Budget::new(), notices: Notices::default() };
    let mut includes = Vec::new();
    let buffers = Buffers::load(&document, bundle, binary, &mut output.budget, &mut includes)?;
    let root = scene(&Input { document: &document, buffers: &buffers, bundle }, &mut output)?;
    let Output { generated, notices, .. } = output;
    Ok((Reading { root, aliases: Vec::new(), includes, notices: notices.into_list() }, generated))
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

fn scene(input: &Input<'_>, output: &mut Output) -> Result<Draft, SceneError> {
    let file = input.document.root();
    extensions::report_unread(&file, output)?;
    if input.document.count("animations") > 0 {
        let explanation = "every node stands where it rests";
        output.notices.add(Notice::ignored(&file.location(), "the animations", explanation));
    }
    let mut materials = Materials::default();
    let contents = nodes::read(input, &mut materials, output)?;
    let location = file.location();
    let files = input.bundle.clone().with_generated(output.generated.clone());
    let surroundings = contents.is_dark(&files).then(|| white_surroundings(&location, output));
    let sensor = match contents.sensor {
        Some(sensor) => sensor,
        None => camera::framing(contents.bounds, &location, output),
    };
    let scene = Draft::new(PluginClass::Scene, "scene", &location).with_child("", sensor);
    let plugins = materials.plugins.into_iter().chain(contents.shapes).chain(contents.emitters).chain(surroundings);
    Ok(plugins.fold(scene, |scene, plugin| scene.with_child("", plugin)))
}

/// What lights a scene in which nothing emits, as in programs that show models.
fn white_surroundings(location: &Location, output: &mut Output) -> Draft {
    let explanation = "a white environment of radiance 1 lights the scene, in which nothing emits";
    output.notices.add(Notice::approximated(location, "the missing light", explanation));
    Draft::new(PluginClass::Emitter, "constant", location).with_rgb("radiance", [1.0; 3])
}
