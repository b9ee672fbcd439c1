//! A description in the native form: the JSON tree that [`mitsuba_json`](super::mitsuba_json) reads, and its files.
//!
//! Reading it back gives the same tree: numbers keep their bits, shared plugins stay shared by their ids.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use serde_json::{Map, Value as Json, json};

use super::pack::write_zip;
use super::{collect_file_names, plugins};
use crate::scene::bundle::{normalized_name, steps_up};
use crate::scene::description::{Child, Node, PluginClass, SceneDescription, Value};
use crate::scene::error::{Location, SceneError};

/// The name of the scene file in an archive.
const SCENE_FILE: &str = "scene.json";

/// The scene as JSON text.
///
/// # Errors
/// When the tree holds what JSON cannot: a number that is not finite, two parameters of one name, a parameter that is
/// called `type` or `id`, or a plugin that the native form does not know.
pub fn to_json(description: &SceneDescription) -> Result<String, SceneError> {
    let root = &description.root;
    let mut writer = Writer::new(root);
    let mut entries = writer.entries(root)?;
    for child in &root.children {
        let id = writer.ids[&address(&child.node)].clone();
        let value = writer.plugin(&child.node)?;
        insert(&mut entries, id, value, &child.node.location)?;
    }
    let text = serde_json::to_string_pretty(&entries).map_err(|error| {
        SceneError::new(&root.location, format!("the scene cannot be written as JSON: {error}"), "")
    })?;
    Ok(text + "\n")
}

/// The files that the scene refers to, by their names in it.
///
/// # Errors
/// When a file is missing, cannot be read, or has a name that leads out of the archive that the scene came in.
pub fn files(description: &SceneDescription) -> Result<BTreeMap<String, Arc<[u8]>>, SceneError> {
    let mut names = Vec::new();
    let mut seen = HashSet::new();
    collect_file_names(&description.root, &mut seen, &mut names);
    let mut files = BTreeMap::new();
    for (name, location) in names {
        files.insert(native_name(&normalized_name(&name, &location)?), description.bundle.read(&name, &location)?);
    }
    Ok(files)
}

/// The scene and its files as a zip archive that [`load_bytes`](super::load_bytes) reads.
///
/// # Errors
/// As [`to_json`] and [`files`]; when a file that the scene refers to is called `scene.json` itself.
pub fn to_zip(description: &SceneDescription) -> Result<Vec<u8>, SceneError> {
    let location = &description.root.location;
    let mut files = files(description)?;
    if files.insert(SCENE_FILE.to_owned(), to_json(description)?.into_bytes().into()).is_some() {
        let problem = format!("a file that the scene refers to is called {SCENE_FILE} itself");
        return Err(SceneError::new(location, problem, "give it another name"));
    }
    write_zip(&files, "")
        .map_err(|error| SceneError::new(location, format!("the scene cannot be packed: {error}"), "pack it by hand"))
}

/// The name of a file beside the native scene: files from above the scene's folder go into the folder `above`, and so on.
fn native_name(name: &str) -> String {
    let (above, inside) = steps_up(name);
    "above/".repeat(above) + inside
}

fn address(node: &Arc<Node>) -> *const Node {
    Arc::as_ptr(node)
}

fn insert(entries: &mut Map<String, Json>, key: String, value: Json, place: &Location) -> Result<(), SceneError> {
    if ["type", "id"].contains(&key.as_str()) {
        let problem = format!("\"{key}\" means something else in JSON than here");
        return Err(SceneError::new(place, problem, "give it another name"));
    }
    if entries.contains_key(&key) {
        return Err(SceneError::new(place, format!("\"{key}\" is given twice"), "give it once"));
    }
    entries.insert(key, value);
    Ok(())
}

struct Writer {
    /// The ids of plugins that need one: those directly in the scene, and those that several plugins hold.
    ids: HashMap<*const Node, String>,
    /// Plugins directly in the scene; anywhere else they are references.
    in_scene: HashSet<*const Node>,
    /// Shared plugins that have been written.
    written: HashSet<*const Node>,
}

impl Writer {
    fn new(root: &Node) -> Self {
        let mut holders = HashMap::new();
        let mut taken = HashSet::new();
        let mut order = Vec::new();
        count_holders(root, &mut holders, &mut taken, &mut order);
        let in_scene: HashSet<_> = root.children.iter().map(|child| address(&child.node)).collect();
        let mut ids = HashMap::new();
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for node in order {
            let shared = holders[&address(node)] > 1 || in_scene.contains(&address(node));
            if !node.id.is_empty() {
                ids.insert(address(node), node.id.clone());
            } else if shared {
                let count = counts.entry(node.class.tag()).or_default();
                let id = loop {
                    let id = format!("{}_{count}", node.class.tag());
                    *count += 1;
                    if taken.insert(id.clone()) {
                        break id;
                    }
                };
                ids.insert(address(node), id);
            }
        }
        Self { ids, in_scene, written: HashSet::new() }
    }

