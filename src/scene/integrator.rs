//! `<integrator>`: which method the scene asks for, and with which parameters.
//!
//! | plugin | what is done with it |
//! |---|---|
//! | `moment`, `aov`, `stokes` | the integrator inside counts; moments, layers and polarisation are not rendered |
//! | `direct` | `max_depth` 2; `emitter_samples` or `bsdf_samples` of 0 leave out that kind of sampling, other counts change nothing but noise |
//! | `prb`, `prb_basic`, `prbvolpath` | `max_depth` 6 unless it is given |
//! | `path`, `direct`, `ptracer`, `prb`, `prb_basic` | the scene has no media: Mitsuba's know none. `volpath` renders them |
//! | all | `hide_emitters` belongs to the scene: every method keeps to it. `samples_per_pass`, `block_size` and `timeout` steer how Mitsuba works and change no picture |
//!
//! All other parameters go to the method, which takes or refuses them.

use serde_json::{Map, Value as Json};

use super::description::{Node, PluginClass, Value};
use super::error::SceneError;
use super::fields::Fields;
use super::notice::Notice;

/// The scene's `<integrator>`: plugin name and plain parameters.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Integrator {
    /// Plugin name, for example `sppm` or `path`.
    pub name: String,
    /// Parameters as JSON values.
    pub parameters: Map<String, Json>,
}

/// What an integrator node asks for.
#[derive(Default)]
pub(super) struct Asked {
    /// The method; none where the scene asks for layers alone.
    pub integrator: Option<Integrator>,
    /// Its `hide_emitters`.
    pub hides_lights: bool,
    /// Whether it passes through media as if there were none.
    pub ignores_media: bool,
    /// What is not done.
    pub notices: Vec<Notice>,
}

/// Integrators that hold another one, and what they make of its picture.
const WRAPPERS: [(&str, &str); 3] =
    [("moment", "second moments"), ("aov", "layers by an integrator"), ("stokes", "polarisation")];
/// Parameters of all integrators that change no picture.
const IGNORED: [&str; 3] = ["samples_per_pass", "block_size", "timeout"];
/// Integrators that know no media.
const WITHOUT_MEDIA: [&str; 5] = ["path", "direct", "ptracer", "prb", "prb_basic"];
/// Integrators that Mitsuba limits to 6 segments by default.
const LIMITED: [&str; 3] = ["prb", "prb_basic", "prbvolpath"];

/// Reads an integrator, and the one inside it.
///
/// # Errors
/// Parameters that are no plain values; a wrapper's that it does not have.
pub(super) fn read(node: &Node) -> Result<Asked, SceneError> {
    match WRAPPERS.iter().find(|(name, _)| *name == node.plugin) {
        Some((name, makes)) => read_wrapper(node, name, makes),
        None => read_plain(node),
    }
}

fn read_wrapper(node: &Node, name: &str, makes: &str) -> Result<Asked, SceneError> {
    let mut fields = Fields::new(node);
    let inner = fields.child(PluginClass::Integrator);
    let hides_lights = fields.boolean("hide_emitters")?.unwrap_or(false);
    fields.ignore(&IGNORED);
    if name == "aov" {
        fields.ignore(&["aovs"]);
    }
    fields.finish()?;
    let explanation = match inner {
        Some(inner) => format!("no {makes}: the picture is that of the \"{}\" inside", inner.plugin),
        None => format!("no {makes}: the default method renders the scene"),
    };
    let notice = Notice::ignored(&node.location, format!("integrator \"{name}\""), explanation);
    let inner = inner.map(|inner| read(inner)).transpose()?;
    let mut asked = inner.unwrap_or_default();
    asked.hides_lights |= hides_lights;
    asked.notices.insert(0, notice);
    Ok(asked)
}

fn read_plain(node: &Node) -> Result<Asked, SceneError> {
    let mut parameters = plain_parameters(node)?;
    let hides_lights = match parameters.remove("hide_emitters") {
        None => false,
        Some(Json::Bool(hides)) => hides,
        Some(_) => {
            let place = node.parameters.iter().find(|parameter| parameter.name == "hide_emitters");
            let place = place.map_or(&node.location, |parameter| &parameter.location);
            return Err(SceneError::new(place, "\"hide_emitters\" is no truth value", "write true or false"));
        }
    };
    for name in IGNORED {
        parameters.remove(name);
    }
    if node.plugin == "direct" {
        let samples = parameters.remove("shading_samples");
        let mut left_out = |count: &str| {
            let count = parameters.remove(count).or_else(|| samples.clone());
            count.is_some_and(|count| count == 0)
        };
        let (lights, materials) = (left_out("emitter_samples"), left_out("bsdf_samples"));
        for (name, is_left_out) in [("light_sampling", lights), ("material_sampling", materials)] {
            if is_left_out {
                parameters.insert(name.to_owned(), "off".into());
            }
        }
        parameters.insert("max_depth".to_owned(), 2.into());
    } else if LIMITED.contains(&node.plugin.as_str()) {
        parameters.entry("max_depth").or_insert_with(|| 6.into());
    }
    let ignores_media = WITHOUT_MEDIA.contains(&node.plugin.as_str());
    let integrator = Integrator { name: node.plugin.clone(), parameters };
    Ok(Asked { integrator: Some(integrator), hides_lights, ignores_media, notices: Vec::new() })
}

fn plain_parameters(node: &Node) -> Result<Map<String, Json>, SceneError> {
    let mut parameters = Map::new();
    for parameter in &node.parameters {
        let value = match &parameter.value {
            Value::Integer(number) => (*number).into(),
            Value::Float(number) => (*number).into(),
            Value::Boolean(flag) => (*flag).into(),
            Value::String(text) => text.as_str().into(),
            other => {
                let problem = format!("an integrator has no {} parameters", other.type_name());
                return Err(SceneError::new(&parameter.location, problem, "give a number, a boolean or a string"));
            }
        };
        parameters.insert(parameter.name.clone(), value);
    }
    Ok(parameters)
}
