//! Materials of Mitsuba 0.6 that are more than other names.

use super::super::draft::{Draft, DraftChild, Target};
use super::super::values;
use super::{Outcome, Translation};
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::SceneError;

/// The refractive index of air, Mitsuba 0.6's surroundings of metals.
const AIR: f64 = 1.000277;

/// `diffuse`, which takes its reflectance by two names.
pub(super) fn diffuse(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    for parameter in draft.parameters.iter_mut().filter(|parameter| parameter.name == "diffuseReflectance") {
        parameter.name = "reflectance".to_owned();
    }
    for child in draft.children.iter_mut().filter(|child| child.name == "diffuseReflectance") {
        child.name = "reflectance".to_owned();
    }
    Ok(Outcome::Plugin(draft))
}

/// `roughdiffuse`: an Oren-Nayar surface.
pub(super) fn rough_diffuse(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    draft.take("alpha");
    draft.take("useFastApprox");
    draft.children.retain(|child| child.name != "alpha");
    translation.approximated(&draft, "bsdf \"roughdiffuse\"", "a diffuse of the same reflectance takes its place");
    diffuse(draft, translation)
}

/// A material without a counterpart.
pub(super) fn stand_in(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    draft.parameters.clear();
    draft.children.clear();
    let subject = format!("bsdf \"{}\"", draft.plugin);
    translation.approximated(&draft, subject, "a diffuse grey of 0.5 takes its place");
    Ok(Outcome::Plugin(draft))
}

/// `bumpmap`: its texture needs no name.
pub(super) fn bump(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    draft.children.iter_mut().for_each(|child| child.name.clear());
    draft.state_plain_normals();
    Ok(Outcome::Plugin(draft))
}

/// `normalmap`: its texture has a name in Mitsuba 3.
pub(super) fn normal_map(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    let is_texture = |child: &DraftChild| match &child.target {
        Target::Plugin(plugin) => plugin.class == PluginClass::Texture,
        Target::Reference(_) => !child.name.is_empty(),
    };
    for child in draft.children.iter_mut().filter(|child| is_texture(child)) {
        child.name = "normalmap".to_owned();
    }
    draft.state_plain_normals();
    Ok(Outcome::Plugin(draft))
}

/// Roughness distributions: Phong's is left to Beckmann's of the same roughness.
pub(super) fn rough(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let mut phong = false;
    for parameter in draft.parameters.iter_mut().filter(|parameter| parameter.name == "distribution") {
        if let Value::String(name) = &mut parameter.value {
            phong = ["phong", "as"].contains(&name.as_str());
            *name = if phong { "beckmann".to_owned() } else { name.to_ascii_lowercase() };
        }
    }
    if phong {
        let explanation = "the distribution \"beckmann\" of the same alpha takes its place";
        translation.approximated(&draft, "the distribution \"phong\"", explanation);
    }
    Ok(Outcome::Plugin(draft))
}

/// `conductor` and `roughconductor`: copper by default, in air, with indices relative to vacuum.
pub(super) fn conductor(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let outside = match draft.take("extEta") {
        Some(Value::Float(index)) => index,
        Some(Value::Integer(index)) => index as f64,
        Some(Value::String(name)) => refractive_index(&name).unwrap_or(AIR),
        _ => AIR,
    };
    if !draft.has("eta") && !draft.has("k") {
        draft.set_default("material", Value::String("Cu".to_owned()));
        if (outside - AIR).abs() > 1e-3 {
            translation.ignored(&draft, "parameter \"extEta\"", "a metal by name is one in air");
        }
    }
    for parameter in draft.parameters.iter_mut().filter(|parameter| ["eta", "k"].contains(&parameter.name.as_str())) {
        match &mut parameter.value {
            Value::Rgb(rgb) if outside != 1.0 => rgb.iter_mut().for_each(|channel| *channel /= outside),
            Value::Float(number) if outside != 1.0 => *number /= outside,
            _ => {}
        }
    }
    rough(draft, translation)
}

fn refractive_index(name: &str) -> Option<f64> {
    use crate::scene::material::refractive_indices::REFRACTIVE_INDICES;
    let name = name.to_ascii_lowercase();
    REFRACTIVE_INDICES.iter().find(|(known, _)| *known == name).map(|(_, index)| f64::from(*index))
}

/// `phong`: cosⁿ about the mirror direction falls off as Ward's lobe of α = 1/√(2n) about the half vector.
pub(super) fn phong(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let exponent = match draft.take("exponent") {
        None => Some(30.0),
        Some(Value::Float(number)) => Some(number),
        Some(Value::Integer(number)) => Some(number as f64),
        Some(_) => None,
    };
    let Some(exponent) = exponent.filter(|exponent| *exponent > 0.0 && !draft.has("exponent")) else {
        let problem = "the \"exponent\" of a phong is not a number above 0";
        return Err(SceneError::new(&draft.location, problem, "give one number"));
    };
    let alpha = 1.0 / (2.0 * exponent).sqrt();
    draft.set_default("alpha", Value::Float(alpha));
    let explanation = format!("a ward with alpha {alpha:.4} takes its place");
    translation.approximated(&draft, "bsdf \"phong\"", explanation);
    Ok(Outcome::Plugin(draft))
}

