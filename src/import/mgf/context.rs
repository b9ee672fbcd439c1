//! Named contexts: scratch space that entities write into and others read.

use std::collections::HashMap;
use std::rc::Rc;

use super::super::values::shown;
use super::text::Entity;
use crate::scene::error::{SceneError, closest_name};

/// The most contexts of one kind that a scene may name.
const NAME_LIMIT: usize = 4_000_000;

/// All contexts of one kind, one of which is current.
pub(super) struct Contexts<T> {
    kind: &'static str,
    default: T,
    places: HashMap<Rc<str>, usize>,
    /// The first is the unnamed context.
    values: Vec<T>,
    names: Vec<Rc<str>>,
    current: usize,
}

impl<T: Copy> Contexts<T> {
    /// The unnamed context alone, with `default`.
    pub(super) fn new(kind: &'static str, default: T) -> Self {
        Self { kind, default, places: HashMap::new(), values: vec![default], names: Vec::new(), current: 0 }
    }

    /// The current context.
    pub(super) fn current(&mut self) -> &mut T {
        &mut self.values[self.current]
    }

    /// The name of the current context, if it has one.
    pub(super) fn current_name(&self) -> Option<&str> {
        self.names.get(self.current.checked_sub(1)?).map(|name| &**name)
    }

    /// Follows a context's entity: no argument for the unnamed one with its defaults, `id` for a known one, `id =` for a
    /// new one, and `id = template` for a copy.
    pub(super) fn select(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        let form = format!("{0}, {0} id, {0} id =, or {0} id = template", entity.keyword);
        entity.check_count(0, 3, &form)?;
        self.current = match entity.words.as_slice() {
            [] => {
                self.values[0] = self.default;
                0
            }
            [name] => self.place(name, entity)?,
            [name, "=", rest @ ..] => {
                let value = rest.first().map_or(Ok(self.default), |template| self.find(template, entity))?;
                self.define(name, value, entity)?
            }
            _ => {
                let problem = format!("{} follows the name where \"=\" belongs", shown(entity.word(1)));
                return Err(entity.error(problem, format!("write {form}")));
            }
        };
        Ok(())
    }

    /// The context called `name`.
    pub(super) fn find(&self, name: &str, entity: &Entity<'_>) -> Result<T, SceneError> {
        self.place(name, entity).map(|place| self.values[place])
    }

    fn place(&self, name: &str, entity: &Entity<'_>) -> Result<usize, SceneError> {
        self.places.get(name).copied().ok_or_else(|| {
            let mut names: Vec<&str> = self.places.keys().map(|name| &**name).collect();
            // Sorted, so that the message does not depend on hashing.
            names.sort_unstable();
            let remedy = match closest_name(name, names) {
                Some(candidate) => format!("did you mean \"{candidate}\"?"),
                None => "define it before it is used".to_owned(),
            };
            entity.error(format!("there is no {} {}", self.kind, shown(name)), remedy)
        })
    }

    fn define(&mut self, name: &str, value: T, entity: &Entity<'_>) -> Result<usize, SceneError> {
        if !name.trim_start_matches('_').starts_with(|letter: char| letter.is_ascii_alphabetic()) {
            let problem = format!("{} is not a name", shown(name));
            return Err(entity.error(problem, "begin names with a letter"));
        }
        if let Some(place) = self.places.get(name) {
            self.values[*place] = value;
            return Ok(*place);
        }
        if self.values.len() > NAME_LIMIT {
            let problem = format!("the scene has more than {NAME_LIMIT} named contexts of one kind");
            return Err(entity.error(problem, "use names again"));
        }
        let name: Rc<str> = name.into();
        self.values.push(value);
        self.names.push(name.clone());
        self.places.insert(name, self.names.len());
        Ok(self.names.len())
    }
}