    /// A plugin as a dictionary, written in place.
    fn plugin(&mut self, node: &Arc<Node>) -> Result<Json, SceneError> {
        self.written.insert(address(node));
        let mut entries = self.entries(node)?;
        let mut counts: HashMap<PluginClass, usize> = HashMap::new();
        for child in &node.children {
            let key = if child.name.is_empty() { self.unnamed_slot(child, &mut counts) } else { child.name.clone() };
            let value = self.child(child)?;
            insert(&mut entries, key, value, &child.node.location)?;
        }
        Ok(Json::Object(entries))
    }

    /// `bsdf` for the first child of its class without a name, then `bsdf_1` and so on.
    fn unnamed_slot(&self, child: &Child, counts: &mut HashMap<PluginClass, usize>) -> String {
        let tag = child.node.class.tag();
        let count = counts.entry(child.node.class).or_default();
        *count += 1;
        if *count == 1 { tag.to_owned() } else { format!("{tag}_{}", *count - 1) }
    }

    fn child(&mut self, child: &Child) -> Result<Json, SceneError> {
        let node = &child.node;
        let elsewhere = self.in_scene.contains(&address(node)) || self.written.contains(&address(node));
        match self.ids.get(&address(node)) {
            Some(id) if elsewhere => Ok(json!({"type": "ref", "id": id})),
            _ => self.plugin(node),
        }
    }

    /// The type, the id and the parameters of a plugin.
    fn entries(&self, node: &Node) -> Result<Map<String, Json>, SceneError> {
        if plugins::class_of_plugin(&node.plugin) != Some(node.class) {
            let problem = format!("there is no {} \"{}\" in the native form", node.class.tag(), node.plugin);
            return Err(SceneError::new(&node.location, problem, "replace it in the scene"));
        }
        let mut entries = Map::new();
        entries.insert("type".to_owned(), node.plugin.as_str().into());
        // Directly in the scene the key is the id.
        let key = std::ptr::from_ref(node);
        if let Some(id) = self.ids.get(&key).filter(|_| !self.in_scene.contains(&key)) {
            entries.insert("id".to_owned(), id.as_str().into());
        }
        for parameter in &node.parameters {
            let value = match &parameter.value {
                Value::String(name) if parameter.name == "filename" && steps_up(name).0 > 0 => {
                    Some(native_name(name).into())
                }
                other => value(other),
            };
            let value = value.ok_or_else(|| {
                let problem = format!("\"{}\" is not finite, which JSON cannot hold", parameter.name);
                SceneError::new(&parameter.location, problem, "give finite numbers")
            })?;
            insert(&mut entries, parameter.name.clone(), value, &parameter.location)?;
        }
        Ok(entries)
    }
}

/// Every plugin below `node` once, in the order of the file, and how many plugins hold each.
fn count_holders<'a>(
    node: &'a Node,
    holders: &mut HashMap<*const Node, usize>,
    taken: &mut HashSet<String>,
    order: &mut Vec<&'a Arc<Node>>,
) {
    for child in &node.children {
        let count = holders.entry(address(&child.node)).or_insert(0);
        *count += 1;
        if *count == 1 {
            taken.insert(child.node.id.clone());
            order.push(&child.node);
            count_holders(&child.node, holders, taken, order);
        }
    }
}

/// A value as the JSON reader takes it; nothing when it is not finite.
fn value(value: &Value) -> Option<Json> {
    let numbers = |numbers: &[f64]| {
        let json = |number: &f64| serde_json::Number::from_f64(*number).map(Json::Number);
        numbers.iter().map(json).collect::<Option<Vec<Json>>>()
    };
    Some(match value {
        Value::Integer(number) => (*number).into(),
        Value::Float(number) => Json::Number(serde_json::Number::from_f64(*number)?),
        Value::Boolean(flag) => (*flag).into(),
        Value::String(text) => text.as_str().into(),
        Value::Rgb(rgb) => json!({"type": "rgb", "value": numbers(rgb)?}),
        Value::Vector(vector) => numbers(vector)?.into(),
        Value::Transform(matrix) => {
            let rows = matrix.transpose().to_cols_array();
            json!([{"matrix": numbers(&rows)?}])
        }
    })
}
