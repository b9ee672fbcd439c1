//! Plugins that Mitsuba 0.6 itself does not have, but forks of it do: the nearest kind takes their place.

use super::super::draft::Draft;
use super::rules::new_name;
use super::{Outcome, RULES, Translation, light_and_shape, materials, media};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{SceneError, closest_name, nearest_name};

/// The parameters of Disney's material under the names that forks give them, and Mitsuba 3's `principled`'s.
const DISNEY: [(&str, &str); 13] = [
    ("baseColor", "base_color"),
    ("color", "base_color"),
    ("reflectance", "base_color"),
    ("diffuseReflectance", "base_color"),
    ("metallic", "metallic"),
    ("roughness", "roughness"),
    ("specular", "specular"),
    ("specularTint", "spec_tint"),
    ("anisotropic", "anisotropic"),
    ("sheen", "sheen"),
    ("sheenTint", "sheen_tint"),
    ("clearcoat", "clearcoat"),
    ("clearcoatGloss", "clearcoat_gloss"),
];

/// What takes the place of a plugin without a rule.
///
/// # Errors
/// When its name is close to one that Mitsuba 0.6 has: then it is a misspelling.
pub(super) fn translate(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    let known: Vec<&str> = RULES.iter().filter(|rule| rule.class == draft.class).map(|rule| rule.old).collect();
    let subject = format!("{} \"{}\"", draft.class.tag(), draft.plugin);
    let mut stand_in = |mut draft: Draft, plugin: &str| {
        translation.approximated(&draft, subject.as_str(), format!("a \"{plugin}\" takes its place"));
        draft.parameters.retain(|parameter| ["toWorld", "width", "height", "fov"].contains(&parameter.name.as_str()));
        draft.parameters.iter_mut().for_each(|parameter| parameter.name = new_name(&parameter.name));
        draft.plugin = plugin.to_owned();
        draft
    };
    match draft.class {
        _ if closest_name(&draft.plugin, known.iter().copied()).is_some() => Err(unknown(&draft, &known)),
        PluginClass::Integrator => {
            // The method is chosen where methods are known; whatever it takes of these counts.
            draft.children.clear();
            let plain = |value: &Value| !matches!(value, Value::Rgb(_) | Value::Vector(_) | Value::Transform(_));
            draft.parameters.retain(|parameter| plain(&parameter.value));
            draft.parameters.iter_mut().for_each(|parameter| parameter.name = new_name(&parameter.name));
            Ok(Outcome::Plugin(draft))
        }
        PluginClass::Bsdf if draft.plugin.starts_with("disney") || draft.plugin.starts_with("principled") => {
            disney(draft, translation)
        }
        PluginClass::Bsdf => {
            let Outcome::Plugin(mut draft) = materials::stand_in(draft, translation)? else {
                return Ok(Outcome::Nothing);
            };
            draft.plugin = "diffuse".to_owned();
            Ok(Outcome::Plugin(draft))
        }
        PluginClass::Sampler => Ok(Outcome::Plugin(stand_in(draft, "independent"))),
        PluginClass::ReconstructionFilter => Ok(Outcome::Plugin(stand_in(draft, "gaussian"))),
        PluginClass::Film => {
            let mut film = stand_in(draft, "hdrfilm");
            translation.children(&mut film)?;
            Ok(Outcome::Plugin(film))
        }
        PluginClass::Sensor => {
            let mut sensor = stand_in(draft, "perspective");
            translation.children(&mut sensor)?;
            Ok(Outcome::Plugin(sensor))
        }
        PluginClass::Shape | PluginClass::Emitter => light_and_shape::without_counterpart(draft, translation),
        PluginClass::Texture => {
            translation.approximated(&draft, subject, "a grey of 0.5 takes its place");
            Ok(Outcome::Value(Value::Rgb([0.5; 3])))
        }
        PluginClass::Phase => media::phase(draft, translation),
        PluginClass::Medium | PluginClass::Volume => media::without_counterpart(draft, translation),
        PluginClass::Scene => Err(unknown(&draft, &known)),
    }
}

fn unknown(draft: &Draft, known: &[&str]) -> SceneError {
    let problem = format!("Mitsuba 0.6 has no {} \"{}\"", draft.class.tag(), draft.plugin);
    SceneError::new(&draft.location, problem, nearest_name(&draft.plugin, known))
}

/// Disney's material as `principled`.
fn disney(mut draft: Draft, translation: &mut Translation) -> Result<Outcome, SceneError> {
    translation.approximated(&draft, format!("bsdf \"{}\"", draft.plugin), "a \"principled\" takes its place");
    let new = |name: &str| DISNEY.iter().find(|(old, _)| *old == name).map(|(_, new)| *new);
    for parameter in std::mem::take(&mut draft.parameters) {
        match new(&parameter.name) {
            Some(name) if !draft.has(name) => {
                draft.parameters.push(crate::scene::description::Parameter { name: name.to_owned(), ..parameter });
            }
            _ => {
                let subject = format!("parameter \"{}\" of bsdf \"{}\"", parameter.name, draft.plugin);
                translation.ignored(&draft, subject, "it has no counterpart");
            }
        }
    }
    draft.children.retain_mut(|child| match new(&child.name) {
        Some(name) => {
            child.name = name.to_owned();
            true
        }
        None => false,
    });
    translation.children(&mut draft)?;
    draft.plugin = "principled".to_owned();
    Ok(Outcome::Plugin(draft))
}
