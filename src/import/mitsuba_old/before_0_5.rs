//! What versions before 0.5 called plugins and parameters, and what they meant by them.

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::Version;
use crate::scene::description::PluginClass::{self, Bsdf, Emitter, Film, Integrator, Sampler, Sensor, Shape, Texture};
use crate::scene::description::Value;

/// The first version with the new name, class, old and new name of a plugin.
const PLUGINS: [(Version, PluginClass, &str, &str); 12] = [
    (Version(0, 5), Bsdf, "bump", "bumpmap"),
    (Version(0, 4), Integrator, "errctrl", "adaptive"),
    (Version(0, 4), Film, "exrfilm", "hdrfilm"),
    (Version(0, 4), Film, "pngfilm", "ldrfilm"),
    (Version(0, 3), Bsdf, "lambertian", "diffuse"),
    (Version(0, 3), Bsdf, "microfacet", "roughplastic"),
    (Version(0, 3), Bsdf, "roughmetal", "roughconductor"),
    (Version(0, 3), Bsdf, "roughglass", "roughdielectric"),
    (Version(0, 3), Bsdf, "composite", "mixturebsdf"),
    (Version(0, 3), Texture, "exrtexture", "bitmap"),
    (Version(0, 3), Texture, "ldrtexture", "bitmap"),
    (Version(0, 3), Bsdf, "mirror", "conductor"),
];

/// The first version with the new name, class, plugin (by its new name; any when empty), old and new name of a parameter.
const PARAMETERS: [(Version, PluginClass, &str, &str, &str); 19] = [
    (Version(0, 4), Emitter, "area", "intensity", "radiance"),
    (Version(0, 4), Emitter, "constant", "intensity", "radiance"),
    (Version(0, 4), Emitter, "directional", "intensity", "irradiance"),
    (Version(0, 4), Emitter, "", "intensityScale", "scale"),
    (Version(0, 4), Integrator, "", "luminaireSamples", "emitterSamples"),
    (Version(0, 4), Sampler, "", "depth", "dimension"),
    (Version(0, 4), Sensor, "", "focusDepth", "focusDistance"),
    (Version(0, 3), Shape, "sphere", "inverted", "flipNormals"),
    (Version(0, 3), Shape, "cylinder", "p1", "p0"),
    (Version(0, 3), Shape, "cylinder", "p2", "p1"),
    (Version(0, 3), Texture, "", "brightColor", "color0"),
    (Version(0, 3), Texture, "", "darkColor", "color1"),
    (Version(0, 3), Bsdf, "ward", "alphaX", "alphaU"),
    (Version(0, 3), Bsdf, "ward", "alphaY", "alphaV"),
    (Version(0, 3), Bsdf, "roughplastic", "alphaB", "alpha"),
    (Version(0, 3), Bsdf, "roughconductor", "alphaB", "alpha"),
    (Version(0, 3), Bsdf, "roughdielectric", "alphaB", "alpha"),
    (Version(0, 3), Bsdf, "roughconductor", "ior", "eta"),
    // Whether the file has an alpha channel, which changes no picture here.
    (Version(0, 4), Film, "", "alpha", "attachLog"),
];

/// Gives a plugin of a file of `version` the names and meanings of 0.5.
pub(super) fn rename(draft: &mut Draft, version: Version) {
    let mirror = draft.class == Bsdf && draft.plugin == "mirror";
    let plugin =
        PLUGINS.iter().find(|(until, class, old, _)| version < *until && *class == draft.class && *old == draft.plugin);
    if let Some((_, _, _, new)) = plugin {
        draft.plugin = (*new).to_owned();
    }
    let new_name = |draft: &Draft, name: &str| {
        let row = PARAMETERS.iter().find(|(until, class, plugin, old, _)| {
            version < *until && *class == draft.class && (plugin.is_empty() || *plugin == draft.plugin) && *old == name
        });
        row.map(|(_, _, _, _, new)| (*new).to_owned())
    };
    for index in 0..draft.parameters.len() {
        if let Some(new) = new_name(draft, &draft.parameters[index].name) {
            draft.parameters[index].name = new;
        }
    }
    for index in 0..draft.children.len() {
        if let Some(new) = new_name(draft, &draft.children[index].name) {
            draft.children[index].name = new;
        }
    }
    match (draft.class, draft.plugin.as_str()) {
        (Bsdf, _) if mirror && version < Version(0, 3) => draft.set_default("material", Value::String("Cr".into())),
        (Shape, "obj") if version < Version(0, 3) => draft.set_default("flipTexCoords", Value::Boolean(false)),
        (Sensor, _) if version < Version(0, 4) => camera(draft),
        _ => {}
    }
}

/// Cameras looked along a left-handed frame, and took the angle of view along the smaller side.
fn camera(draft: &mut Draft) {
    for parameter in draft.parameters.iter_mut().filter(|parameter| parameter.name == "toWorld") {
        if let Value::Transform(matrix) = &mut parameter.value {
            *matrix *= DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        }
    }
    let smaller = draft.take("mapSmallerSide") != Some(Value::Boolean(false));
    if draft.plugin == "perspective" {
        draft.set_default("fovAxis", Value::String(if smaller { "smaller" } else { "larger" }.into()));
    }
}
