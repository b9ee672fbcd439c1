//! What the things of a scene are called, for those who select them in a picture: shapes, instances and materials.

use std::collections::{BTreeMap, BTreeSet};

use super::description::{Node, PluginClass};

/// What shapes without a bsdf are made of. They share one name, as they share one material.
pub(crate) const DEFAULT_MATERIAL: &str = "default material";

/// What one thing is called.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Name {
    /// What the scene calls it; empty where it gives it no name.
    pub given: String,
    /// Its place among its kind in the order of the scene, from 1; copies of one thing have the same.
    pub number: u32,
}

/// What the things of a scene are called.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// Shapes by their indices, then instances in the order of the scene.
    pub objects: Vec<Name>,
    /// Materials by their indices.
    pub materials: Vec<Name>,
}

/// Names without repetition, and which of them each thing has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UniqueNames {
    /// Each name once, in the order of the scene.
    pub names: Vec<String>,
    /// By the index of a thing, the index of its name.
    pub of_thing: Vec<u32>,
}

impl UniqueNames {
    /// The names of things.
    pub fn names_of(&self, things: &[usize]) -> Vec<u32> {
        things.iter().map(|thing| self.of_thing[*thing]).collect()
    }
}

impl Names {
    /// The names of objects: what the scene gives none is called `shape` and its number.
    pub fn unique_objects(&self) -> UniqueNames {
        unique(&self.objects, "shape")
    }

    /// The names of materials: what the scene gives none is called `material` and its number.
    pub fn unique_materials(&self) -> UniqueNames {
        unique(&self.materials, "material")
    }
}

/// What the scene calls a plugin; empty where it gives it no name.
pub(super) fn given_name(node: &Node) -> &str {
    if node.name.is_empty() { &node.id } else { &node.name }
}

/// The name of a material, or, where only what it wraps has one, of that.
pub(super) fn given_name_of_material(mut node: &Node) -> &str {
    while given_name(node).is_empty() {
        let mut inside = node.children.iter().filter(|child| child.node.class == PluginClass::Bsdf);
        match (inside.next(), inside.next()) {
            (Some(only), None) => node = &only.node,
            _ => break,
        }
    }
    given_name(node)
}

fn unique(things: &[Name], kind: &str) -> UniqueNames {
    let given: BTreeSet<&str> = things.iter().map(|thing| thing.given.as_str()).collect();
    let name_of = |thing: &Name| {
        if !thing.given.is_empty() {
            return thing.given.clone();
        }
        let mut name = format!("{kind} {}", thing.number);
        // The scene may call another thing so.
        while given.contains(name.as_str()) {
            name.push('_');
        }
        name
    };
    let (mut unique, mut index_of) = (UniqueNames::default(), BTreeMap::new());
    for name in things.iter().map(name_of) {
        let index = *index_of.entry(name.clone()).or_insert_with(|| {
            unique.names.push(name);
            unique.names.len() as u32 - 1
        });
        unique.of_thing.push(index);
    }
    unique
}
