//! Plugins that a scene may name and that are not rendered: which of Mitsuba's, and what to take instead.

use super::description::Node;
use super::error::{SceneError, nearest_name};

/// Tag, plugins and remedy.
const UNSUPPORTED: &[(&str, &[&str], &str)] = &[
    ("shape", &["sdfgrid", "ellipsoids", "ellipsoidsmesh"], "export it as a triangle mesh, for example as PLY"),
    ("bsdf", &["hair"], "use a roughconductor or principled with anisotropic roughness"),
    ("bsdf", &["measured"], "use a roughconductor, roughplastic or principled of a like roughness"),
    (
        "bsdf",
        &["measured_polarized", "pplastic", "polarizer", "retarder", "circular"],
        "polarization is not rendered: use a bsdf without it",
    ),
    ("texture", &["volume"], "use a bitmap"),
    ("sensor", &["irradiancemeter"], "use an orthographic or perspective sensor of a few pixels"),
];

/// The error about a plugin that is none of the `known` ones of its class.
pub(super) fn unknown_plugin(node: &Node, known: &[&str]) -> SceneError {
    let (tag, plugin) = (node.class.tag(), node.plugin.as_str());
    match UNSUPPORTED.iter().find(|(class, plugins, _)| *class == tag && plugins.contains(&plugin)) {
        Some((.., remedy)) => SceneError::new(&node.location, format!("{tag} \"{plugin}\" is not supported"), *remedy),
        None => SceneError::new(&node.location, format!("there is no {tag} \"{plugin}\""), nearest_name(plugin, known)),
    }
}
