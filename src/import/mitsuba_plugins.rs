//! What becomes of every plugin of Mitsuba 3.9.1 and of every parameter of it: the rows of `docs/COMPATIBILITY.md`.
//!
//! `tests/scene/import/mitsuba_plugins.rs` loads a scene with each of them and holds the tables to what happens. Mitsuba's own lists were found by
//! giving its plugins parameters and watching which it takes.

mod lights;
mod materials;
mod media;
mod rendering;
mod shapes;
mod textures;

use std::fmt::Write;

use super::compatibility::Support;
use crate::scene::description::PluginClass;

/// One plugin.
#[derive(Clone, Copy, Debug)]
pub struct Plugin {
    /// Its name.
    pub name: &'static str,
    /// How well it is represented.
    pub support: Support,
    /// What takes its place, or what is lost; may be empty.
    pub remark: &'static str,
    /// Its parameters, but for those of all plugins of its class; of a plugin that is refused none.
    pub parameters: &'static [Parameters],
}

/// Parameters that are represented equally well.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// Their names, with spaces between them.
    pub names: &'static str,
    /// How well they are represented.
    pub support: Support,
    /// What takes their place, or what is lost; may be empty.
    pub remark: &'static str,
}

/// The plugins of a class.
#[derive(Clone, Copy, Debug)]
pub struct Class {
    /// The class of all.
    pub class: PluginClass,
    /// What it is called on the page.
    pub title: &'static str,
    /// Parameters of every plugin that is not refused.
    pub parameters: &'static [Parameters],
    /// The plugins.
    pub plugins: &'static [Plugin],
}

/// All plugins of Mitsuba 3.9.1 by class.
pub const CLASSES: &[Class] = &[
    shapes::SHAPES,
    materials::BSDFS,
    textures::TEXTURES,
    textures::SPECTRA,
    lights::EMITTERS,
    rendering::SENSORS,
    rendering::FILMS,
    rendering::FILTERS,
    rendering::SAMPLERS,
    rendering::INTEGRATORS,
    media::MEDIA,
    media::PHASES,
    media::VOLUMES,
];

const fn same(names: &'static str) -> Parameters {
    Parameters { names, support: Support::Same, remark: "" }
}

const fn approximated(names: &'static str, remark: &'static str) -> Parameters {
    Parameters { names, support: Support::Approximated, remark }
}

const fn passed_over(names: &'static str, remark: &'static str) -> Parameters {
    Parameters { names, support: Support::PassedOver, remark }
}

const fn refused(names: &'static str, remark: &'static str) -> Parameters {
    Parameters { names, support: Support::Refused, remark }
}

impl Plugin {
    const fn new(
        name: &'static str,
        support: Support,
        remark: &'static str,
        parameters: &'static [Parameters],
    ) -> Self {
        Self { name, support, remark, parameters }
    }

    /// A plugin that is represented as it is, but perhaps for some of its parameters.
    const fn same(name: &'static str, parameters: &'static [Parameters]) -> Self {
        Self::new(name, Support::Same, "", parameters)
    }

    /// A plugin that no scene can be rendered with.
    const fn refused(name: &'static str) -> Self {
        Self::new(name, Support::Refused, "", &[])
    }
}

/// The tables as Markdown.
pub fn markdown() -> String {
    let mut text = String::new();
    for Class { title, parameters, plugins, .. } in CLASSES {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "### {title}\n");
        if !parameters.is_empty() {
            let _ = writeln!(text, "Of all that are read: {}.\n", described(parameters));
        }
        text.push_str("| plugin | support | parameters |\n|---|---|---|\n");
        for Plugin { name, support, remark, parameters } in *plugins {
            let remark = if remark.is_empty() { String::new() } else { format!(": {remark}") };
            let _ = writeln!(text, "| `{name}` | {}{remark} | {} |", support.name(), described(parameters));
        }
        text.push('\n');
    }
    text
}

/// Parameters by how well they are represented.
fn described(parameters: &[Parameters]) -> String {
    let group = |Parameters { names, support, remark }: &Parameters| {
        let names: Vec<String> = names.split(' ').map(|name| format!("`{name}`")).collect();
        let remark = if remark.is_empty() { String::new() } else { format!(" ({remark})") };
        format!("{}: {}{remark}", support.name(), names.join(", "))
    };
    parameters.iter().map(group).collect::<Vec<_>>().join("; ")
}
