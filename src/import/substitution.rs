//! `$name` in attributes: `<default>` parameters and the values that a user defines from outside.

use std::collections::{BTreeMap, HashSet};

use super::values::shown;
use crate::scene::error::{Location, SceneError, nearest_name};

/// How many characters all substitutions of a scene may make together, since parameters may hold parameters.
const SUBSTITUTED_LIMIT: usize = 16 << 20;

/// The longest name of a parameter, in bytes.
const LONGEST_NAME: usize = 256;

/// The known parameters.
pub(super) struct Parameters {
    values: BTreeMap<String, Parameter>,
    budget: usize,
}

struct Parameter {
    value: String,
    /// Defined from outside: beats `<default>`.
    defined: bool,
    used: bool,
}

/// Refuses a parameter that is defined twice, as Mitsuba does.
///
/// # Errors
/// The first such parameter.
pub(super) fn refuse_repeated(defines: &[(String, String)], location: &Location) -> Result<(), SceneError> {
    let mut seen = HashSet::new();
    match defines.iter().find(|(name, _)| !seen.insert(name)) {
        Some((name, _)) => {
            Err(SceneError::new(location, format!("parameter {} is defined twice", shown(name)), "define it once"))
        }
        None => Ok(()),
    }
}

/// Refuses defines for a format without parameters; `remedy` says what to do instead.
///
/// # Errors
/// When anything is defined.
pub(super) fn refuse_defines(
    defines: &[(String, String)],
    location: &Location,
    remedy: &str,
) -> Result<(), SceneError> {
    match defines.first() {
        Some((name, _)) => Err(unused(name, location, remedy.to_owned())),
        None => Ok(()),
    }
}

fn unused(name: &str, location: &Location, remedy: String) -> SceneError {
    SceneError::new(location, format!("the scene does not use the defined parameter \"{name}\""), remedy)
}

impl Parameters {
    /// Starts with the values defined from outside.
    pub(super) fn new(defines: &[(String, String)]) -> Self {
        let define = |(name, value): &(String, String)| {
            (name.clone(), Parameter { value: value.clone(), defined: true, used: false })
        };
        Self { values: defines.iter().map(define).collect(), budget: SUBSTITUTED_LIMIT }
    }

    /// Takes a `<default>`: the first one counts, and none when the parameter is defined from outside.
    ///
    /// # Errors
    /// When the name could not be written after a `$`.
    pub(super) fn set_default(&mut self, name: &str, value: &str, location: &Location) -> Result<(), SceneError> {
        if name.is_empty() || name.len() > LONGEST_NAME || !name.bytes().all(is_name_byte) {
            let problem = format!("{} cannot be the name of a parameter", shown(name));
            return Err(SceneError::new(location, problem, "use letters, digits and \"_\""));
        }
        let parameter = Parameter { value: value.to_owned(), defined: false, used: false };
        self.values.entry(name.to_owned()).or_insert(parameter);
        Ok(())
    }

    /// `text` with every `$name` replaced by its value; of several known names that fit the longest counts.
    ///
    /// # Errors
    /// When a `$` is not followed by a known name, or the substituted text becomes absurdly long.
    pub(super) fn substitute(&mut self, text: &str, location: &Location) -> Result<String, SceneError> {
        let mut parts = text.split('$');
        let mut result = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let run = &part.as_bytes()[..part.len().min(LONGEST_NAME)];
            let run = run.iter().take_while(|byte| is_name_byte(**byte)).count();
            let Some(end) = (1..=run).rev().find(|end| self.values.contains_key(&part[..*end])) else {
                return Err(self.unknown(&part[..run], location));
            };
            let Some(parameter) = self.values.get_mut(&part[..end]) else { continue };
            parameter.used = true;
            let Some(budget) = self.budget.checked_sub(parameter.value.len()) else {
                let problem = "the parameters of this scene expand to more than 16 MiB of text";
                return Err(SceneError::new(location, problem, "write shorter <default> values"));
            };
            self.budget = budget;
            result.push_str(&parameter.value);
            result.push_str(&part[end..]);
        }
        Ok(result)
    }

    fn unknown(&self, name: &str, location: &Location) -> SceneError {
        let names: Vec<&str> = self.values.keys().map(String::as_str).collect();
        let remedy = if names.is_empty() {
            "add a <default> for it before this line".to_owned()
        } else {
            nearest_name(name, &names)
        };
        SceneError::new(location, format!("there is no parameter {}", shown(&format!("${name}"))), remedy)
    }

    /// Fails when a parameter that was defined from outside appears nowhere.
    pub(super) fn check_all_used(&self, scene: &Location) -> Result<(), SceneError> {
        let Some((name, _)) = self.values.iter().find(|(_, parameter)| parameter.defined && !parameter.used) else {
            return Ok(());
        };
        let names: Vec<&str> =
            self.values.iter().filter(|(_, parameter)| !parameter.defined).map(|(name, _)| name.as_str()).collect();
        let remedy = if names.is_empty() { "do not define it".to_owned() } else { nearest_name(name, &names) };
        Err(unused(name, scene, remedy))
    }
}

fn is_name_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}
