//! Which properties of a PLY file are attributes of vertices or faces, in Mitsuba's names (as measured with 3.9.1).
//!
//! | properties, one after the other | attribute of vertices |
//! |---|---|
//! | `r`, `g`, `b` or `red`, `green`, `blue` in any order | `vertex_color` |
//! | `heat_0`; `heat_1`; `heat_x` | `vertex_heat`, a number |
//! | `heat_0` to `heat_2`; `heat_1` to `heat_3`; `heat_x` to `heat_z` | `vertex_heat`, a color |
//! | `heat_r`; `heat_r` to `heat_b` | `vertex_heat_color`, a number; a color |
//!
//! Those of faces start with `face_`. All other properties are passed over; so is the alpha of a color.

use std::ops::Range;

use super::super::triangle_mesh::MeshValues;
use super::header::{Element, Property};

/// The properties of an element that make an attribute.
pub(super) struct Group {
    /// Indices of the properties.
    properties: Range<usize>,
    values: MeshValues,
}

/// Endings of the three numbers of a color; numbers end as the first of one.
const ENDINGS: [[&str; 3]; 4] = [["0", "1", "2"], ["1", "2", "3"], ["x", "y", "z"], ["r", "g", "b"]];
const COLOR_NAMES: [[&str; 3]; 2] = [["r", "g", "b"], ["red", "green", "blue"]];

/// The attributes of an element; `kind` is `vertex_` or `face_`. The first of several with the same name counts.
pub(super) fn find(element: &Element, kind: &str) -> Vec<Group> {
    let names: Vec<Option<&str>> = element.properties.iter().map(scalar_name).collect();
    let mut found: Vec<Group> = Vec::new();
    let mut start = 0;
    while start < names.len() {
        let (length, attribute) = group_at(&names[start..]);
        let Some(name) = attribute.map(|name| format!("{kind}{name}")) else {
            start += length;
            continue;
        };
        if found.iter().all(|group| group.values.name != name) {
            let channels = length.min(3);
            let values = MeshValues { name, channels, numbers: Vec::new() };
            found.push(Group { properties: start..start + channels, values });
        }
        start += length;
    }
    found
}

fn scalar_name(property: &Property) -> Option<&str> {
    matches!(property, Property::Scalar { .. }).then(|| property.name())
}

/// A name before and after its last underscore.
fn stem_and_ending<'a>(name: &Option<&'a str>) -> Option<(&'a str, &'a str)> {
    name.and_then(|name| name.rsplit_once('_')).filter(|(stem, _)| !stem.is_empty())
}

/// How many of the first properties belong together, and the name of the attribute that they make.
fn group_at(names: &[Option<&str>]) -> (usize, Option<String>) {
    let is_color =
        |[a, b, c]: [&str; 3]| names.len() >= 3 && [a, b, c].iter().all(|name| names[..3].contains(&Some(name)));
    if COLOR_NAMES.into_iter().any(is_color) {
        let has_alpha = matches!(names.get(3), Some(Some("a" | "alpha")));
        return (if has_alpha { 4 } else { 3 }, Some("color".to_owned()));
    }
    let Some((stem, _)) = names.first().and_then(stem_and_ending) else { return (1, None) };
    let endings: Vec<&str> =
        names.iter().map_while(stem_and_ending).take_while(|(other, _)| *other == stem).map(|(_, end)| end).collect();
    let known = ENDINGS.iter().find(|known| [1, 3].contains(&endings.len()) && known[..endings.len()] == endings[..]);
    let name = known.map(|known| if known[0] == "r" { format!("{stem}_color") } else { stem.to_owned() });
    (endings.len(), name)
}

impl Group {
    /// Takes one vertex's or face's numbers, `times` over, from those of all properties; the name of the first that is not finite.
    pub(super) fn push(&mut self, properties: &[f64], times: usize) -> Result<(), &str> {
        let numbers = &properties[self.properties.clone()];
        if numbers.iter().any(|number| !(*number as f32).is_finite()) {
            return Err(&self.values.name);
        }
        for _ in 0..times {
            self.values.numbers.extend(numbers.iter().map(|number| *number as f32));
        }
        Ok(())
    }

    pub(super) fn into_values(self) -> MeshValues {
        self.values
    }
}

/// The endings under which an attribute is written.
pub(super) const WRITTEN_ENDINGS: [&str; 3] = ENDINGS[0];
