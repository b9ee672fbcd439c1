//! Mitsuba 3 scenes as JSON: the dictionary that `mi.load_dict` takes, with transforms as lists of steps.

use glam::DMat4;

use super::draft::{Draft, DraftChild, Target};
use super::json_text::Json;
use super::spectra::{self, Purpose};
use super::substitution::refuse_defines;
use super::values::{self, shown};
use super::{DEPTH_LIMIT, plugins, transform};
use crate::scene::bundle::without_byte_order_mark;
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::{Location, SceneError, nearest_name};

type Dictionary = [(String, Json)];

const STEPS: [&str; 5] = ["translate", "rotate", "scale", "look_at", "matrix"];

/// Reads a scene file. JSON has no `$names`, so every define is an error.
pub(super) fn read(bytes: &[u8], location: &Location, defines: &[(String, String)]) -> Result<Draft, SceneError> {
    refuse_defines(defines, location, "a JSON scene has no parameters: write the value into it")?;
    let bytes = without_byte_order_mark(bytes);
    let root: Json = serde_json::from_slice(bytes).map_err(|error| {
        let place = Location { line: error.line() as u32, ..location.clone() };
        SceneError::new(&place, format!("malformed JSON: {error}"), "")
    })?;
    let place = Location { path: "scene".to_owned(), ..location.clone() };
    let Json::Object(entries) = &root else {
        return Err(SceneError::new(&place, "the scene is not a dictionary", "write {\"type\": \"scene\", …}"));
    };
    let plugin = type_of(entries, &place)?;
    if plugin != "scene" {
        let problem = format!("the outermost dictionary has the type {}", shown(plugin));
        return Err(SceneError::new(&place, problem, "put everything into {\"type\": \"scene\", …}"));
    }
    draft(entries, PluginClass::Scene, plugin, place, 0)
}

fn below(place: &Location, key: &str) -> Location {
    // Cut, since the path of everything inside repeats a key.
    let key: String = key.chars().take(80).collect();
    Location { path: format!("{}/{key}", place.path), ..place.clone() }
}

fn entry<'a>(entries: &'a Dictionary, key: &str) -> Option<&'a Json> {
    entries.iter().find(|(known, _)| known == key).map(|(_, value)| value)
}

fn type_of<'a>(entries: &'a Dictionary, place: &Location) -> Result<&'a str, SceneError> {
    match entry(entries, "type") {
        Some(Json::String(plugin)) => Ok(plugin),
        Some(other) => {
            let problem = format!("the type is {}", other.kind());
            Err(SceneError::new(place, problem, "give the name of a plugin as a string"))
        }
        None => {
            let remedy = "every dictionary needs one; a transform is a list of dictionaries such as [{\"translate\": [0, 1, 0]}]";
            Err(SceneError::new(place, "the dictionary has no \"type\"", remedy))
        }
    }
}

fn string<'a>(entries: &'a Dictionary, key: &str, place: &Location) -> Result<Option<&'a str>, SceneError> {
    match entry(entries, key) {
        None => Ok(None),
        Some(Json::String(text)) if !text.is_empty() => Ok(Some(text)),
        Some(_) => Err(SceneError::new(place, format!("\"{key}\" is not a name"), "write it as a string")),
    }
}

fn only_keys(entries: &Dictionary, known: &[&str], place: &Location) -> Result<(), SceneError> {
    match entries.iter().find(|(key, _)| !known.contains(&key.as_str())) {
        None => Ok(()),
        Some((key, _)) => {
            Err(SceneError::new(place, format!("{} does not belong here", shown(key)), nearest_name(key, known)))
        }
    }
}

fn draft(
    entries: &Dictionary,
    class: PluginClass,
    plugin: &str,
    location: Location,
    depth: usize,
) -> Result<Draft, SceneError> {
    if depth > DEPTH_LIMIT {
        let problem = format!("plugins nest more than {DEPTH_LIMIT} deep");
        return Err(SceneError::new(&location, problem, "flatten the scene"));
    }
    let id = string(entries, "id", &location)?.unwrap_or_default().to_owned();
    let mut draft = Draft { id, ..Draft::new(class, plugin, &location) };
    for (key, value) in entries.iter().filter(|(key, _)| key != "type" && key != "id") {
        let place = below(&draft.location, key);
        match value {
            Json::Object(entries) => dictionary(key, entries, place, depth, &mut draft)?,
            _ => {
                let value = plain_value(value, &place)?;
                draft.parameters.push(Parameter { name: key.clone(), value, location: place });
            }
        }
    }
    Ok(draft)
}

