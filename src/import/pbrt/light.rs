//! Lights.

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::super::transform::{any_up, look_at};
use super::super::values::shown;
use super::output::Output;
use super::parameters::Parameters;
use super::spectrum::{self, Purpose};
use crate::scene::description::PluginClass;
use crate::scene::error::{SceneError, nearest_name};

/// The light of shapes that come after `AreaLightSource`: its radiance, W·sr⁻¹·m⁻².
///
/// # Errors
/// On kinds that pbrt does not have, images, and powers.
pub(super) fn area(kind: &str, parameters: &Parameters, output: &mut Output<'_>) -> Result<[f64; 3], SceneError> {
    if kind != "diffuse" {
        let problem = format!("there is no area light {}", shown(kind));
        return Err(SceneError::new(&parameters.place, problem, nearest_name(kind, &["diffuse"])));
    }
    refuse(parameters, "power", "give the radiance \"L\" instead")?;
    refuse(parameters, "filename", "give one radiance \"L\" for all of the light")?;
    let radiance = emission(parameters, "L", output)?;
    if parameters.flag("twosided")?.unwrap_or(false) {
        output.approximated(&parameters.place, "a two-sided area light", "only its outside emits");
    }
    output.report_unused("area light \"diffuse\"", parameters)?;
    Ok(radiance)
}

/// A light that is not a shape, with the transform `to_world` in effect.
///
/// # Errors
/// As [`area`].
pub(super) fn other(
    kind: &str,
    parameters: &Parameters,
    to_world: DMat4,
    output: &mut Output<'_>,
) -> Result<(), SceneError> {
    refuse(parameters, "power", "give \"I\" or \"L\" instead")?;
    refuse(parameters, "illuminance", "give \"L\" instead")?;
    let light = |plugin: &str| Draft::new(PluginClass::Emitter, plugin, &parameters.place);
    let from = parameters.vector("from")?.unwrap_or(DVec3::ZERO);
    let draft = match kind {
        "point" => {
            let intensity = emission(parameters, "I", output)?;
            let position = to_world.transform_point3(from);
            light("point").with_rgb("intensity", intensity).with_point("position", position)
        }
        "distant" => {
            let irradiance = emission(parameters, "L", output)?;
            let direction = to_world.transform_vector3(target(parameters)? - from);
            light("directional").with_rgb("irradiance", irradiance).with_point("direction", direction)
        }
        "spot" => spot(light("spot"), from, parameters, to_world, output)?,
        "infinite" => {
            refuse(parameters, "filename", "pbrt's maps are octahedral: give \"L\", or another format's scene")?;
            refuse(parameters, "portal", "remove it")?;
            let radiance = emission(parameters, "L", output)?;
            light("constant").with_rgb("radiance", radiance)
        }
        "goniometric" | "projection" => {
            let problem = format!("a light {} is not supported", shown(kind));
            return Err(SceneError::new(&parameters.place, problem, "use \"point\" or \"spot\""));
        }
        _ => {
            let known = ["point", "distant", "spot", "infinite", "goniometric", "projection"];
            let problem = format!("there is no light {}", shown(kind));
            return Err(SceneError::new(&parameters.place, problem, nearest_name(kind, &known)));
        }
    };
    output.report_unused(&format!("light {}", shown(kind)), parameters)?;
    output.add(draft)
}

fn spot(
    draft: Draft,
    from: DVec3,
    parameters: &Parameters,
    to_world: DMat4,
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    let intensity = emission(parameters, "I", output)?;
    let cutoff = parameters.float("coneangle")?.unwrap_or(30.0);
    let delta = parameters.float("conedeltaangle")?.unwrap_or(5.0);
    if delta > 0.0 {
        let instead = "between its two cones light falls linearly with the angle";
        output.approximated(&parameters.place, "the edge of a spot light", instead);
    }
    let [from, to] = [from, target(parameters)?].map(|point| to_world.transform_point3(point).to_array());
    let to_world = look_at(from, to, any_up(from, to))
        .map_err(|problem| SceneError::new(&parameters.place, problem, "give \"from\" and \"to\" that differ"))?;
    let draft = draft.with_rgb("intensity", intensity).with_float("cutoff_angle", cutoff);
    Ok(draft.with_float("beam_width", (cutoff - delta).max(0.0)).with_transform("to_world", to_world))
}

fn target(parameters: &Parameters) -> Result<DVec3, SceneError> {
    Ok(parameters.vector("to")?.unwrap_or(DVec3::Z))
}

/// The color `name`, white by default, times `scale`.
fn emission(parameters: &Parameters, name: &str, output: &mut Output<'_>) -> Result<[f64; 3], SceneError> {
    let color = match parameters.find(name) {
        Some(parameter) => spectrum::read(parameter, Purpose::Emission, output)?,
        None => [1.0; 3],
    };
    let scale = parameters.float("scale")?.unwrap_or(1.0);
    Ok(color.map(|channel| channel * scale))
}

fn refuse(parameters: &Parameters, name: &str, remedy: &str) -> Result<(), SceneError> {
    match parameters.find(name) {
        Some(parameter) => Err(parameter.error("it is not supported", remedy)),
        None => Ok(()),
    }
}
