//! Lights.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::super::transform::{any_up, look_at};
use super::super::values::shown;
use super::output::Output;
use super::parameters::Parameters;
use super::spectrum::{self, Purpose};
use super::texture::{self, ColorOrTexture, mean_color};
use super::{area_light, goniometric, infinite};
use crate::scene::description::PluginClass;
use crate::scene::error::{SceneError, nearest_name};

pub(super) use area_light::AreaSource;

/// A light that is not a shape, with the transform `to_world` in effect.
///
/// # Errors
/// On kinds that pbrt does not have.
pub(super) fn other(
    kind: &str,
    parameters: &Parameters,
    to_world: DMat4,
    output: &mut Output<'_>,
) -> Result<(), SceneError> {
    let light = |plugin: &str| Draft::new(PluginClass::Emitter, plugin, &parameters.place);
    let from = parameters.vector("from")?.unwrap_or(DVec3::ZERO);
    let draft = match kind {
        "point" => {
            let intensity = with_power(emission(parameters, "I", output)?, 4.0 * PI, parameters)?;
            let position = to_world.transform_point3(from);
            light("point").with_rgb("intensity", intensity).with_point("position", position)
        }
        "distant" => {
            let irradiance = with_illuminance(emission(parameters, "L", output)?, 1.0, parameters)?;
            let direction = to_world.transform_vector3(target(parameters)? - from);
            light("directional").with_rgb("irradiance", irradiance).with_point("direction", direction)
        }
        "spot" => spot(light("spot"), from, parameters, to_world, output)?,
        "infinite" => {
            if parameters.has("portal") {
                parameters.pass_over(&["portal"]);
                let instead = "light comes from everywhere, in pbrt through the portal alone: they agree where nothing else is open";
                output.approximated(&parameters.place, "the portal of an infinite light", instead);
            }
            match parameters.text("filename")? {
                Some(name) => infinite::read(name, parameters, to_world, output)?,
                None => {
                    let radiance = with_illuminance(emission(parameters, "L", output)?, PI, parameters)?;
                    light("constant").with_rgb("radiance", radiance)
                }
            }
        }
        "goniometric" => goniometric::read(parameters, to_world, output)?,
        "projection" => projection(light("spot"), parameters, to_world, output)?,
        _ => {
            let known = ["point", "distant", "spot", "infinite", "goniometric", "projection"];
            let problem = format!("there is no light {}", shown(kind));
            return Err(SceneError::new(&parameters.place, problem, nearest_name(kind, &known)));
        }
    };
    // pbrt has no such parameter.
    let draft = draft.in_light_group(parameters.text("light_group")?);
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
    let cutoff = parameters.float("coneangle")?.unwrap_or(30.0);
    let delta = parameters.float("conedeltaangle")?.unwrap_or(5.0);
    if delta > 0.0 {
        let instead = "between its two cones light falls linearly with the angle";
        output.approximated(&parameters.place, "the edge of a spot light", instead);
    }
    let [end, start] = [cutoff, cutoff - delta].map(|angle| libm::cos(angle.to_radians()));
    let solid_angle = 2.0 * PI * ((1.0 - start) + 0.5 * (start - end));
    let intensity = with_power(emission(parameters, "I", output)?, solid_angle, parameters)?;
    let [from, to] = [from, target(parameters)?].map(|point| to_world.transform_point3(point).to_array());
    let to_world = look_at(from, to, any_up(from, to))
        .map_err(|problem| SceneError::new(&parameters.place, problem, "give \"from\" and \"to\" that differ"))?;
    let draft = draft.with_rgb("intensity", intensity).with_float("cutoff_angle", cutoff);
    Ok(draft.with_float("beam_width", (cutoff - delta).max(0.0)).with_transform("to_world", to_world))
}

