//! Light groups: lights that have a name in common. Light adds up, so that a job can keep the light of each group apart.

use crate::scene::error::{Location, SceneError};
use crate::scene::fields::Fields;

/// The group of lights that name none.
pub(crate) const OTHERS: &str = "others";
/// So many groups may be kept apart.
pub(crate) const MOST_GROUPS: usize = 16;
/// The parameter of emitters.
const PARAMETER: &str = "light_group";
/// Bytes of a name.
const LONGEST: usize = 64;

/// The group that a light names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupName {
    /// Its name.
    pub name: String,
    /// Where that stands.
    pub location: Location,
}

/// Reads the group of an emitter.
///
/// # Errors
/// Names that are empty, too long, or cannot be part of a layer's name.
pub(crate) fn read(fields: &mut Fields<'_>) -> Result<Option<GroupName>, SceneError> {
    let Some(name) = fields.string(PARAMETER)? else { return Ok(None) };
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || ['_', '-'].contains(&letter);
    if name.is_empty() || name.len() > LONGEST || !name.chars().all(is_part) {
        let shown: String = name.chars().take(LONGEST).collect();
        let remedy = format!("give 1 to {LONGEST} letters from a to z, digits, _ or -");
        return Err(fields.error(PARAMETER, format!("\"{PARAMETER}\" is {shown:?}"), remedy));
    }
    Ok(Some(GroupName { name: name.to_owned(), location: fields.location_of(PARAMETER).clone() }))
}

/// Which lights of a scene belong together.
#[derive(Clone, Debug, Default)]
pub struct LightGroups {
    /// In the order in which the scene names them, and [`OTHERS`] last.
    names: Vec<String>,
    /// The group of each light by index.
    of_lights: Vec<usize>,
    /// The group of each emission that is seen and lights nothing.
    of_seen: Vec<usize>,
}

impl LightGroups {
    /// The groups of lights by index, and of what is seen and lights nothing.
    ///
    /// # Errors
    /// Names that differ only by case: files and people may take them for one.
    pub fn new(lights: &[Option<GroupName>], seen_only: &[Option<&GroupName>]) -> Result<Self, SceneError> {
        let all = || lights.iter().map(Option::as_ref).chain(seen_only.iter().copied());
        let mut names: Vec<String> = Vec::new();
        for GroupName { name, location } in all().flatten() {
            let known = names.iter().map(String::as_str).chain([OTHERS]).find(|known| known.eq_ignore_ascii_case(name));
            if let Some(known) = known.filter(|known| known != name) {
                let problem = format!("light groups \"{known}\" and \"{name}\" differ only by case");
                return Err(SceneError::new(location, problem, "write both alike, or call one something else"));
            }
            if known.is_none() {
                names.push(name.clone());
            }
        }
        if all().any(|group| group.is_none_or(|group| group.name == OTHERS)) {
            names.push(OTHERS.to_owned());
        }
        let index = |group: Option<&GroupName>| {
            let name = group.map_or(OTHERS, |group| group.name.as_str());
            names.iter().position(|known| known == name).unwrap_or_default()
        };
        let of_lights = lights.iter().map(|group| index(group.as_ref())).collect();
        let of_seen = seen_only.iter().map(|group| index(*group)).collect();
        Ok(Self { names, of_lights, of_seen })
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether a light belongs to a group.
    pub(super) fn has_light(&self, group: usize, light: usize) -> bool {
        self.of_lights.get(light) == Some(&group)
    }

    /// Whether an emission that is seen and lights nothing belongs to a group.
    pub(super) fn has_seen(&self, group: usize, seen: usize) -> bool {
        self.of_seen.get(seen) == Some(&group)
    }
}
