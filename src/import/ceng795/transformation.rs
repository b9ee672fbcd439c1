//! `<Transformations>`: the steps that a scene names, and the lists of them that objects have.

use std::collections::HashMap;

use glam::DMat4;

use super::super::notices::Notices;
use super::super::transform;
use super::super::values::shown;
use super::element::Element;
use crate::scene::error::{SceneError, nearest_name};

/// Tags of steps, and the letter that lists have for them.
const KINDS: [(&str, &str); 4] = [("Translation", "t"), ("Rotation", "r"), ("Scaling", "s"), ("Composite", "c")];

/// The steps by letter and id, for example `t1`.
#[derive(Default)]
pub(super) struct Transformations {
    steps: HashMap<String, DMat4>,
    /// In the order of the file.
    names: Vec<String>,
}

impl Transformations {
    /// Reads the scene's `<Transformations>`, if it has any.
    pub(super) fn read(scene: &Element<'_>, notices: &mut Notices) -> Result<Self, SceneError> {
        let mut all = Self::default();
        let Some(list) = scene.child("Transformations")? else { return Ok(all) };
        list.report_unknown(&KINDS.map(|(tag, _)| tag), &[], notices);
        for (tag, letter) in KINDS {
            for (index, element) in list.all(tag).enumerate() {
                element.report_unknown(&[], &[], notices);
                let name = element.attribute("id").map_or_else(|| (index + 1).to_string(), str::to_owned);
                let name = format!("{letter}{name}");
                if all.steps.insert(name.clone(), step(&element)?).is_some() {
                    return Err(element.error("the id is given twice", "give every transformation an id of its own"));
                }
                all.names.push(name);
            }
        }
        Ok(all)
    }

    /// What the `<Transformations>` of an object do: each step after the one before.
    pub(super) fn of(&self, object: &Element<'_>) -> Result<DMat4, SceneError> {
        let mut matrix = DMat4::IDENTITY;
        let Some(list) = object.child("Transformations")? else { return Ok(matrix) };
        list.each_word(|word| {
            let step = self.steps.get(word).ok_or_else(|| {
                let known: Vec<&str> = self.names.iter().map(String::as_str).collect();
                (format!("there is no transformation {}", shown(word)), nearest_name(word, &known))
            })?;
            matrix = *step * matrix;
            Ok(())
        })?;
        match matrix.is_finite() {
            true => Ok(matrix),
            false => Err(list.error("the transformations make things explode", "check their numbers")),
        }
    }
}

fn step(element: &Element<'_>) -> Result<DMat4, SceneError> {
    match element.tag() {
        "Translation" => Ok(transform::translate(element.tuple()?)),
        "Scaling" => Ok(transform::scale(element.tuple()?)),
        "Rotation" => {
            let [degrees, x, y, z] = element.tuple()?;
            transform::rotate([x, y, z], degrees).map_err(|problem| element.error(problem, "write \"angle x y z\""))
        }
        _ => Ok(DMat4::from_cols_array(&element.tuple::<16>()?).transpose()),
    }
}
