//! The tags of Mitsuba's XML that stand for no plugin.

use super::plugins;
use crate::scene::error::{Location, SceneError, nearest_name};

/// Tags of values.
pub(super) const VALUE_TAGS: [&str; 9] =
    ["integer", "float", "boolean", "string", "rgb", "spectrum", "point", "vector", "transform"];
/// Tags that are neither values nor plugins.
pub(super) const OTHER_TAGS: [&str; 5] = ["ref", "default", "include", "alias", "path"];
/// The steps of a transform.
pub(super) const STEP_TAGS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];
/// Says that a tag cannot be read.
pub(super) fn unknown_tag(place: &Location, tag: &str) -> SceneError {
    let shown_tag: String = tag.chars().take(60).collect();
    if STEP_TAGS.contains(&tag) {
        let problem = format!("<{shown_tag}> stands outside of a transform");
        return SceneError::new(place, problem, "put it into <transform name=\"to_world\">");
    }
    let known: Vec<&str> = plugins::tags().chain(VALUE_TAGS).chain(OTHER_TAGS).collect();
    SceneError::new(place, format!("there is no tag <{shown_tag}>"), nearest_name(tag, &known))
}
