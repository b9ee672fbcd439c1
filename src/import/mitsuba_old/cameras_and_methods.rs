//! Sensors, films, samplers and integrators of Mitsuba 0.6.

use super::super::draft::{Draft, Target};
use super::{Outcome, Translation};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{SceneError, shown_number};

/// `ldrfilm`: pictures are linear here, and PNG files are sRGB whatever the film says.
pub(super) fn tone_mapped_film(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let explanation = "an hdrfilm takes its place: EXR files are linear, PNG files sRGB";
    translation.approximated(&draft, "film \"ldrfilm\"", explanation);
    let reinhard = draft.take_text("tonemapMethod").is_some_and(|method| method == "reinhard");
    let exposure = draft.take_number("exposure").unwrap_or(0.0);
    if reinhard {
        translation.ignored(&draft, "Reinhard's tone mapping", "PNG files are not tone mapped");
    } else if exposure != 0.0 {
        let remedy = format!("PNG files are written with it by --exposure {}", shown_number(exposure));
        translation.ignored(&draft, format!("the exposure of {} stops", shown_number(exposure)), remedy);
    }
    for name in ["gamma", "key", "burn"] {
        draft.take(name);
    }
    Ok(Outcome::Plugin(draft))
}

/// `perspective_rdist`: a lens that distorts.
pub(super) fn without_distortion(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    if draft.take("kc").is_some() {
        translation.ignored(&draft, "the radial distortion \"kc\"", "the camera is a perspective one");
    }
    Ok(Outcome::Plugin(draft))
}

/// `sppm` and `ppm`, whose defaults differ from ours.
pub(super) fn photons(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    draft.set_default("alpha", Value::Float(0.7));
    draft.set_default("photons_per_pass", Value::Integer(250_000));
    draft.set_default("rr_depth", Value::Integer(3));
    // 0 means that Mitsuba chooses one, -1 that it never stops.
    if let Some(radius) = draft.take_number("initialRadius").filter(|radius| *radius != 0.0) {
        draft.set_default("initial_radius", Value::Float(radius));
    }
    draft.parameters.retain(|parameter| !(parameter.name == "passes" && parameter.value == Value::Integer(-1)));
    Ok(Outcome::Plugin(draft))
}

/// A method that has no counterpart, for which another one takes its place that finds the same light.
pub(super) fn other_method(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    draft.take("shadowMapResolution");
    draft.take("clamping");
    let subject = format!("integrator \"{}\"", draft.plugin);
    translation.approximated(&draft, subject, "a method that finds the same light takes its place");
    Ok(Outcome::Plugin(draft))
}

/// A method that wraps another one: the inner one.
pub(super) fn inner_method(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let is_method = |target: &Target| match target {
        Target::Plugin(plugin) => plugin.class == PluginClass::Integrator,
        Target::Reference(_) => true,
    };
    let inner = draft.children.iter().position(|child| is_method(&child.target));
    let Some(inner) = inner.map(|index| draft.children.remove(index).target) else {
        return no_method(draft, translation);
    };
    let subject = format!("integrator \"{}\"", draft.plugin);
    translation.approximated(&draft, subject, "the one inside takes its place");
    Ok(Outcome::Instead(inner))
}

/// An integrator that computes something else than pictures of light.
pub(super) fn no_method(draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let subject = format!("integrator \"{}\"", draft.plugin);
    translation.ignored(&draft, subject, "it has no counterpart: the default method renders the scene");
    Ok(Outcome::Nothing)
}
