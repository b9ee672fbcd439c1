//! The JSON of a glTF file, read by type; every error names the path of what is wrong.

use super::super::json_text::Json;
use crate::scene::bundle::without_byte_order_mark;
use crate::scene::error::{Location, SceneError, shown_number};

/// The longest JSON text that is read, bytes: the tree in memory takes many times its size.
const TEXT_LIMIT: usize = 64 << 20;

/// The most items of a list that are read; numbers are not counted.
const LIST_LIMIT: usize = 1_000_000;

/// The whole JSON of a file.
pub(super) struct Document {
    root: Json,
    location: Location,
}

impl Document {
    /// Parses the JSON of the file at `location`.
    ///
    /// # Errors
    /// On text that is not JSON, has more than 64 MiB, or is not an object; on lists of more than a million items.
    pub(super) fn parse(text: &[u8], location: &Location) -> Result<Self, SceneError> {
        if text.len() > TEXT_LIMIT {
            let problem = "the JSON of the file has more than 64 MiB";
            return Err(SceneError::new(location, problem, "keep meshes and images in files of their own, or use GLB"));
        }
        let text = without_byte_order_mark(text);
        let root: Json = serde_json::from_slice(text).map_err(|error| {
            let place = Location { line: error.line() as u32, ..location.clone() };
            SceneError::new(&place, format!("malformed JSON: {error}"), "export the scene again")
        })?;
        let document = Self { root, location: location.clone() };
        for key in document.root().object()?.keys() {
            if let Some(Entry { json: Json::Array(items), path, .. }) = document.root().get(key) {
                check_length(items.len(), &Location { path, ..location.clone() })?;
            }
        }
        Ok(document)
    }

    /// The outermost object.
    pub(super) fn root(&self) -> Entry<'_> {
        Entry { document: self, json: &self.root, path: String::new() }
    }

    /// How many items the list `list` of the file has.
    pub(super) fn count(&self, list: &str) -> usize {
        match self.root().get(list).map(|entry| entry.json) {
            Some(Json::Array(items)) => items.len(),
            _ => 0,
        }
    }

    /// Item `index` of the list `list` of the file; nothing when there is none.
    ///
    /// # Errors
    /// When it is not an object.
    pub(super) fn item(&self, list: &str, index: usize) -> Result<Option<Entry<'_>>, SceneError> {
        let Some(Json::Array(items)) = self.root().get(list).map(|entry| entry.json) else { return Ok(None) };
        let Some(json) = items.get(index) else { return Ok(None) };
        Entry { document: self, json, path: format!("{list}[{index}]") }.object().map(Some)
    }
}

fn check_length(length: usize, location: &Location) -> Result<(), SceneError> {
    if length <= LIST_LIMIT {
        return Ok(());
    }
    let problem = format!("the list has {length} items");
    Err(SceneError::new(location, problem, format!("split the scene: at most {LIST_LIMIT} are read")))
}

/// One value of the file, and where it stands.
#[derive(Clone)]
pub(super) struct Entry<'a> {
    document: &'a Document,
    json: &'a Json,
    path: String,
}

impl<'a> Entry<'a> {
    /// Where it stands: the file and the path, for example `meshes[2].primitives[0]`.
    pub(super) fn location(&self) -> Location {
        Location { path: self.path.clone(), ..self.document.location.clone() }
    }

