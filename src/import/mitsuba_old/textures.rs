//! Textures of Mitsuba 0.6.

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::{Outcome, Translation};
use crate::scene::description::Value;
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// The parameters that [`bitmap`] reads.
pub(super) const BITMAP: &[&str] = &[
    "filterType",
    "wrapMode",
    "wrapModeU",
    "wrapModeV",
    "gamma",
    "channel",
    "coordinates",
    "uoffset",
    "voffset",
    "uscale",
    "vscale",
    "uvscale",
];

/// The parameters that [`uv`] reads.
pub(super) const UV: &[&str] = &["coordinates", "uoffset", "voffset", "uscale", "vscale", "uvscale"];

/// Any texture over uv coordinates: offsets and scales become one `to_uv`. A coordinate is scaled, then moved.
pub(super) fn uv(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    draft.take("coordinates");
    let both = draft.take_number("uvscale").unwrap_or(1.0);
    let [u, v] = ["uscale", "vscale"].map(|name| draft.take_number(name).unwrap_or(both));
    let [right, up] = ["uoffset", "voffset"].map(|name| draft.take_number(name).unwrap_or(0.0));
    if (u, v, right, up) != (1.0, 1.0, 0.0, 0.0) {
        let matrix = DMat4::from_translation(DVec3::new(right, up, 0.0)) * DMat4::from_scale(DVec3::new(u, v, 1.0));
        draft.set_default("to_uv", Value::Transform(matrix));
    }
    Ok(Outcome::Plugin(draft))
}

/// `checkerboard`: its numbers have the places of its colors.
pub(super) fn checkerboard(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    draft.state_plain_numbers();
    uv(draft, translation)
}

/// `bitmap`: the filter, the wrap mode and the gamma have other names and fewer values.
pub(super) fn bitmap(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let place = draft.location.clone();
    let mut ignored = |name: &str, text: &str, why: &str| {
        let subject = format!("parameter \"{name}\" ({text}) of texture \"bitmap\"");
        translation.notices.push(Notice::ignored(&place, subject, why));
    };
    match draft.take_text("filterType").as_deref() {
        Some("nearest") => draft.set_default("filter_type", Value::String("nearest".to_owned())),
        Some(name) if name != "ewa" && name != "trilinear" => ignored("filterType", name, "the filter is bilinear"),
        // Both are bilinear where a texture is magnified; elsewhere the pixel's samples average it.
        _ => {}
    }
    let both = draft.take_text("wrapMode").unwrap_or_else(|| "repeat".to_owned());
    let [u, v] = ["wrapModeU", "wrapModeV"].map(|name| draft.take_text(name).unwrap_or_else(|| both.clone()));
    if u != v {
        ignored("wrapModeV", &v, "both directions wrap as wrapModeU says");
    }
    match u.as_str() {
        "repeat" => {}
        "mirror" | "clamp" => draft.set_default("wrap_mode", Value::String(u)),
        _ => ignored("wrapMode", &u, "the texture is repeated"),
    }
    match draft.take_number("gamma") {
        None | Some(0.0) => {}
        Some(1.0) => draft.set_default("raw", Value::Boolean(true)),
        Some(-1.0) => draft.set_default("raw", Value::Boolean(false)),
        Some(gamma) => {
            draft.set_default("raw", Value::Boolean(false));
            ignored("gamma", &gamma.to_string(), "the texture is decoded as sRGB");
        }
    }
    if let Some(channel) = draft.take_text("channel").filter(|channel| !channel.is_empty()) {
        ignored("channel", &channel, "all channels are read");
    }
    uv(draft, translation)
}

/// `vertexcolors`: the colors of a mesh by the name that Mitsuba 3 gives them.
pub(super) fn vertex_colors(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    draft.set_default("name", Value::String("vertex_color".to_owned()));
    Ok(Outcome::Plugin(draft))
}

/// `gridtexture`: the color between the lines.
pub(super) fn grid(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    lines(&mut draft, "color0", 0.2, translation)
}

/// `wireframe`: the color between the lines.
pub(super) fn wireframe(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    lines(&mut draft, "interiorColor", 0.5, translation)
}

fn lines(draft: &mut Draft, between: &str, default: f64, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let color = draft.take(between).unwrap_or(Value::Rgb([default; 3]));
    translation.approximated(draft, "a texture of lines", "the color between the lines takes its place");
    Ok(Outcome::Value(color))
}

/// `curvature`: nothing measures it.
pub(super) fn grey(draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    translation.approximated(&draft, "texture \"curvature\"", "a grey of 0.5 takes its place");
    Ok(Outcome::Value(Value::Rgb([0.5; 3])))
}
