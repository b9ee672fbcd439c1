//! A camera on its way from one of the scene's cameras to another.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::changes::choose;
use super::motion::between;
use crate::scene::description::{Child, Node, PluginClass, Value};
use crate::scene::error::SceneError;

/// A place between two cameras. Everything but the place and the numbers that both have is that of the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BetweenCameras {
    /// The name or the index of a camera, counted from 0.
    pub from: String,
    /// The same of another one.
    pub to: String,
    /// How far from the one to the other, 0 to 1.
    pub share: f64,
}

/// Leaves one camera in a scene, between two of those that it has.
///
/// # Errors
/// When there are no such cameras, or they are of different kinds.
pub(super) fn stand_between(root: &mut Node, way: &BetweenCameras) -> Result<(), SceneError> {
    let is_sensor = |child: &Child| child.node.class == PluginClass::Sensor;
    let sensors: Vec<Arc<Node>> =
        root.children.iter().filter(|child| is_sensor(child)).map(|child| child.node.clone()).collect();
    let names: Vec<&str> = sensors.iter().map(|sensor| sensor.id.as_str()).collect();
    let index = |name: &str| choose(&names, Some(name), &root.location);
    let (first, from, to) = (index(&way.from)?, &sensors[index(&way.from)?], &sensors[index(&way.to)?]);
    if !(0.0..=1.0).contains(&way.share) {
        let problem = format!("{} is no share of a way", way.share);
        return Err(SceneError::new(&root.location, problem, "give 0 to 1"));
    }
    if from.plugin != to.plugin {
        let problem = format!("there is no way from a {} camera to a {} camera", from.plugin, to.plugin);
        return Err(SceneError::new(&to.location, problem, "choose cameras of one kind"));
    }
    let mut camera = Node::clone(from);
    for parameter in &mut camera.parameters {
        let other = to.parameters.iter().find(|other| other.name == parameter.name);
        match (&mut parameter.value, other.map(|other| &other.value)) {
            (Value::Transform(place), Some(Value::Transform(end))) => *place = between(*place, *end, way.share),
            (Value::Float(number), Some(Value::Float(end))) => *number += (*end - *number) * way.share,
            _ => {}
        }
    }
    let at = root.children.iter().enumerate().filter(|(_, child)| is_sensor(child)).map(|(at, _)| at).nth(first);
    if let Some(at) = at {
        root.children[at].node = Arc::new(camera);
        let mut position = 0;
        root.children.retain(|child| {
            position += 1;
            !is_sensor(child) || position - 1 == at
        });
    }
    Ok(())
}
