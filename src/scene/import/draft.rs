//! Plugins as they stand in a file, before references are resolved.

use super::super::description::{Parameter, PluginClass};
use super::super::error::Location;
use super::report::Notice;

/// What a format's reader makes of a scene file.
pub(super) struct Reading {
    /// The scene.
    pub root: Draft,
    pub aliases: Vec<Alias>,
    /// The files that were read on the way, with the places that name them.
    pub includes: Vec<(String, Location)>,
    /// What could not be represented.
    pub notices: Vec<Notice>,
}

impl Reading {
    /// A scene that stands in one file and is represented completely.
    pub(super) fn complete(root: Draft) -> Self {
        Self { root, aliases: Vec::new(), includes: Vec::new(), notices: Vec::new() }
    }
}

/// One plugin as written.
pub(super) struct Draft {
    pub class: PluginClass,
    pub plugin: String,
    pub id: String,
    pub parameters: Vec<Parameter>,
    pub children: Vec<DraftChild>,
    pub location: Location,
}

/// A nested plugin or a reference to one, with the name of its slot (or empty).
pub(super) struct DraftChild {
    pub name: String,
    pub target: Target,
    pub location: Location,
}

/// What a child is.
pub(super) enum Target {
    /// Written in place.
    Plugin(Draft),
    /// The plugin with this id.
    Reference(String),
}

/// A second id for a plugin: `<alias id="known" as="other">`.
pub(super) struct Alias {
    pub known: String,
    pub other: String,
    pub location: Location,
}
