//! `batch`: several sensors that share one film, side by side. Each becomes a sensor of the scene, for one of them to be chosen.

use std::sync::Arc;

use super::changes::{DEFAULT_SIZE, film, integer, set};
use crate::scene::description::{Child, Node, PluginClass};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::notice::Notice;

/// Puts the sensors of each batch into its place. Each has the batch's film, as wide as its part of it.
///
/// # Errors
/// On a batch without sensors, with parameters, or with a film that cannot be divided.
pub(super) fn unfold(root: &mut Node, notices: &mut Vec<Notice>) -> Result<(), SceneError> {
    let is_batch = |child: &Child| child.node.class == PluginClass::Sensor && child.node.plugin == "batch";
    if !root.children.iter().any(is_batch) {
        return Ok(());
    }
    let mut children = Vec::new();
    for child in std::mem::take(&mut root.children) {
        match is_batch(&child) {
            true => children.extend(sensors(&child.node, notices)?),
            false => children.push(child),
        }
    }
    root.children = children;
    Ok(())
}

fn sensors(batch: &Node, notices: &mut Vec<Notice>) -> Result<Vec<Child>, SceneError> {
    let mut fields = Fields::new(batch);
    let sensors = fields.children(PluginClass::Sensor);
    let given = fields.child(PluginClass::Film);
    fields.child(PluginClass::Sampler);
    // Each of the sensors has its own place.
    fields.ignore(&["to_world", "shutter_open", "shutter_close"]);
    fields.finish()?;
    if sensors.is_empty() {
        return Err(SceneError::new(&batch.location, "the batch has no sensors", "put sensors into it"));
    }
    let film = part(given.map_or_else(|| film(&batch.location), |film| Node::clone(film)), sensors.len() as i64)?;
    let explanation = "its sensors are cameras of their own, each as wide as its part of the film";
    notices.push(Notice::approximated(&batch.location, "sensor \"batch\"", explanation));
    let with_film = |sensor: &Arc<Node>| {
        let mut sensor = Node::clone(sensor);
        sensor.children.retain(|child| child.node.class != PluginClass::Film);
        sensor.children.push(Child { name: String::new(), node: Arc::new(film.clone()) });
        Child { name: String::new(), node: Arc::new(sensor) }
    };
    Ok(sensors.into_iter().map(with_film).collect())
}

/// The film of one of `count` sensors.
fn part(mut film: Node, count: i64) -> Result<Node, SceneError> {
    if let Some(crop) = film.parameters.iter().find(|parameter| parameter.name.starts_with("crop_")) {
        return Err(SceneError::new(&crop.location, "the film of a batch is cropped", "leave the crop out"));
    }
    let width = integer(&film, "width").unwrap_or(i64::from(DEFAULT_SIZE[0]));
    if width % count != 0 {
        let problem = format!("a film {width} pixels wide cannot be divided among {count} sensors");
        return Err(SceneError::new(&film.location, problem, format!("give a width that {count} divides")));
    }
    set(&mut film, "width", width / count);
    Ok(film)
}
