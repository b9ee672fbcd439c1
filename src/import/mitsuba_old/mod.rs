//! Scenes of Mitsuba 0.6 and before: what the XML reader drafted in the old names, in the names of Mitsuba 3.
//!
//! [`rules`] is the table of plugins and parameters, `before_0_5` what still older versions called them. What a rule alone
//! cannot say stands in `materials`, `light_and_shape`, `textures` and `cameras_and_methods`. Defaults are written out
//! wherever Mitsuba 3 has others. Whatever has no counterpart leaves a [`Notice`].

mod before_0_5;
mod cameras_and_methods;
mod cie;
mod color;
mod foreign;
mod light_and_shape;
mod materials;
mod media;
mod obj_materials;
mod rules;
pub(super) mod spectrum;
mod textures;
mod version;
mod xml;

use std::collections::{BTreeMap, BTreeSet};

use super::draft::{Alias, Draft, DraftChild, Reading, Target};
use crate::scene::bundle::Bundle;
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::{SceneError, closest_name};
use crate::scene::notice::Notice;
use rules::{RULES, Rule};

pub(super) use color::TAGS as COLOR_TAGS;
pub(super) use version::Version;
pub(super) use xml::class_of_tag;

/// What the XML reader leaves to the translation.
#[derive(Default)]
pub(super) struct Old {
    /// The ids inside tags that were passed over.
    pub passed_over: BTreeSet<String>,
}

/// What became of a plugin.
enum Outcome {
    /// It has a counterpart, which is this.
    Plugin(Draft),
    /// Something that stood inside takes its place.
    Instead(Target),
    /// A plain value takes its place.
    Value(Value),
    /// Nothing takes its place.
    Nothing,
}

/// Translates a scene that was read from a file of `version`.
///
/// # Errors
/// On plugins that no version of Mitsuba has, with the nearest name.
pub(super) fn translate(
    mut reading: Reading,
    version: Version,
    old: Old,
    bundle: &Bundle,
) -> Result<Reading, SceneError> {
    obj_materials::split(&mut reading, bundle);
    let Reading { mut root, aliases, includes, notices, moves } = reading;
    let gone = old.passed_over.into_iter().map(|id| (id, None)).collect();
    let mut translation = Translation { version, notices, aliases, gone, media: BTreeSet::new() };
    translation.children(&mut root)?;
    let Translation { mut notices, mut aliases, gone, .. } = translation;
    remove_references(&mut root, &gone);
    media::settle(&mut root, &mut notices);
    // In the order of the files, whichever step found what.
    let files: BTreeMap<&str, usize> = includes.iter().map(|(name, _)| name.as_str()).zip(0..).collect();
    notices.sort_by_key(|notice| (files.get(notice.location.file.as_str()).copied(), notice.location.line));
    aliases.retain(|alias| !gone.contains_key(&alias.known));
    Ok(Reading { root, aliases, includes, notices, moves })
}

struct Translation {
    version: Version,
    notices: Vec<Notice>,
    aliases: Vec<Alias>,
    /// The ids of plugins that nothing, or a plain value, took the place of.
    gone: BTreeMap<String, Option<Value>>,
    /// The paths of shapes that held a medium.
    media: BTreeSet<String>,
}

impl Translation {
    /// Translates the plugins in `parent`.
    fn children(&mut self, parent: &mut Draft) -> Result<(), SceneError> {
        for child in std::mem::take(&mut parent.children) {
            let Target::Plugin(draft) = child.target else {
                parent.children.push(child);
                continue;
            };
            let id = draft.id.clone();
            let target = match self.plugin(draft)? {
                Outcome::Plugin(draft) => Target::Plugin(draft),
                Outcome::Instead(target) => self.in_place_of(&id, target, &child.location),
                Outcome::Value(value) => {
                    self.gone.insert(id, Some(value.clone()));
                    // A texture directly in the scene only waits for references.
                    if !child.name.is_empty() {
                        parent.parameters.push(Parameter { name: child.name, value, location: child.location });
                    }
                    continue;
                }
                Outcome::Nothing => {
                    self.gone.insert(id, None);
                    continue;
                }
            };
            // A reference that stands directly in the scene would be an error; its plugin is in the scene already.
            if !(parent.class == PluginClass::Scene && matches!(target, Target::Reference(_))) {
                parent.children.push(DraftChild { target, ..child });
            }
        }
        Ok(())
    }

    fn plugin(&mut self, mut draft: Draft) -> Result<Outcome, SceneError> {
        before_0_5::rename(&mut draft, self.version);
        let Some(rule) = RULES.iter().find(|rule| rule.class == draft.class && rule.old == draft.plugin) else {
            return foreign::translate(draft, self);
        };
        self.rename(&mut draft, rule);
        if draft.children.iter().any(|child| media::BORDERS.contains(&child.name.as_str())) {
            self.media.insert(draft.location.path.clone());
        }
        self.children(&mut draft)?;
        let mut outcome = (rule.change)(draft, self)?;
        if let Outcome::Plugin(draft) = &mut outcome {
            draft.plugin = rule.new.to_owned();
        }
        Ok(outcome)
    }