/// `coating` and `roughcoating`: on a diffuse base it is a plastic; else the base alone stays.
pub(super) fn coating(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let base = draft.children.iter().position(|child| match &child.target {
        Target::Plugin(plugin) => plugin.class == PluginClass::Bsdf,
        Target::Reference(_) => child.name.is_empty(),
    });
    let Some(base) = base.map(|index| draft.children.remove(index).target) else {
        return Err(SceneError::new(&draft.location, "the coating has no bsdf inside", "nest the coated bsdf"));
    };
    let diffuse = match base {
        Target::Plugin(base) if base.plugin == "diffuse" => base,
        base => {
            let explanation = "the bsdf below takes its place";
            translation.approximated(&draft, "the coat on a bsdf that is not diffuse", explanation);
            return Ok(Outcome::Instead(base));
        }
    };
    for parameter in &mut draft.parameters {
        parameter.name = super::rules::new_name(&parameter.name);
    }
    for child in &mut draft.children {
        child.name = super::rules::new_name(&child.name);
    }
    let absorbs = draft.take("sigma_a").is_some_and(|value| value != Value::Rgb([0.0; 3]));
    draft.take("thickness");
    draft.children.retain(|child| child.name != "sigma_a");
    // A plastic's default is another index than a coat's.
    draft.set_default("int_ior", Value::String("bk7".to_owned()));
    let Draft { parameters, children, id, .. } = diffuse;
    if !id.is_empty() && draft.id.is_empty() {
        draft.id = id;
    }
    let renamed = |name: String| if name == "reflectance" { "diffuse_reflectance".to_owned() } else { name };
    draft.parameters.extend(parameters.into_iter().map(|own| Parameter { name: renamed(own.name), ..own }));
    draft.children.extend(children.into_iter().map(|own| DraftChild { name: renamed(own.name), ..own }));
    let loss = if absorbs { ", without absorption" } else { "" };
    translation.approximated(&draft, "the coat on a diffuse", format!("a plastic takes its place{loss}"));
    rough(draft, translation)
}

/// `mixturebsdf`: blends of two at a time, and with black for what the weights leave out.
pub(super) fn mixture(mut draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    let bad = |problem: String| SceneError::new(&draft.location, problem, "give one weight for each bsdf inside");
    let text = draft.parameters.iter().find(|parameter| parameter.name == "weights").map(|own| &own.value);
    let weights = match text {
        Some(Value::String(text)) => values::floats(&text.replace(';', " ")).map_err(|(problem, _)| bad(problem))?,
        Some(Value::Float(weight)) => vec![*weight],
        _ => Vec::new(),
    };
    let total: f64 = weights.iter().sum();
    if weights.len() != draft.children.len() || !(total > 0.0 && weights.iter().all(|weight| *weight >= 0.0)) {
        let problem = format!("mixturebsdf with {} bsdfs and weights {weights:?}", draft.children.len());
        return Err(bad(problem));
    }
    let children = std::mem::take(&mut draft.children);
    let mut parts: Vec<(Target, f64)> =
        children.into_iter().map(|child| child.target).zip(weights).filter(|(_, weight)| *weight > 0.0).collect();
    if total < 1.0 {
        let mut black = draft.beside(PluginClass::Bsdf, "diffuse");
        black.set_default("reflectance", Value::Rgb([0.0; 3]));
        parts.push((Target::Plugin(black), 1.0 - total));
    }
    Ok(blend(&draft, parts).map_or(Outcome::Nothing, Outcome::Instead))
}

/// Blends of halves, so that even many bsdfs do not nest deep.
fn blend(draft: &Draft, mut parts: Vec<(Target, f64)>) -> Option<Target> {
    if parts.len() < 2 {
        return parts.pop().map(|(target, _)| target);
    }
    let second = parts.split_off(parts.len().div_ceil(2));
    let weight = |parts: &[(Target, f64)]| parts.iter().map(|(_, weight)| weight).sum::<f64>();
    let share = weight(&second) / (weight(&parts) + weight(&second));
    let mut blend_of_both = draft.beside(PluginClass::Bsdf, "blendbsdf");
    blend_of_both.set_default("weight", Value::Float(share));
    for target in [blend(draft, parts)?, blend(draft, second)?] {
        let location = draft.location.clone();
        blend_of_both.children.push(DraftChild { name: String::new(), target, location });
    }
    Some(Target::Plugin(blend_of_both))
}