/// A dictionary inside of a plugin: a color, a reference, or a plugin.
fn dictionary(
    key: &str,
    entries: &Dictionary,
    place: Location,
    depth: usize,
    parent: &mut Draft,
) -> Result<(), SceneError> {
    let in_scene = parent.class == PluginClass::Scene;
    // A key that only says what the value is, as in {"bsdf": …}, names no slot. In the scene itself it is the id.
    let name = if in_scene || says_only_class(key) { String::new() } else { key.to_owned() };
    let plugin = type_of(entries, &place)?;
    match (plugin, plugins::class_of_plugin(plugin)) {
        ("rgb" | "spectrum", _) => {
            let value = color(plugin, entries, Purpose::of(parent.class, key), &place)?;
            parent.parameters.push(Parameter { name: key.to_owned(), value, location: place });
        }
        (plugin, _) if spectra::PLUGINS.contains(&plugin) && !in_scene => {
            let spectrum = draft(entries, PluginClass::Texture, plugin, place.clone(), depth + 1)?;
            let rgb = spectra::of_plugin(&spectrum, Purpose::of(parent.class, key))?;
            if spectra::stays_texture(parent) {
                let texture = Draft::new(PluginClass::Texture, "rawconstant", &place).with_rgb("value", rgb);
                parent.children.push(DraftChild { name, target: Target::Plugin(texture), location: place });
            } else {
                parent.parameters.push(Parameter { name: key.to_owned(), value: Value::Rgb(rgb), location: place });
            }
        }
        ("ref", _) if in_scene => {
            let remedy = "remove it, or move it into the plugin that is to use it";
            return Err(SceneError::new(&place, "a reference directly in the scene has no effect", remedy));
        }
        ("ref", _) => {
            only_keys(entries, &["type", "id"], &place)?;
            let Some(id) = string(entries, "id", &place)? else {
                return Err(SceneError::new(&place, "the reference has no \"id\"", "write \"id\": \"…\""));
            };
            parent.children.push(DraftChild { name, target: Target::Reference(id.to_owned()), location: place });
        }
        (_, Some(PluginClass::Scene)) => {
            return Err(SceneError::new(&place, "a scene inside a scene", "merge the dictionaries"));
        }
        (_, Some(class)) => {
            let mut child = draft(entries, class, plugin, place.clone(), depth + 1)?;
            if in_scene && child.id.is_empty() {
                child.id = key.to_owned();
            }
            parent.children.push(DraftChild { name, target: Target::Plugin(child), location: place });
        }
        (_, None) => return Err(unknown_type(plugin, &place)),
    }
    Ok(())
}

/// Whether a key is the name of a class, as `bsdf`, or that with a number, as `bsdf_1`.
fn says_only_class(key: &str) -> bool {
    let class = match key.rsplit_once('_') {
        Some((class, number)) if number.parse::<u32>().is_ok() => class,
        _ => key,
    };
    plugins::class_of_tag(class).is_some()
}

fn unknown_type(plugin: &str, place: &Location) -> SceneError {
    let known: Vec<&str> = plugins::names().chain(["rgb", "spectrum", "ref"]).collect();
    SceneError::new(place, format!("there is no type {}", shown(plugin)), nearest_name(plugin, &known))
}

fn color(kind: &str, entries: &Dictionary, purpose: Purpose, place: &Location) -> Result<Value, SceneError> {
    only_keys(entries, &["type", "value"], place)?;
    let value = entry(entries, "value");
    let numbers = value.and_then(|value| value.number().map(|grey| vec![grey]).or_else(|| value.numbers()));
    match (kind, numbers.as_deref(), value) {
        ("rgb", Some(numbers), _) if values::spread(numbers).is_some() => {
            Ok(Value::Rgb(values::spread(numbers).unwrap_or_default()))
        }
        ("rgb", None, Some(Json::String(text))) => {
            values::rgb(text).map_err(|(problem, remedy)| SceneError::new(place, problem, remedy))
        }
        ("spectrum", Some([number]), _) => Ok(Value::Rgb(spectra::of_number(*number, purpose))),
        ("spectrum", _, Some(Json::Array(points))) => {
            let numbers: Option<Vec<Vec<f64>>> =
                points.iter().map(|point| point.numbers().filter(|pair| pair.len() == 2)).collect();
            let refusal = || ("the spectrum is no list of pairs".to_owned(), "write [[400, 0.5], [700, 0.8]]");
            let found = numbers.ok_or_else(refusal).and_then(|pairs| spectra::of_pairs(&pairs.concat(), purpose));
            found.map(Value::Rgb).map_err(|(problem, remedy)| SceneError::new(place, problem, remedy))
        }
        _ => Err(SceneError::new(place, "the rgb has no color", "write \"value\": [red, green, blue] or one number")),
    }
}

