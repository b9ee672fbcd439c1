//! KHR_lights_punctual: `point`, `spot` and `directional` emitters.
//!
//! glTF counts light as the eye does: candela (lm·sr⁻¹) for point and spot, lux (lm·m⁻²) for directional lights, and
//! candela per m² for emissive materials. photonfarm takes W·sr⁻¹, W·m⁻² and W·sr⁻¹·m⁻². The numbers are taken over as
//! they are, for lights and materials alike, so that their ratios hold; a picture's values are then candela per m². To
//! get watts of green light, divide by 683 lm/W, the luminous efficacy that defines the candela.
//!
//! glTF knows no light groups: `light_group` in the `extras` of a light, of its node or of an emissive material names one.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::DMat4;

use super::super::draft::Draft;
use super::super::resolve::resolve;
use super::Output;
use super::camera::HALF_TURN;
use super::entry::{Document, Entry};
use crate::math::Rgb;
use crate::scene::bundle::Bundle;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;
use crate::scene::texture::{Texture, TextureReader};

/// The light at a node, if it has one.
///
/// # Errors
/// On unknown types, colors and intensities below 0, and cones that no spot can have.
pub(super) fn read(
    node: &Entry<'_>,
    to_world: DMat4,
    document: &Document,
    output: &mut Output,
) -> Result<Option<Draft>, SceneError> {
    let Some(extension) = node.extension("KHR_lights_punctual")? else { return Ok(None) };
    let index = extension.required_integer("light")?;
    let lights = match document.root().extension("KHR_lights_punctual")? {
        Some(all) => all.objects("lights")?,
        None => Vec::new(),
    };
    let Some(light) = lights.get(index) else {
        return Err(extension.error(format!("there is no light {index}"), "export the scene again"));
    };
    let color = light.color("color", [1.0; 3])?;
    let intensity = light.number_within("intensity", 1.0, 0.0, f64::INFINITY)?;
    let strength = Value::Rgb(color.map(|channel| channel * intensity));
    let kind = light.text("type")?.unwrap_or_default();
    let emitter = Draft::new(PluginClass::Emitter, kind, &node.location());
    let place = Value::Transform(to_world * DMat4::from_scale(HALF_TURN));
    let emitter = match kind {
        "point" => {
            let position = to_world.transform_point3(glam::DVec3::ZERO);
            emitter.with("position", Value::Vector(position.to_array())).with("intensity", strength)
        }
        "directional" => emitter.with("to_world", place).with("irradiance", strength),
        "spot" => cone(light, emitter.with("to_world", place).with("intensity", strength), output)?,
        other => {
            let problem = format!("there is no type of light {other:?}");
            return Err(light.error(problem, "give \"point\", \"spot\" or \"directional\""));
        }
    };
    let explanation = "candela, lux and candela per m² are taken as W/sr, W/m² and W/sr/m²";
    output.notices.add(Notice::approximated(&light.location(), "the unit of lights", explanation));
    if light.has("range") {
        let explanation = "light falls off with the square of the distance only";
        output.notices.add(Notice::ignored(&light.location(), "the range of a light", explanation));
    }
    let named_by = [light_group(light)?, light_group(node)?];
    Ok(Some(emitter.in_light_group(named_by.into_iter().flatten().next())))
}

/// The light group that the `extras` of a light, a node or a material name. Extras may hold anything, also what is no object.
///
/// # Errors
/// When the name is no string.
pub(super) fn light_group<'a>(entry: &Entry<'a>) -> Result<Option<&'a str>, SceneError> {
    entry.get("extras").map_or(Ok(None), |extras| extras.text("light_group"))
}

/// Whether an emitter emits nothing: its color or its image is black. An image that cannot be read is not, so that preparing
/// the scene tells what is wrong with it.
pub(super) fn is_black(emitter: &Draft, files: &Bundle) -> bool {
    if emitter.parameters.iter().any(|parameter| parameter.value == Value::Rgb([0.0; 3])) {
        return true;
    }
    let Ok(node) = resolve(emitter, &[]) else { return false };
    let mut textures = TextureReader::new(files);
    let is_black = |texture: Texture| texture.range()[1] == Rgb::ZERO;
    node.children.iter().any(|child| textures.texture(&child.node).is_ok_and(is_black))
}

fn cone(light: &Entry<'_>, emitter: Draft, output: &mut Output) -> Result<Draft, SceneError> {
    let (inner, outer) = match light.child("spot")? {
        Some(spot) => {
            let outer = spot.number_within("outerConeAngle", FRAC_PI_4, 0.0, FRAC_PI_2)?;
            (spot.number_within("innerConeAngle", 0.0, 0.0, outer)?, outer)
        }
        None => (0.0, FRAC_PI_4),
    };
    let explanation = "between the inner and the outer cone light falls linearly with the angle";
    output.notices.add(Notice::approximated(&light.location(), "the edge of a spot light", explanation));
    Ok(emitter
        .with("cutoff_angle", Value::Float(outer.to_degrees()))
        .with("beam_width", Value::Float(inner.to_degrees())))
}
