//! Cameras. Those of glTF look along -z with x to the right, Mitsuba's along +z with x to the left.

use glam::{DMat4, DVec3};

use super::super::changes;
use super::super::draft::Draft;
use super::super::transform::look_at;
use super::Output;
use super::entry::Entry;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{Location, SceneError, shown_number};
use crate::scene::notice::Notice;

/// Half a turn about y: from what looks along +z to what looks along -z.
pub(super) const HALF_TURN: DVec3 = DVec3::new(-1.0, 1.0, -1.0);

/// The picture that a camera's aspect ratio is fitted into: that of a film without parameters, pixels.
const FILM: [f64; 2] = [768.0, 576.0];

/// A camera, and where a node has it.
pub(super) struct CameraNode<'a> {
    /// The node's, or else the camera's.
    pub name: &'a str,
    pub location: Location,
    pub camera: Entry<'a>,
    pub to_world: DMat4,
}

/// The camera of the `wanted` name or index, else the first that can be rendered; nothing when there is none.
///
/// # Errors
/// When the wanted one is not there, and on numbers that no camera can have.
pub(super) fn choose(
    cameras: &[CameraNode<'_>],
    wanted: Option<&str>,
    location: &Location,
    output: &mut Output,
) -> Result<Option<Draft>, SceneError> {
    let names: Vec<&str> = cameras.iter().map(|camera| camera.name).collect();
    let first = changes::choose(&names, wanted, location)?;
    let candidates = cameras.get(first..).unwrap_or_default();
    let mut sensor = None;
    for CameraNode { camera, to_world, location, .. } in if wanted.is_some() { &candidates[..1] } else { candidates } {
        if sensor.is_some() {
            output.notices.add(Notice::ignored(location, "a camera", "the first camera of the scene is used"));
        } else {
            sensor = read(camera, *to_world, output)?;
        }
    }
    Ok(sensor)
}

/// A camera at a node; nothing when it is not a perspective one, which is reported.
///
/// # Errors
/// On angles and aspect ratios that no camera can have.
fn read(camera: &Entry<'_>, to_world: DMat4, output: &mut Output) -> Result<Option<Draft>, SceneError> {
    let Some(lens) = camera.child("perspective")? else {
        let explanation = "only perspective cameras are supported";
        output.notices.add(Notice::ignored(&camera.location(), "an orthographic camera", explanation));
        return Ok(None);
    };
    let Some(angle) = lens.number("yfov")? else {
        return Err(lens.error("the camera has no \"yfov\"", "export the scene again"));
    };
    let mut sensor = Draft::new(PluginClass::Sensor, "perspective", &lens.location())
        .with("fov", Value::Float(angle.to_degrees()))
        .with("fov_axis", Value::String("y".to_owned()))
        .with("to_world", Value::Transform(to_world * DMat4::from_scale(HALF_TURN)));
    if let Some(near) = lens.number("znear")? {
        sensor = sensor.with("near_clip", Value::Float(near));
    }
    // Without a far plane glTF's camera sees to infinity.
    let sensor = sensor.with("far_clip", Value::Float(lens.number("zfar")?.unwrap_or(1e10)));
    Ok(Some(match lens.number("aspectRatio")? {
        None => sensor,
        Some(aspect) => sensor.with_child("", film(aspect, &lens)?),
    }))
}

/// The largest picture of an aspect ratio (width over height) that fits into the default one.
fn film(aspect: f64, lens: &Entry<'_>) -> Result<Draft, SceneError> {
    if !(aspect > 0.0 && aspect.is_finite()) {
        return Err(lens.error(format!("the aspectRatio is {}", shown_number(aspect)), "give width divided by height"));
    }
    let width = FILM[0].min(FILM[1] * aspect);
    let side = |pixels: f64| Value::Integer(pixels.round().max(1.0) as i64);
    let film = Draft::new(PluginClass::Film, "hdrfilm", &lens.location());
    Ok(film.with("width", side(width)).with("height", side(width / aspect)))
}

/// A camera that sees everything within `bounds`, from the front, a little from the right and above.
pub(super) fn framing(bounds: Option<[DVec3; 2]>, location: &Location, output: &mut Output) -> Draft {
    let explanation = "a camera that sees the whole scene takes its place";
    output.notices.add(Notice::approximated(location, "the missing camera", explanation));
    let [least, greatest] = bounds.unwrap_or([DVec3::ZERO; 2]);
    let center = 0.5 * least + 0.5 * greatest;
    let radius = (0.5 * greatest - 0.5 * least).length();
    let radius = if radius > 0.0 && radius.is_finite() { radius } else { 1.0 };
    const ANGLE: f64 = 40.0;
    let distance = 1.05 * radius / libm::sin((0.5 * ANGLE).to_radians());
    let origin = center + DVec3::new(0.4, 0.35, 1.0).normalize() * distance;
    let to_world = look_at(origin.to_array(), center.to_array(), [0.0, 1.0, 0.0]).unwrap_or(DMat4::IDENTITY);
    Draft::new(PluginClass::Sensor, "perspective", location)
        .with("fov", Value::Float(ANGLE))
        .with("fov_axis", Value::String("smaller".to_owned()))
        .with("near_clip", Value::Float(1e-3 * distance))
        .with("far_clip", Value::Float(10.0 * distance))
        .with("to_world", Value::Transform(to_world))
}