/// A spot light of the image's mean color takes the place of a projector.
fn projection(
    draft: Draft,
    parameters: &Parameters,
    to_world: DMat4,
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    let Some(name) = parameters.text("filename")? else {
        return Err(SceneError::new(&parameters.place, "a projection has no \"filename\"", "name the image"));
    };
    let image = texture::plain_image(name, parameters, output)?;
    let mean = mean_color(&image, output)?;
    let angle = parameters.float("fov")?.unwrap_or(90.0).clamp(1e-3, 179.0);
    let scale = parameters.float("scale")?.unwrap_or(1.0);
    let solid_angle = 2.0 * PI * (1.0 - libm::cos((0.5 * angle).to_radians()));
    let intensity =
        with_power(mean.map(|channel| channel * scale), solid_angle * spectrum::luminance(mean), parameters)?;
    let instead = "a spot light of the image's mean color and as wide as its shorter side takes its place";
    output.approximated(&parameters.place, "light \"projection\"", instead);
    let cutoff = 0.5 * angle;
    let draft = draft.with_rgb("intensity", intensity).with_float("cutoff_angle", cutoff);
    Ok(draft.with_float("beam_width", cutoff).with_transform("to_world", to_world))
}

fn target(parameters: &Parameters) -> Result<DVec3, SceneError> {
    Ok(parameters.vector("to")?.unwrap_or(DVec3::Z))
}

/// The color `name`, white by default, times `scale`.
pub(super) fn emission(parameters: &Parameters, name: &str, output: &mut Output<'_>) -> Result<[f64; 3], SceneError> {
    let color = match parameters.find(name) {
        Some(parameter) => spectrum::read(parameter, Purpose::Emission, output)?,
        None => [1.0; 3],
    };
    let scale = parameters.float("scale")?.unwrap_or(1.0);
    Ok(color.map(|channel| channel * scale))
}

/// A color of light whose flux is `power`, if that is given; `flux` is that of a color of luminance 1. As in pbrt the color
/// counts beside the power.
pub(super) fn with_power(color: [f64; 3], flux: f64, parameters: &Parameters) -> Result<[f64; 3], SceneError> {
    Ok(match parameters.float("power")?.filter(|power| *power > 0.0) {
        Some(power) => color.map(|channel| channel * power / flux.max(f64::MIN_POSITIVE)),
        None => color,
    })
}

/// A color of light whose irradiance is `illuminance`, if that is given; `irradiance` is that of a color of luminance 1.
fn with_illuminance(color: [f64; 3], irradiance: f64, parameters: &Parameters) -> Result<[f64; 3], SceneError> {
    Ok(match parameters.float("illuminance")?.filter(|illuminance| *illuminance > 0.0) {
        Some(illuminance) => color.map(|channel| channel * illuminance / irradiance),
        None => color,
    })
}

/// Reads the light of the shapes that come after `AreaLightSource`.
///
/// # Errors
/// On kinds that pbrt does not have, and a color beside an image.
pub(super) fn area(kind: &str, parameters: &Parameters, output: &mut Output<'_>) -> Result<AreaSource, SceneError> {
    if kind != "diffuse" {
        let problem = format!("there is no area light {}", shown(kind));
        return Err(SceneError::new(&parameters.place, problem, nearest_name(kind, &["diffuse"])));
    }
    let source = match parameters.text("filename")? {
        None => AreaSource::of_color(emission(parameters, "L", output)?, parameters)?,
        Some(_) if parameters.has("L") => {
            return Err(SceneError::new(&parameters.place, "the light has a color and an image", "remove one of them"));
        }
        Some(name) => {
            let image = texture::plain_image(name, parameters, output)?.with_text("wrap_mode", "clamp");
            let mean = spectrum::luminance(mean_color(&image, output)?);
            let scale = parameters.float("scale")?.unwrap_or(1.0);
            let value = ColorOrTexture::Texture(output.define("texture", "light", image)?);
            AreaSource::of_image(value.scaled([scale; 3], parameters, output)?, mean, parameters)?
        }
    };
    output.report_unused("area light \"diffuse\"", parameters)?;
    Ok(source)
}
