//! `<Lights>` and the colors behind and everywhere.

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::super::notices::Notices;
use super::super::transform;
use super::element::Element;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

const LIGHTS: [&str; 5] = ["AmbientLight", "PointLight", "AreaLight", "DirectionalLight", "SpotLight"];

/// The lights of the scene that are not objects, `scale` times as strong as they are written.
pub(super) fn read(scene: &Element<'_>, scale: f64, notices: &mut Notices) -> Result<Vec<Draft>, SceneError> {
    if let Some(background) = scene.child("BackgroundColor")?
        && background.color()? != [0.0; 3]
    {
        let explanation = "it is seen but lights nothing, which no emitter does: the background is black";
        notices.add(Notice::ignored(&background.location(), "the background color", explanation));
    }
    let Some(list) = scene.child("Lights")? else { return Ok(Vec::new()) };
    list.report_unknown(&LIGHTS, &[], notices);
    let mut drafts = Vec::new();
    for light in list.elements() {
        match light.tag() {
            "AmbientLight" => ambient(&light, notices)?,
            "PointLight" => drafts.push(point(&light, scale, notices)?),
            "AreaLight" => drafts.push(area(&light, scale, notices)?),
            "DirectionalLight" => drafts.push(directional(&light, scale, notices)?),
            "SpotLight" => drafts.push(spot(&light, scale, notices)?),
            _ => {}
        }
    }
    Ok(drafts)
}

fn ambient(light: &Element<'_>, notices: &mut Notices) -> Result<(), SceneError> {
    if light.color()? != [0.0; 3] {
        let explanation = "light between surfaces is computed instead";
        notices.add(Notice::ignored(&light.location(), "the ambient light", explanation));
    }
    Ok(())
}

/// The strength of a light in the element `tag`.
fn strength(light: &Element<'_>, tag: &str, scale: f64) -> Result<[f64; 3], SceneError> {
    Ok(light.required(tag)?.color()?.map(|channel| channel * scale))
}

fn point(light: &Element<'_>, scale: f64, notices: &mut Notices) -> Result<Draft, SceneError> {
    light.report_unknown(&["Position", "Intensity"], &[], notices);
    let position = DVec3::from_array(light.required("Position")?.tuple()?);
    Ok(Draft::new(PluginClass::Emitter, "point", &light.location())
        .with_point("position", position)
        .with_rgb("intensity", strength(light, "Intensity", scale)?))
}

fn directional(light: &Element<'_>, scale: f64, notices: &mut Notices) -> Result<Draft, SceneError> {
    light.report_unknown(&["Direction", "Radiance"], &[], notices);
    let direction = DVec3::from_array(light.required("Direction")?.tuple()?);
    Ok(Draft::new(PluginClass::Emitter, "directional", &light.location())
        .with_point("direction", direction)
        .with_rgb("irradiance", strength(light, "Radiance", scale)?))
}

/// A transform that puts +z from `position` along the direction in the element `tag`.
fn along(light: &Element<'_>, tag: &str) -> Result<DMat4, SceneError> {
    let position: [f64; 3] = light.required("Position")?.tuple()?;
    let element = light.required(tag)?;
    let no_direction = || element.error(format!("<{tag}> has no direction"), "write a vector that is not 0");
    let direction = DVec3::from_array(element.tuple()?).try_normalize().ok_or_else(no_direction)?;
    let up = direction.any_orthonormal_vector().to_array();
    let turned = transform::look_at([0.0; 3], direction.to_array(), up).map_err(|_| no_direction())?;
    Ok(transform::translate(position) * turned)
}

/// A square that shines to the side of its normal.
fn area(light: &Element<'_>, scale: f64, notices: &mut Notices) -> Result<Draft, SceneError> {
    light.report_unknown(&["Position", "Normal", "Size", "Radiance"], &[], notices);
    let half = 0.5 * light.required("Size")?.number()?;
    let to_world = along(light, "Normal")? * transform::scale([half, half, 1.0]);
    let location = light.location();
    let explanation = "it is seen, it casts shadows, and it shines to the side of its normal only";
    notices.add(Notice::approximated(&location, "<AreaLight>", explanation));
    let emitter = Draft::new(PluginClass::Emitter, "area", &location);
    Ok(Draft::new(PluginClass::Shape, "rectangle", &location)
        .with_transform("to_world", to_world)
        .with_child("", emitter.with_rgb("radiance", strength(light, "Radiance", scale)?)))
}

fn spot(light: &Element<'_>, scale: f64, notices: &mut Notices) -> Result<Draft, SceneError> {
    light.report_unknown(&["Position", "Direction", "Intensity", "CoverageAngle", "FalloffAngle"], &[], notices);
    let location = light.location();
    let explanation = "between full and no light it falls linearly with the angle";
    notices.add(Notice::approximated(&location, "the edge of a <SpotLight>", explanation));
    let [cutoff, beam] = ["CoverageAngle", "FalloffAngle"].map(|tag| light.required(tag));
    Ok(Draft::new(PluginClass::Emitter, "spot", &location)
        .with_transform("to_world", along(light, "Direction")?)
        .with_rgb("intensity", strength(light, "Intensity", scale)?)
        .with_float("cutoff_angle", 0.5 * cutoff?.number()?)
        .with_float("beam_width", 0.5 * beam?.number()?))
}
