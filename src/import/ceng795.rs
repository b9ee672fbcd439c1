//! Scenes of the course CENG 795, Advanced Ray Tracing, of METU: XML whose outermost tag is `<Scene>`.
//!
//! Everything has a list of its own (`<Cameras>`, `<Lights>`, `<BRDFs>`, `<Materials>`, `<Transformations>`,
//! `<VertexData>`, `<Objects>`) and refers to the others by number. What becomes of it stands in `docs/SCENES.md`;
//! whatever a scene loses is in its notices.

mod camera;
mod element;
mod lights;
mod material;
mod mesh;
mod objects;
mod reflection;
mod transformation;

use super::draft::{Draft, Reading};
use super::notices::Notices;
use super::substitution::refuse_defines;
use super::xml_element::File;
use crate::scene::bundle::Generated;
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError};
use camera::Camera;
use element::Element;
use material::Materials;
use objects::Objects;

/// Children of the scene. The last ones only keep an author's renderer from numerical trouble.
const TAGS: [&str; 13] = [
    "MaxRecursionDepth",
    "BackgroundColor",
    "Cameras",
    "Lights",
    "BRDFs",
    "Materials",
    "Transformations",
    "VertexData",
    "ZeroBasedIndexing",
    "Objects",
    "ShadowRayEpsilon",
    "IntersectionTestEpsilon",
    "BackfaceCulling",
];

/// Whether XML is such a scene: its outermost tag is `<Scene>` and has no version.
pub(super) fn is_ceng795(text: &[u8]) -> bool {
    let mut rest = text.trim_ascii_start();
    // What may stand before the outermost tag.
    while rest.starts_with(b"<?") || rest.starts_with(b"<!--") {
        let end: &[u8] = if rest.starts_with(b"<?") { b"?>" } else { b"-->" };
        let Some(at) = rest.windows(end.len()).position(|bytes| bytes == end) else { return false };
        rest = rest[at + end.len()..].trim_ascii_start();
    }
    let tag = rest.split(|byte| *byte == b'>').next().unwrap_or_default();
    let Some(attributes) = tag.strip_prefix(b"<Scene") else { return false };
    let ends = attributes.first().is_none_or(|byte| byte.is_ascii_whitespace() || *byte == b'/');
    ends && !attributes.windows(b"version".len()).any(|bytes| bytes == b"version")
}

/// Reads a scene file. Gives the scene and the meshes that were made for it. The format has no `$names`, so every define is
/// an error.
///
/// # Errors
/// On malformed XML, numbers and references, with their lines; on what a scene cannot do without.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    defines: &[(String, String)],
    camera: Option<&str>,
) -> Result<(Reading, Generated), SceneError> {
    refuse_defines(defines, location, "a scene of this format has no parameters")?;
    let text = File::text(bytes, location)?;
    let document = File::parse(text, location)?;
    let file = File::new(&location.file, text);
    let scene = Element::new(&file, document.root_element());
    let mut notices = Notices::default();
    scene.report_unknown(&TAGS, &[], &mut notices);
    let materials = Materials::read(&scene, &mut notices)?;
    let camera = Camera::find(&scene, camera, &mut notices)?;
    let depth = scene.child("MaxRecursionDepth")?.map_or(Ok(0), |element| element.integer())?;
    let mut root =
        Draft::new(PluginClass::Scene, "scene", &scene.location()).with_child("", camera.sensor(&mut notices)?);
    if let Some(integrator) = camera.integrator(depth, materials.any_specular, &mut notices)? {
        root = root.with_child("", integrator);
    }
    let lights = lights::read(&scene, materials.light_scale, &mut notices)?;
    let mut objects = Objects::new(&scene, &materials, &mut notices)?;
    objects.read(&scene)?;
    let Objects { shapes, made, .. } = objects;
    let root =
        materials.bsdfs.into_iter().chain(shapes).chain(lights).fold(root, |root, draft| root.with_child("", draft));
    let reading =
        Reading { root, aliases: Vec::new(), includes: Vec::new(), notices: notices.into_list(), moves: None };
    Ok((reading, made))
}
