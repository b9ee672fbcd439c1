//! `shapegroup` and `instance`: shapes that are read once and placed many times.
//!
//! As in Mitsuba a group is not seen by itself, its shapes have their own materials, none of them lights anything, and groups
//! do not nest.

use std::collections::HashMap;
use std::sync::Arc;

use super::checks::check_reach;
use super::shapes::{MERGE, OF_DERIVATIVES, members};
use super::{Builder, Fields, Geometry, Node, PluginClass, SceneError};
use crate::scene::geometry::Instance;
use crate::scene::names::{Name, given_name};

/// The plugins that are read here, not by the table of shapes.
pub(super) const PLUGINS: [&str; 2] = ["shapegroup", "instance"];

/// The groups of a scene and what stands where.
#[derive(Default)]
pub(super) struct Instancing {
    groups: Vec<Geometry>,
    /// Groups by the address of their node.
    group_of_node: HashMap<*const Node, u32>,
    instances: Vec<Instance>,
    /// What they are called.
    names: Vec<Name>,
}

impl Instancing {
    /// Whether nothing was placed.
    pub(super) fn is_empty(&self) -> bool {
        self.instances.is_empty()
    }

    /// How many instances there are.
    pub(super) fn count(&self) -> usize {
        self.instances.len()
    }

    /// What the instances are called.
    pub(super) fn take_names(&mut self) -> Vec<Name> {
        std::mem::take(&mut self.names)
    }

    /// Adds what was placed to the scene's other surfaces.
    pub(super) fn add_to(self, geometry: Geometry) -> Geometry {
        if self.is_empty() { geometry } else { geometry.with_instances(self.groups, &self.instances) }
    }
}

impl Builder<'_> {
    /// Reads one of [`PLUGINS`].
    pub(super) fn add_instancing(&mut self, node: &Arc<Node>) -> Result<(), SceneError> {
        match node.plugin.as_str() {
            "shapegroup" => self.group(node).map(drop),
            _ => self.instance(node),
        }
    }

    fn group(&mut self, node: &Arc<Node>) -> Result<u32, SceneError> {
        let address = Arc::as_ptr(node);
        if let Some(index) = self.instancing.group_of_node.get(&address) {
            return Ok(*index);
        }
        let mut fields = Fields::new(node);
        fields.ignore(&[OF_DERIVATIVES]);
        let mut shapes = Vec::new();
        let mut waiting = fields.children(PluginClass::Shape);
        waiting.reverse();
        while let Some(child) = waiting.pop() {
            if child.plugin == MERGE {
                waiting.extend(members(child)?.into_iter().rev());
                continue;
            }
            check_member(child)?;
            let (shape, geometry, emission) = self.read_shape(child)?;
            if emission.is_some() {
                return Err(emitting(child));
            }
            shapes.push((shape, geometry));
        }
        fields.finish()?;
        if shapes.is_empty() {
            return Err(SceneError::new(&node.location, "the shapegroup holds no shapes", "put shapes into it"));
        }
        let index = self.instancing.groups.len() as u32;
        self.instancing.groups.push(Geometry::build(shapes).0);
        self.instancing.group_of_node.insert(address, index);
        Ok(index)
    }

    fn instance(&mut self, node: &Arc<Node>) -> Result<(), SceneError> {
        const REMEDY: &str = "nest <ref id=\"…\"/> of a shapegroup";
        let mut fields = Fields::new(node);
        let Some(shape) = fields.child(PluginClass::Shape) else {
            return Err(SceneError::new(&node.location, "the instance refers to no shapegroup", REMEDY));
        };
        if shape.plugin != "shapegroup" {
            let problem = format!("the instance refers to a \"{}\", not to a shapegroup", shape.plugin);
            return Err(SceneError::new(&node.location, problem, REMEDY));
        }
        let group = self.group(shape)?;
        let instance = Instance::read(&mut fields, group)?;
        fields.ignore(&[OF_DERIVATIVES]);
        let bounds = instance.bounds(self.instancing.groups[group as usize].bounds());
        check_reach(node, std::iter::once(bounds))?;
        // Instances without a name of their own share the group's, so that a forest is selected at once.
        let name = self.object_name(if given_name(node).is_empty() { given_name(shape) } else { given_name(node) });
        self.instancing.names.push(name);
        self.instancing.instances.push(instance);
        fields.finish()
    }
}

/// Whether a shape may stand in a group.
fn check_member(shape: &Node) -> Result<(), SceneError> {
    if PLUGINS.contains(&shape.plugin.as_str()) {
        let problem = format!("a shapegroup cannot hold a shape of type \"{}\"", shape.plugin);
        return Err(SceneError::new(&shape.location, problem, "groups do not nest: put the shapes themselves into it"));
    }
    Ok(())
}

/// The error about a shape of a group that emits.
fn emitting(shape: &Node) -> SceneError {
    let emitter = shape.children.iter().find(|child| child.node.class == PluginClass::Emitter);
    let place = emitter.map_or(&shape.location, |emitter| &emitter.node.location);
    SceneError::new(place, "shapes of a shapegroup cannot emit", "put the emitting shape beside the group")
}
