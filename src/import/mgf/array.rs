//! Arrays: what the first copy of an array adds is made once and placed as instances, where copies would be many. Small arrays
//! are copied, which is faster to trace. What emits is copied always: instances cannot.

use glam::{DMat4, DVec3};

use super::super::draft::{Draft, Target};
use super::stage::Stage;
use super::text::Entity;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;

/// All copies of an array together may be so many triangles before they are instances.
const MOST_COPIED: usize = 20_000;
/// A sphere, cylinder or disk counts as so many triangles: its description takes as much memory.
const TRIANGLES_OF_A_SHAPE: usize = 20;

/// What a stage held when an array began.
pub(super) struct Mark {
    /// By surface: vertices and triangles of its mesh.
    meshes: Vec<[usize; 2]>,
    shapes: usize,
    bounds: [DVec3; 2],
}

/// Where copies stand.
pub(super) enum Copies {
    /// They are to be made.
    Made,
    /// They are placed, but for those of what emits.
    PlacedButLights,
    /// They are placed.
    Placed,
}

const EMPTY: [DVec3; 2] = [DVec3::INFINITY, DVec3::NEG_INFINITY];

impl Stage {
    /// Remembers what there is before the first copy of an array.
    pub(super) fn mark(&mut self) -> Mark {
        let meshes = self.surfaces.iter().map(|surface| surface.mesh.lengths()).collect();
        let bounds = std::mem::replace(&mut self.bounds, EMPTY);
        Mark { meshes, shapes: self.shapes.len(), bounds }
    }

    /// Ends the first copy of an array that `mark` began. `moves` gives the maps from it to all others, in the world.
    pub(super) fn end_first_copy(
        &mut self,
        mark: Mark,
        copies: u64,
        moves: impl FnOnce() -> Result<Vec<DMat4>, SceneError>,
        entity: &Entity<'_>,
    ) -> Result<Copies, SceneError> {
        let own = std::mem::replace(&mut self.bounds, mark.bounds);
        self.join(own);
        let start = |index: usize| mark.meshes.get(index).copied().unwrap_or([0; 2]);
        let added = |surface: usize| self.surfaces[surface].mesh.lengths()[1] - start(surface)[1];
        let grown: Vec<usize> = (0..self.surfaces.len()).filter(|surface| added(*surface) > 0).collect();
        let triangles: usize = grown.iter().map(|surface| added(*surface)).sum();
        let shapes = &self.shapes[mark.shapes..];
        let size = (triangles + TRIANGLES_OF_A_SHAPE * shapes.len()) as u64;
        let holds_instances = shapes.iter().any(|shape| shape.plugin == "instance");
        if size.saturating_mul(copies - 1) <= MOST_COPIED as u64 && !holds_instances {
            return Ok(Copies::Made);
        }
        let moves = moves()?;
        let emits = grown.iter().any(|surface| self.surfaces[*surface].radiance.is_some()) || shapes.iter().any(emits);
        self.include_copies(own, &moves, entity)?;
        self.group(&mark, &grown, &moves, entity)?;
        Ok(if emits { Copies::PlacedButLights } else { Copies::Placed })
    }

    fn join(&mut self, [least, most]: [DVec3; 2]) {
        self.bounds = [self.bounds[0].min(least), self.bounds[1].max(most)];
    }

    fn include_copies(&mut self, own: [DVec3; 2], moves: &[DMat4], entity: &Entity<'_>) -> Result<(), SceneError> {
        if own[0].x > own[1].x {
            return Ok(());
        }
        let corner = |index: usize| DVec3::from_array(std::array::from_fn(|axis| own[index >> axis & 1][axis]));
        for placed in moves {
            self.include((0..8).map(|index| placed.transform_point3(corner(index))), entity)?;
        }
        Ok(())
    }

    /// Makes a group of what the first copy added and does not emit, and places it.
    fn group(&mut self, mark: &Mark, grown: &[usize], moves: &[DMat4], entity: &Entity<'_>) -> Result<(), SceneError> {
        let id = format!("array-{}", self.arrays);
        self.arrays += 1;
        let mut group = Draft { id: id.clone(), ..Draft::new(PluginClass::Shape, "shapegroup", &entity.location()) };
        let plain = |surface: &usize| self.surfaces[*surface].radiance.is_none();
        for surface in grown.iter().copied().filter(plain).collect::<Vec<_>>() {
            let mesh = self.surfaces[surface].mesh.split_off(mark.meshes.get(surface).copied().unwrap_or([0; 2]));
            let name = format!("mgf-{id}-{surface}.ply");
            self.made.meshes.insert(name.clone(), mesh.into_triangles().into());
            let shape = Draft::new(PluginClass::Shape, "ply", &entity.location()).with_text("filename", &name);
            group = group.with_child("", self.finished(shape, &self.surfaces[surface]));
        }
        let (mut instances, mut groups) = (Vec::new(), Vec::new());
        for shape in self.shapes.split_off(mark.shapes) {
            match shape.plugin.as_str() {
                "instance" => instances.push(shape),
                "shapegroup" => groups.push(shape),
                _ if emits(&shape) => self.shapes.push(shape),
                _ => group = group.with_child("", shape),
            }
        }
        self.shapes.extend(groups);
        if !group.children.is_empty() {
            self.shapes.push(group);
            let here = Draft::new(PluginClass::Shape, "instance", &entity.location()).with_reference(&id);
            instances.push(here);
        }
        for placed in std::iter::once(&DMat4::IDENTITY).chain(moves) {
            for instance in &instances {
                self.add(moved(instance.clone(), *placed), entity)?;
            }
        }
        Ok(())
    }
}

/// Whether a draft of the stage shines.
fn emits(shape: &Draft) -> bool {
    let is_emitter = |target: &Target| matches!(target, Target::Plugin(plugin) if plugin.class == PluginClass::Emitter);
    shape.class == PluginClass::Emitter || shape.children.iter().any(|child| is_emitter(&child.target))
}

/// An instance that is moved in the world.
fn moved(mut instance: Draft, placed: DMat4) -> Draft {
    for parameter in &mut instance.parameters {
        if let Value::Transform(to_world) = &mut parameter.value {
            *to_world = placed * *to_world;
            return instance;
        }
    }
    instance.with_transform("to_world", placed)
}