fn plain_value(value: &Json, place: &Location) -> Result<Value, SceneError> {
    match value {
        Json::Boolean(flag) => Ok(Value::Boolean(*flag)),
        Json::Integer(number) => Ok(Value::Integer(*number)),
        Json::Float(number) => Ok(Value::Float(*number)),
        Json::String(text) => Ok(Value::String(text.clone())),
        Json::Array(items) if items.iter().all(|item| matches!(item, Json::Object(_))) => steps(items, place),
        Json::Array(_) => match value.numbers().as_deref() {
            Some([x, y, z]) => Ok(Value::Vector([*x, *y, *z])),
            _ => {
                let remedy = "write [x, y, z] for a point or vector, or a list of steps for a transform";
                Err(SceneError::new(place, "the list is neither three numbers nor transform steps", remedy))
            }
        },
        Json::Null | Json::Object(_) => {
            Err(SceneError::new(place, format!("the value is {}", value.kind()), "give a value or remove the key"))
        }
    }
}

/// The product of a list of steps, each applied after the one before.
fn steps(items: &[Json], place: &Location) -> Result<Value, SceneError> {
    let mut matrix = DMat4::IDENTITY;
    for (index, item) in items.iter().enumerate() {
        let place = below(place, &index.to_string());
        let Json::Object(entries) = item else { continue };
        let [(name, argument)] = entries.as_slice() else {
            let problem = format!("a transform step with {} keys", entries.len());
            return Err(SceneError::new(&place, problem, "write one step per dictionary: {\"translate\": [0, 1, 0]}"));
        };
        let after = step(name, argument).map_err(|(problem, remedy)| SceneError::new(&place, problem, remedy))?;
        // A matrix alone keeps its bits: multiplying it would turn -0 into 0.
        matrix = if items.len() == 1 && name == "matrix" { after } else { after * matrix };
    }
    Ok(Value::Transform(matrix))
}

/// The problem and the remedy of a step that cannot be read.
type Refusal = (String, String);

fn step(name: &str, argument: &Json) -> Result<DMat4, Refusal> {
    match name {
        "translate" => three(name, Some(argument)).map(transform::translate),
        "scale" => match argument.number() {
            Some(factor) => Ok(transform::scale([factor; 3])),
            None => three(name, Some(argument)).map(transform::scale),
        },
        "rotate" => {
            let entries = arguments(name, argument, &["axis", "angle"])?;
            let Some(angle) = entry(entries, "angle").and_then(Json::number) else {
                return Err(("rotate has no angle".to_owned(), "write \"angle\": degrees".to_owned()));
            };
            transform::rotate(three("axis", entry(entries, "axis"))?, angle).map_err(impossible)
        }
        "look_at" => {
            let entries = arguments(name, argument, &["origin", "target", "up"])?;
            let [origin, target, up] = ["origin", "target", "up"].map(|key| three(key, entry(entries, key)));
            transform::look_at(origin?, target?, up?).map_err(impossible)
        }
        "matrix" => {
            let rows = argument.numbers().or_else(|| match argument {
                Json::Array(rows) => {
                    rows.iter().map(Json::numbers).collect::<Option<Vec<_>>>().map(|rows| rows.concat())
                }
                _ => None,
            });
            let remedy = || "give four rows of four numbers, or 16 numbers row by row".to_owned();
            let rows = rows.ok_or_else(|| ("the matrix is not a list of numbers".to_owned(), remedy()))?;
            transform::matrix(&rows).map_err(|problem| (problem, remedy()))
        }
        _ => Err((format!("there is no transform step {}", shown(name)), nearest_name(name, &STEPS))),
    }
}

fn impossible(problem: String) -> Refusal {
    (problem, "change the numbers".to_owned())
}

fn three(name: &str, value: Option<&Json>) -> Result<[f64; 3], Refusal> {
    match value.and_then(Json::numbers).as_deref() {
        Some([x, y, z]) => Ok([*x, *y, *z]),
        _ => Err((format!("{name} is not three numbers"), format!("write \"{name}\": [x, y, z]"))),
    }
}

fn arguments<'a>(step: &str, value: &'a Json, known: &[&str]) -> Result<&'a Dictionary, Refusal> {
    let Json::Object(entries) = value else {
        let problem = format!("{step} takes a dictionary, not {}", value.kind());
        return Err((problem, format!("give it {}", known.join(", "))));
    };
    match entries.iter().find(|(key, _)| !known.contains(&key.as_str())) {
        Some((key, _)) => Err((format!("{step} has no {}", shown(key)), nearest_name(key, known))),
        None => Ok(entries),
    }
}
