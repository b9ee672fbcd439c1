//! Shapes and emitters of Mitsuba 0.6 that are more than other names.

use glam::DMat4;

use super::super::draft::{Draft, Target};
use super::{Outcome, Translation};
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::SceneError;

/// A shape: without a bsdf it is black where it emits, and nothing but a border where it holds a medium.
pub(super) fn shape(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    // Also where the medium itself is left out.
    let medium = translation.media.contains(&draft.location.path);
    let is = |class: PluginClass| {
        draft.children.iter().any(|child| matches!(&child.target, Target::Plugin(plugin) if plugin.class == class))
    };
    let referring = draft.children.iter().any(|child| child.is_reference() && child.name.is_empty());
    let emits = is(PluginClass::Emitter);
    if !is(PluginClass::Bsdf) && !referring && (emits || medium) {
        let mut bsdf = draft.beside(PluginClass::Bsdf, if emits { "diffuse" } else { "null" });
        if emits {
            bsdf.set_default("reflectance", Value::Rgb([0.0; 3]));
        }
        draft.push_plugin(bsdf);
    }
    Ok(Outcome::Plugin(draft))
}

/// `sunsky`: y is up there, z here; its radiances are of other units and of an older model.
pub(super) fn sun_sky(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    translation.approximated(&draft, "emitter \"sunsky\"", "Hosek & Wilkie's sky in Mitsuba 3's units takes its place");
    stand_up(&mut draft);
    Ok(Outcome::Plugin(draft))
}

/// Turns z to where y is.
fn stand_up(draft: &mut Draft) {
    let upright = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    match draft.parameters.iter_mut().find(|parameter| parameter.name == "to_world") {
        Some(Parameter { value: Value::Transform(matrix), .. }) => *matrix *= upright,
        _ => draft.set_default("to_world", Value::Transform(upright)),
    }
}

/// `sky`: the sky of a `sunsky` alone.
pub(super) fn sky(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    draft.set_default("sun_scale", Value::Float(0.0));
    translation.approximated(&draft, "emitter \"sky\"", "a sunsky without its sun takes its place");
    stand_up(&mut draft);
    Ok(Outcome::Plugin(draft))
}

/// `sun`: the sun of a `sunsky` alone.
pub(super) fn sun(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    draft.set_default("sky_scale", Value::Float(0.0));
    translation.approximated(&draft, "emitter \"sun\"", "a sunsky without its sky takes its place");
    stand_up(&mut draft);
    Ok(Outcome::Plugin(draft))
}

/// A shape or an emitter that nothing corresponds to.
pub(super) fn without_counterpart(draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let subject = format!("{} \"{}\"", draft.class.tag(), draft.plugin);
    translation.ignored(&draft, subject, "it has no counterpart: the scene is rendered without it");
    Ok(Outcome::Nothing)
}
