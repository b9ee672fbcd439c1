//! Participating media of Mitsuba 0.6.

use super::super::draft::{Draft, DraftChild, Target, extinction_and_albedo};
use super::{Outcome, Translation};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// Methods that render media there and not here, and methods that do not there either.
const MEDIA_THERE: [&str; 2] = ["bdpt", "photon_map"];
const NO_MEDIA: [&str; 3] = ["sppm", "ppm", "vcm"];

/// The slots of a shape that hold media.
pub(super) const BORDERS: [&str; 2] = ["interior", "exterior"];

/// `homogeneous`: absorption and scattering become extinction and albedo. A medium by the name of its material is passed through.
pub(super) fn homogeneous(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let mut coefficient = |name: &str| {
        Some(match draft.take(name)? {
            Value::Float(number) => [number; 3],
            Value::Integer(number) => [number as f64; 3],
            Value::Rgb(rgb) => rgb,
            _ => return None,
        })
    };
    if let (Some(absorption), Some(scattering)) = (coefficient("sigmaA"), coefficient("sigmaS")) {
        if absorption.iter().chain(&scattering).any(|number| *number < 0.0) {
            let problem = "\"sigmaA\" or \"sigmaS\" of the medium is below 0";
            return Err(SceneError::new(&draft.location, problem, "give numbers of at least 0"));
        }
        let [extinction, albedo] = extinction_and_albedo(absorption, scattering);
        draft.set_default("sigma_t", Value::Rgb(extinction));
        draft.set_default("albedo", Value::Rgb(albedo));
    }
    // Coefficients count before the name of a material.
    draft.take("material");
    if draft.has("sigma_t") && draft.has("albedo") {
        return Ok(Outcome::Plugin(draft));
    }
    let subject = "a medium without \"sigmaA\" and \"sigmaS\", or \"sigmaT\" and \"albedo\"";
    translation.ignored(&draft, subject, "measured media are not known by their names: light passes through");
    Ok(Outcome::Nothing)
}

/// `heterogeneous`: its density is the extinction.
pub(super) fn heterogeneous(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    // It chooses how Mitsuba samples.
    draft.take("method");
    for child in draft.children.iter_mut().filter(|child| child.name == "density") {
        "sigma_t".clone_into(&mut child.name);
    }
    let is_constant = |child: &DraftChild| {
        child.name == "sigma_t" && matches!(&child.target, Target::Plugin(plugin) if plugin.plugin == "constvolume")
    };
    if draft.children.iter().any(is_constant) {
        // Mitsuba 3 ends it at the unit cube.
        "homogeneous".clone_into(&mut draft.plugin);
        draft.id.clear();
        return Ok(Outcome::Instead(Target::Plugin(draft)));
    }
    if let Some(index) = draft.children.iter().position(|child| child.name == "orientation") {
        let child = draft.children.remove(index);
        let subject = "the \"orientation\" of a medium";
        translation.notices.push(Notice::ignored(&child.location, subject, "it scatters the same from all sides"));
    }
    Ok(Outcome::Plugin(draft))
}

/// A phase function without counterpart.
pub(super) fn phase(draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let subject = format!("phase function \"{}\"", draft.plugin);
    translation.approximated(&draft, subject, "\"isotropic\" takes its place");
    let plain = draft.beside(PluginClass::Phase, "isotropic");
    Ok(Outcome::Plugin(Draft { id: draft.id, ..plain }))
}

/// `gridvolume`: it fills the box that its file names.
pub(super) fn grid(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    draft.take("sendData");
    draft.set_default("use_grid_bbox", Value::Boolean(true));
    Ok(Outcome::Plugin(draft))
}

/// `volcache`: the volume inside it.
pub(super) fn cached(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    match draft.children.pop() {
        Some(inner) => Ok(Outcome::Instead(inner.target)),
        None => without_counterpart(draft, translation),
    }
}

/// A medium or a volume that nothing corresponds to: light passes through.
pub(super) fn without_counterpart(draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let subject = format!("{} \"{}\"", draft.class.tag(), draft.plugin);
    translation.ignored(&draft, subject, "it has no counterpart: light passes through unchanged");
    Ok(Outcome::Nothing)
}

/// Makes integrator and media agree as they do in Mitsuba 0.6, where more methods render media than here, and others pass through them.
pub(super) fn settle(root: &mut Draft, notices: &mut Vec<Notice>) {
    if !holds_media(root) {
        return;
    }
    let plugins = root.children.iter_mut().filter_map(|child| match &mut child.target {
        Target::Plugin(plugin) => Some(plugin),
        Target::Reference(_) => None,
    });
    let Some(integrator) = plugins.into_iter().find(|plugin| plugin.class == PluginClass::Integrator) else { return };
    let subject = format!("integrator \"{}\" in a scene with media", integrator.plugin);
    if MEDIA_THERE.contains(&integrator.plugin.as_str()) {
        notices.push(Notice::approximated(&integrator.location, subject, "a \"volpath\" takes its place"));
        "volpath".clone_into(&mut integrator.plugin);
    } else if NO_MEDIA.contains(&integrator.plugin.as_str()) {
        notices.push(Notice::ignored(
            &integrator.location,
            "the scene's media",
            format!("{subject} passes through them"),
        ));
        remove_media(root);
    }
}

fn holds_media(draft: &Draft) -> bool {
    draft.class == PluginClass::Medium
        || draft.children.iter().any(|child| matches!(&child.target, Target::Plugin(plugin) if holds_media(plugin)))
}

fn remove_media(draft: &mut Draft) {
    draft.children.retain(|child| match &child.target {
        Target::Plugin(plugin) => plugin.class != PluginClass::Medium,
        Target::Reference(_) => !BORDERS.contains(&child.name.as_str()),
    });
    for child in &mut draft.children {
        if let Target::Plugin(plugin) = &mut child.target {
            remove_media(plugin);
        }
    }
}
