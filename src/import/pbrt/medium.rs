//! `MakeNamedMedium` and `MediumInterface`.

use std::collections::HashMap;

use super::super::draft::{Draft, extinction_and_albedo};
use super::super::values::shown;
use super::output::Output;
use super::parameters::Parameters;
use super::spectrum::{self, Purpose};
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError, nearest_defined_name};

/// Absorption and scattering of a homogeneous medium, m⁻¹, where it gives none.
const ABSORPTION: [f64; 3] = [0.0011, 0.0024, 0.014];
const SCATTERING: [f64; 3] = [2.55, 3.21, 3.77];

/// The id of a medium; none where there is nothing, or nothing that can be rendered.
pub(super) type MediumId = Option<String>;

/// The media of a scene by name.
#[derive(Default)]
pub(super) struct Media {
    ids: HashMap<String, MediumId>,
    /// Whether shapes or the camera stand in some.
    pub used: bool,
}

impl Media {
    /// Follows `MakeNamedMedium`. Other than homogeneous media are left out with a notice.
    ///
    /// # Errors
    /// On numbers that no medium can have, and a second medium of the name.
    pub(super) fn make(
        &mut self,
        name: &str,
        parameters: &Parameters,
        output: &mut Output<'_>,
    ) -> Result<(), SceneError> {
        let place = &parameters.place;
        let kind = parameters.text("type")?.unwrap_or_default().to_owned();
        let id = match kind.as_str() {
            "homogeneous" if !parameters.has("preset") => {
                let medium = homogeneous(parameters, output)?;
                output.report_unused("medium \"homogeneous\"", parameters)?;
                Some(output.define("medium", name, medium)?)
            }
            "homogeneous" => {
                output.ignored(place, "a medium with a preset", "measured media are not known: light passes through");
                None
            }
            _ => {
                let subject = format!("a medium {}", shown(&kind));
                output.ignored(place, subject, "it has no counterpart: light passes through");
                None
            }
        };
        if self.ids.insert(name.to_owned(), id).is_some() {
            let problem = format!("there are two media {}", shown(name));
            return Err(SceneError::new(place, problem, "give each a name of its own"));
        }
        Ok(())
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.ids.len()
    }

    /// The medium of a name; the empty one is that of nothing.
    ///
    /// # Errors
    /// When there is none.
    pub(super) fn find(&self, name: &str, place: &Location) -> Result<MediumId, SceneError> {
        if name.is_empty() {
            return Ok(None);
        }
        self.ids.get(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = self.ids.keys().map(String::as_str).collect();
            let remedy = nearest_defined_name(name, &known, "make it with MakeNamedMedium first");
            SceneError::new(place, format!("there is no medium {}", shown(name)), remedy)
        })
    }

    /// A shape between the media inside and outside.
    pub(super) fn between(&mut self, shape: Draft, media: &[MediumId; 2]) -> Draft {
        if media[0] == media[1] {
            return shape;
        }
        self.used = true;
        ["interior", "exterior"].into_iter().zip(media).fold(shape, |shape, (slot, medium)| match medium {
            Some(id) => shape.with_named_reference(slot, id),
            None => shape,
        })
    }
}

fn homogeneous(parameters: &Parameters, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let mut color = |name: &str, default: [f64; 3]| match parameters.find(name) {
        Some(parameter) => spectrum::read(parameter, Purpose::Reflectance, output),
        None => Ok(default),
    };
    let (absorption, scattering) = (color("sigma_a", ABSORPTION)?, color("sigma_s", SCATTERING)?);
    let scale = parameters.float("scale")?.unwrap_or(1.0);
    let [extinction, albedo] = extinction_and_albedo(absorption, scattering);
    if parameters.has("Le") {
        parameters.pass_over(&["Le", "Lescale"]);
        output.ignored(&parameters.place, "the emission of a medium", "media do not emit");
    }
    let place = &parameters.place;
    let phase = Draft::new(PluginClass::Phase, "hg", place).with_float("g", parameters.float("g")?.unwrap_or(0.0));
    let medium = Draft::new(PluginClass::Medium, "homogeneous", place).with_rgb("sigma_t", extinction);
    Ok(medium.with_rgb("albedo", albedo).with_float("scale", scale).with_child("", phase))
}
