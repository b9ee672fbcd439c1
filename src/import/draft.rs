//! Plugins as they stand in a file, before references are resolved.

use glam::DMat4;

use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::Location;
use crate::scene::notice::Notice;

/// What a format's reader makes of a scene file.
pub(super) struct Reading {
    /// The scene.
    pub root: Draft,
    pub aliases: Vec<Alias>,
    /// The files that were read on the way, with the places that name them.
    pub includes: Vec<(String, Location)>,
    /// What could not be represented.
    pub notices: Vec<Notice>,
    /// From which moment to which something moves; `None` where nothing does.
    pub moves: Option<[f64; 2]>,
}

impl Reading {
    /// A scene that stands in one file and is represented completely.
    pub(super) fn complete(root: Draft) -> Self {
        Self { root, aliases: Vec::new(), includes: Vec::new(), notices: Vec::new(), moves: None }
    }
}

/// One plugin as written.
#[derive(Clone)]
pub(super) struct Draft {
    pub class: PluginClass,
    pub plugin: String,
    pub id: String,
    /// See [`Node::name`](crate::scene::description::Node::name).
    pub name: String,
    pub parameters: Vec<Parameter>,
    pub children: Vec<DraftChild>,
    pub location: Location,
}

impl Draft {
    /// A plugin without parameters, for importers of formats that have no plugins of their own.
    pub(super) fn new(class: PluginClass, plugin: &str, location: &Location) -> Self {
        Self {
            class,
            plugin: plugin.to_owned(),
            id: String::new(),
            name: String::new(),
            parameters: Vec::new(),
            children: Vec::new(),
            location: location.clone(),
        }
    }

    /// Calls it what the file calls it.
    pub(super) fn called(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }

    /// Gives it the parameter `name`.
    pub(super) fn with(mut self, name: &str, value: Value) -> Self {
        self.parameters.push(Parameter { name: name.to_owned(), value, location: self.location.clone() });
        self
    }

    /// Nests `plugin` in the slot `name`, which may be empty.
    pub(super) fn with_child(mut self, name: &str, plugin: Draft) -> Self {
        let location = plugin.location.clone();
        self.children.push(DraftChild { name: name.to_owned(), target: Target::Plugin(plugin), location });
        self
    }

    /// Refers to the plugin with the given id.
    pub(super) fn with_reference(self, id: &str) -> Self {
        self.with_named_reference("", id)
    }

    /// Refers to the plugin with the given id in the slot `name`.
    pub(super) fn with_named_reference(mut self, name: &str, id: &str) -> Self {
        let (target, location) = (Target::Reference(id.to_owned()), self.location.clone());
        self.children.push(DraftChild { name: name.to_owned(), target, location });
        self
    }
}

/// Extinction and albedo of a medium from its absorption and scattering, for formats that give those; nothing scatters where nothing is.
pub(super) fn extinction_and_albedo(absorption: [f64; 3], scattering: [f64; 3]) -> [[f64; 3]; 2] {
    let extinction = [0, 1, 2].map(|channel| absorption[channel] + scattering[channel]);
    let share =
        |channel: usize| if extinction[channel] == 0.0 { 0.0 } else { scattering[channel] / extinction[channel] };
    [extinction, [0, 1, 2].map(share)]
}

/// Defaults of Mitsuba 3 that other formats do not share.
impl Draft {
    /// Writes out what other formats mean where Mitsuba 3 has a default of its own: films without a filter have a box, which is
    /// the pixel's own square, normals are turned without corrections, and checkerboards give numbers as they give colors.
    pub(super) fn state_plain_defaults(&mut self) {
        let has = |draft: &Draft, class| {
            draft.children.iter().any(|child| matches!(&child.target, Target::Plugin(plugin) if plugin.class == class))
        };
        let lacking = match self.class {
            PluginClass::Sensor => Some((PluginClass::Film, "hdrfilm")),
            PluginClass::Film => Some((PluginClass::ReconstructionFilter, "box")),
            PluginClass::Texture if self.plugin == "checkerboard" => {
                self.state_plain_numbers();
                None
            }
            PluginClass::Bsdf if ["bumpmap", "normalmap"].contains(&self.plugin.as_str()) => {
                self.state_plain_normals();
                None
            }
            _ => None,
        };
        if let Some((class, plugin)) = lacking.filter(|(class, _)| !has(self, *class)) {
            let (target, location) = (Target::Plugin(Draft::new(class, plugin, &self.location)), self.location.clone());
            self.children.push(DraftChild { name: String::new(), target, location });
        }
        for child in &mut self.children {
            if let Target::Plugin(plugin) = &mut child.target {
                plugin.state_plain_defaults();
            }
        }
    }

    /// Writes out that the fields of a checkerboard are where they are seen also where a number is asked for.
    pub(super) fn state_plain_numbers(&mut self) {
        let (value, location) = (Value::Boolean(false), self.location.clone());
        self.parameters.push(Parameter { name: "swaps_numbers".to_owned(), value, location });
    }

    /// Writes out that a normal or bump map turns normals without the corrections of Mitsuba 3.6 and later.
    pub(super) fn state_plain_normals(&mut self) {
        for name in ["flip_invalid_normals", "use_shadowing_function"] {
            if !self.parameters.iter().any(|parameter| parameter.name == name) {
                let (value, location) = (Value::Boolean(false), self.location.clone());
                self.parameters.push(Parameter { name: name.to_owned(), value, location });
            }
        }
    }
}

/// The types of parameters, for each of which there is one way to give it.
impl Draft {
    pub(super) fn with_float(self, name: &str, number: f64) -> Self {
        self.with(name, Value::Float(number))
    }

    pub(super) fn with_flag(self, name: &str, flag: bool) -> Self {
        self.with(name, Value::Boolean(flag))
    }

    /// A `ply` or `sphere` whose outside stays outside where `to_world` mirrors it, as in most programs but Mitsuba.
    pub(super) fn keeping_outside(self, to_world: DMat4) -> Self {
        if to_world.determinant() < 0.0 { self.with_flag("keep_outside", true) } else { self }
    }

    pub(super) fn with_text(self, name: &str, text: &str) -> Self {
        self.with(name, Value::String(text.to_owned()))
    }

    /// An emitter, in a light group where one is named.
    pub(super) fn in_light_group(self, group: Option<&str>) -> Self {
        match group {
            Some(group) => self.with_text("light_group", group),
            None => self,
        }
    }

    pub(super) fn with_rgb(self, name: &str, rgb: [f64; 3]) -> Self {
        self.with(name, Value::Rgb(rgb))
    }

    pub(super) fn with_point(self, name: &str, point: glam::DVec3) -> Self {
        self.with(name, Value::Vector(point.to_array()))
    }

    pub(super) fn with_transform(self, name: &str, matrix: DMat4) -> Self {
        self.with(name, Value::Transform(matrix))
    }
}

/// A nested plugin or a reference to one, with the name of its slot (or empty).
#[derive(Clone)]
pub(super) struct DraftChild {
    pub name: String,
    pub target: Target,
    pub location: Location,
}

impl DraftChild {
    /// Whether it stands elsewhere.
    pub(super) fn is_reference(&self) -> bool {
        matches!(self.target, Target::Reference(_))
    }
}

/// What a child is.
#[derive(Clone)]
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