    /// An error about this value.
    pub(super) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(&self.location(), problem, remedy)
    }

    fn kind_error(&self, wanted: &str) -> SceneError {
        self.error(format!("{} stands where {wanted} belongs", self.json.kind()), "export the scene again")
    }

    /// The value of `key`, of whatever type, if it is given.
    pub(super) fn get(&self, key: &str) -> Option<Entry<'a>> {
        let Json::Object(entries) = self.json else { return None };
        let json = entries.iter().find(|(known, _)| known == key).map(|(_, json)| json)?;
        Some(Entry { document: self.document, json, path: self.path_of(key) })
    }

    /// Whether `key` is given.
    pub(super) fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// The keys of an object.
    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> {
        let entries: &[(String, Json)] = if let Json::Object(entries) = self.json { entries } else { &[] };
        entries.iter().map(|(key, _)| key.as_str())
    }

    /// This value itself, if it is an object.
    fn object(self) -> Result<Self, SceneError> {
        if matches!(self.json, Json::Object(_)) { Ok(self) } else { Err(self.kind_error("an object")) }
    }

    /// The object `key`.
    pub(super) fn child(&self, key: &str) -> Result<Option<Entry<'a>>, SceneError> {
        self.get(key).map(Entry::object).transpose()
    }

    /// The object that extension `name` adds to this one.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Entry<'a>>, SceneError> {
        match self.child("extensions")? {
            Some(extensions) => extensions.child(name),
            None => Ok(None),
        }
    }

    /// A finite number.
    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, SceneError> {
        self.get(key).map(|entry| entry.as_number()).transpose()
    }

    /// A finite number from `least` to `most`, or `default` when it is not given.
    pub(super) fn number_within(&self, key: &str, default: f64, least: f64, most: f64) -> Result<f64, SceneError> {
        let Some(number) = self.number(key)? else { return Ok(default) };
        if (least..=most).contains(&number) {
            return Ok(number);
        }
        let remedy = match (least, most) {
            (least, f64::INFINITY) => format!("give at least {least}"),
            _ => format!("give a number from {least} to {most}"),
        };
        let place = Location { path: self.path_of(key), ..self.location() };
        Err(SceneError::new(&place, format!("\"{key}\" is {}", shown_number(number)), remedy))
    }

    fn as_number(&self) -> Result<f64, SceneError> {
        match self.json.number() {
            Some(number) if number.is_finite() => Ok(number),
            Some(_) => Err(self.error("the number is not finite", "give a finite number")),
            None => Err(self.kind_error("a number")),
        }
    }

    /// A list of `N` finite numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, SceneError> {
        let Some(entry) = self.get(key) else { return Ok(None) };
        let numbers = entry.json.numbers().ok_or_else(|| entry.kind_error(&format!("a list of {N} numbers")))?;
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(entry.error("a number is not finite", "give finite numbers"));
        }
        let count = numbers.len();
        <[f64; N]>::try_from(numbers)
            .map(Some)
            .map_err(|_| entry.error(format!("there are {count} numbers where {N} belong"), "export the scene again"))
    }

    /// A color: three finite numbers of at least 0.
    pub(super) fn color(&self, key: &str, default: [f64; 3]) -> Result<[f64; 3], SceneError> {
        let Some(color) = self.numbers(key)? else { return Ok(default) };
        if color.iter().all(|channel| *channel >= 0.0) {
            return Ok(color);
        }
        let place = Location { path: self.path_of(key), ..self.location() };
        Err(SceneError::new(&place, "a channel of the color is below 0", "give numbers of at least 0"))
    }

    /// A whole number of at least 0.
    pub(super) fn integer(&self, key: &str) -> Result<Option<usize>, SceneError> {
        self.get(key).map(|entry| entry.as_integer()).transpose()
    }

    /// A whole number of at least 0 that must be given.
    pub(super) fn required_integer(&self, key: &str) -> Result<usize, SceneError> {
        self.integer(key)?.ok_or_else(|| self.error(format!("there is no \"{key}\""), "export the scene again"))
    }

    fn as_integer(&self) -> Result<usize, SceneError> {
        let whole = match self.json {
            Json::Integer(number) => usize::try_from(*number).ok(),
            // Some exporters write every number with a decimal point.
            Json::Float(number) if number.fract() == 0.0 && (0.0..9e15).contains(number) => Some(*number as usize),
            _ => None,
        };
        whole.ok_or_else(|| self.kind_error("a whole number of at least 0"))
    }

    /// A string.
    pub(super) fn text(&self, key: &str) -> Result<Option<&'a str>, SceneError> {
        match self.get(key) {
            None => Ok(None),
            Some(Entry { json: Json::String(text), .. }) => Ok(Some(text)),
            Some(other) => Err(other.kind_error("a string")),
        }
    }

    /// A truth value; false when it is not given.
    pub(super) fn flag(&self, key: &str) -> Result<bool, SceneError> {
        match self.get(key) {
            None => Ok(false),
            Some(Entry { json: Json::Boolean(flag), .. }) => Ok(*flag),
            Some(other) => Err(other.kind_error("true or false")),
        }
    }

    fn list(&self, key: &str) -> Result<Vec<Entry<'a>>, SceneError> {
        let Some(list) = self.get(key) else { return Ok(Vec::new()) };
        let Json::Array(items) = list.json else { return Err(list.kind_error("a list")) };
        check_length(items.len(), &list.location())?;
        let item = |(index, json)| Entry { document: self.document, json, path: format!("{}[{index}]", list.path) };
        Ok(items.iter().enumerate().map(item).collect())
    }

    /// The objects of a list; none when it is not given.
    pub(super) fn objects(&self, key: &str) -> Result<Vec<Entry<'a>>, SceneError> {
        self.list(key)?.into_iter().map(Entry::object).collect()
    }

    /// The strings of a list, each with its place; none when it is not given.
    pub(super) fn texts(&self, key: &str) -> Result<Vec<(&'a str, Entry<'a>)>, SceneError> {
        let text = |entry: Entry<'a>| match entry.json {
            Json::String(text) => Ok((text.as_str(), entry)),
            _ => Err(entry.kind_error("a string")),
        };
        self.list(key)?.into_iter().map(text).collect()
    }

    /// The item of the file's list `list` whose index stands at `key`.
    pub(super) fn reference(&self, key: &str, list: &str) -> Result<Option<(usize, Entry<'a>)>, SceneError> {
        self.get(key).map(|entry| entry.as_reference(list)).transpose()
    }

    /// The items of the file's list `list` whose indices are listed at `key`.
    pub(super) fn references(&self, key: &str, list: &str) -> Result<Vec<(usize, Entry<'a>)>, SceneError> {
        self.list(key)?.into_iter().map(|entry| entry.as_reference(list)).collect()
    }

    fn as_reference(&self, list: &str) -> Result<(usize, Entry<'a>), SceneError> {
        let index = self.as_integer()?;
        match self.document.item(list, index)? {
            Some(item) => Ok((index, item)),
            None => {
                let problem = format!("there is no {list}[{index}]: the file has {} {list}", self.document.count(list));
                Err(self.error(problem, "export the scene again"))
            }
        }
    }
}