    /// Gives parameters and slots their new names. Those that the rule uses itself keep the old ones.
    fn rename(&mut self, draft: &mut Draft, rule: &Rule) {
        let subject = format!("of {} \"{}\"", draft.class.tag(), draft.plugin);
        draft.parameters.retain_mut(|parameter| {
            if rule.uses(&parameter.name) {
                return true;
            }
            if rule.keeps(&parameter.name) {
                parameter.name = rules::new_name(&parameter.name);
                return true;
            }
            if rule.passes_over(&parameter.name) {
                return false;
            }
            let names = rule.parameters();
            let explanation = match closest_name(&parameter.name, names) {
                Some(name) => format!("it has no counterpart; did you mean \"{name}\"?"),
                None => "it has no counterpart".to_owned(),
            };
            let subject = format!("parameter \"{}\" {subject}", parameter.name);
            self.notices.push(Notice::ignored(&parameter.location, subject, explanation));
            false
        });
        for child in draft.children.iter_mut().filter(|child| rule.keeps(&child.name)) {
            child.name = rules::new_name(&child.name);
        }
    }

    /// Makes references to `id` lead to `target`, which took its place.
    fn in_place_of(&mut self, id: &str, mut target: Target, location: &crate::scene::error::Location) -> Target {
        let known = match &mut target {
            _ if id.is_empty() => return target,
            Target::Plugin(inner) if inner.id.is_empty() => {
                inner.id = id.to_owned();
                return target;
            }
            Target::Plugin(inner) => inner.id.clone(),
            Target::Reference(known) => known.clone(),
        };
        self.aliases.push(Alias { known, other: id.to_owned(), location: location.clone() });
        target
    }

    /// Tells that something took the place of `draft`, or of its part `subject`.
    fn approximated(&mut self, draft: &Draft, subject: impl Into<String>, explanation: impl Into<String>) {
        self.notices.push(Notice::approximated(&draft.location, subject, explanation));
    }

    /// Tells that something of `draft` is left out.
    fn ignored(&mut self, draft: &Draft, subject: impl Into<String>, explanation: impl Into<String>) {
        self.notices.push(Notice::ignored(&draft.location, subject, explanation));
    }
}

/// Takes out references to plugins that are gone, or puts the value there that took the plugin's place.
fn remove_references(draft: &mut Draft, gone: &BTreeMap<String, Option<Value>>) {
    for child in std::mem::take(&mut draft.children) {
        let value = match &child.target {
            Target::Reference(id) => gone.get(id),
            Target::Plugin(_) => None,
        };
        match value {
            None => draft.children.push(child),
            Some(None) => {}
            Some(Some(value)) => {
                let (name, location) = (child.name, child.location);
                draft.parameters.push(Parameter { name, value: value.clone(), location });
            }
        }
    }
    for child in &mut draft.children {
        if let Target::Plugin(plugin) = &mut child.target {
            remove_references(plugin, gone);
        }
    }
}

impl Draft {
    /// Removes parameter `name` and gives its value.
    fn take(&mut self, name: &str) -> Option<Value> {
        let index = self.parameters.iter().position(|parameter| parameter.name == name)?;
        Some(self.parameters.remove(index).value)
    }

    /// Removes parameter `name` if it is a number, and gives it.
    fn take_number(&mut self, name: &str) -> Option<f64> {
        match self.take(name)? {
            Value::Float(number) => Some(number),
            Value::Integer(number) => Some(number as f64),
            _ => None,
        }
    }

    /// Removes parameter `name` if it is text, and gives it.
    fn take_text(&mut self, name: &str) -> Option<String> {
        match self.take(name)? {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    fn has(&self, name: &str) -> bool {
        self.parameters.iter().any(|parameter| parameter.name == name)
            || self.children.iter().any(|child| child.name == name)
    }

    /// Sets parameter `name`, unless it or a texture for it is there.
    fn set_default(&mut self, name: &str, value: Value) {
        if !self.has(name) {
            let location = self.location.clone();
            self.parameters.push(Parameter { name: name.to_owned(), value, location });
        }
    }

    /// A new plugin without parameters that stands where this one does.
    fn beside(&self, class: PluginClass, plugin: &str) -> Draft {
        Draft::new(class, plugin, &self.location)
    }

    fn push_plugin(&mut self, plugin: Draft) {
        let location = self.location.clone();
        self.children.push(DraftChild { name: String::new(), target: Target::Plugin(plugin), location });
    }
}
