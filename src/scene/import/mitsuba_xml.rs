//! Mitsuba 3 scenes in XML.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::super::bundle::Bundle;
use super::super::description::{Parameter, PluginClass, Value};
use super::super::error::{Location, SceneError, nearest_name};
use super::draft::{Alias, Draft, DraftChild, Reading, Target};
use super::substitution::Parameters;
use super::values::{self, Refusal, shown};
use super::xml_element::{Attributes, File, step_matrix};
use super::{DEPTH_LIMIT, plugins};

/// How deep files may include files, as in Mitsuba.
const INCLUDE_DEPTH_LIMIT: usize = 15;
/// How many files a scene may include in all.
const INCLUDE_LIMIT: usize = 1000;

const VALUE_TAGS: [&str; 9] =
    ["integer", "float", "boolean", "string", "rgb", "spectrum", "point", "vector", "transform"];
const OTHER_TAGS: [&str; 4] = ["ref", "default", "include", "alias"];
const STEP_TAGS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];
/// Tags of Mitsuba that mean something photonfarm cannot do.
const UNSUPPORTED_TAGS: [&str; 5] = ["medium", "phase", "volume", "path", "animation"];

/// Reads a scene file and everything that it includes from `bundle`.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
) -> Result<Reading, SceneError> {
    let parameters = Parameters::new(defines);
    let mut reader = Reader { bundle, parameters, aliases: Vec::new(), includes: Vec::new(), open: Vec::new() };
    let text = File::text(bytes, location)?;
    let document = File::parse(text, location)?;
    let file = File::new(&location.file, text);
    let root = document.root_element();
    if root.tag_name().name() != "scene" {
        let problem = format!("the outermost tag is <{}>", root.tag_name().name());
        return Err(SceneError::new(&file.place(root, ""), problem, "put everything into <scene version=\"3.0.0\">"));
    }
    let mut scope = Scope::new(PluginClass::Scene, "scene", file.place(root, "scene"));
    reader.check_version(&file, root)?;
    reader.open.push(location.file.clone());
    reader.contents(&file, root, 0, &mut scope)?;
    reader.parameters.check_all_used(&scope.draft.location)?;
    let Reader { aliases, includes, .. } = reader;
    Ok(Reading { root: scope.draft, aliases, includes, notices: Vec::new() })
}

/// A plugin that is being read.
struct Scope {
    draft: Draft,
    /// How many children of each tag there have been, for their paths.
    counts: BTreeMap<String, usize>,
}

impl Scope {
    fn new(class: PluginClass, plugin: &str, location: Location) -> Self {
        let (parameters, children) = (Vec::new(), Vec::new());
        let draft = Draft { class, plugin: plugin.to_owned(), id: String::new(), parameters, children, location };
        Self { draft, counts: BTreeMap::new() }
    }

    /// The path of the next child with this tag, for example `scene/shape[3]`.
    fn path_of_next(&mut self, tag: &str) -> String {
        let count = self.counts.entry(tag.to_owned()).or_default();
        *count += 1;
        format!("{}/{tag}[{}]", self.draft.location.path, *count - 1)
    }
}

fn refused(place: &Location, tag: &str, (problem, remedy): Refusal) -> SceneError {
    SceneError::new(place, format!("<{tag}>: {problem}"), remedy)
}

struct Reader<'a> {
    bundle: &'a Bundle,
    parameters: Parameters,
    aliases: Vec<Alias>,
    includes: Vec<(String, Location)>,
    /// The files that are being read, each included by the one before.
    open: Vec<String>,
}

impl Reader<'_> {
    fn check_version(&mut self, file: &File<'_>, scene: Node<'_, '_>) -> Result<(), SceneError> {
        let place = file.place(scene, "scene");
        let attributes = self.attributes(file, scene, "scene", &["version"], &["id"])?;
        let version = attributes.text("version");
        match version.split('.').next().and_then(|major| major.trim().parse::<u32>().ok()) {
            Some(2..) => Ok(()),
            Some(_) => {
                let remedy = "convert it to Mitsuba 3, whose names are different (int_ior instead of intIOR)";
                Err(SceneError::new(&place, format!("the scene is written for Mitsuba {}", shown(version)), remedy))
            }
            None => {
                let problem = format!("{} is not a version", shown(version));
                Err(SceneError::new(&place, problem, "write version=\"3.0.0\""))
            }
        }
    }

    /// The attributes of `element`: all of `required`, perhaps some of `optional`, and no others.
    fn attributes<'n>(
        &mut self,
        file: &File<'_>,
        element: Node<'n, '_>,
        path: &str,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Attributes<'n>, SceneError> {
        let place = file.place(element, path);
        let tag = element.tag_name().name();
        let mut attributes = Vec::new();
        for attribute in element.attributes() {
            let name = attribute.name();
            if !required.contains(&name) && !optional.contains(&name) {
                let known: Vec<&str> = required.iter().chain(optional).copied().collect();
                let problem = format!("<{tag}> has no attribute {}", shown(name));
                return Err(SceneError::new(&place, problem, nearest_name(name, &known)));
            }
            attributes.push((name, self.parameters.substitute(attribute.value(), &place)?));
        }
        let attributes = Attributes(attributes);
        if let Some(missing) = required.iter().find(|name| attributes.get(name).is_none()) {
            return Err(SceneError::new(&place, format!("<{tag}> has no {missing}"), format!("write {missing}=\"…\"")));
        }
        Ok(attributes)
    }

    /// Reads everything inside `element` into `scope`.
    fn contents(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        depth: usize,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        for child in element.children() {
            if child.is_element() {
                self.child(file, child, depth + 1, scope)?;
            } else {
                self.refuse_text(file, child, &scope.draft.location.path)?;
            }
        }
        Ok(())
    }

    fn refuse_text(&self, file: &File<'_>, node: Node<'_, '_>, path: &str) -> Result<(), SceneError> {
        match node.text() {
            Some(text) if node.is_text() && !text.trim().is_empty() => {
                let problem = format!("there is text between the tags: {}", shown(text.trim()));
                Err(SceneError::new(&file.place(node, path), problem, "write values as attributes"))
            }
            _ => Ok(()),
        }
    }

    /// Fails when something stands inside an element that holds nothing.
    fn refuse_contents(&self, file: &File<'_>, element: Node<'_, '_>, path: &str) -> Result<(), SceneError> {
        match element.children().find(Node::is_element) {
            Some(child) => {
                let problem = format!("<{}> cannot hold a <{}>", element.tag_name().name(), child.tag_name().name());
                Err(SceneError::new(&file.place(child, path), problem, "move it out"))
            }
            None => element.children().try_for_each(|child| self.refuse_text(file, child, path)),
        }
    }

    fn child(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        depth: usize,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        let tag = element.tag_name().name();
        let place = file.place(element, scope.draft.location.path.as_str());
        if depth > DEPTH_LIMIT {
            let problem = format!("tags nest more than {DEPTH_LIMIT} deep");
            return Err(SceneError::new(&place, problem, "flatten the scene"));
        }
        match plugins::class_of_tag(tag) {
            Some(PluginClass::Scene) => Err(SceneError::new(&place, "a <scene> inside a scene", "use <include>")),
            Some(class) => self.plugin(file, element, depth, class, scope),
            None if tag == "transform" => self.transform(file, element, scope),
            None if VALUE_TAGS.contains(&tag) => self.value(file, element, scope),
            None if OTHER_TAGS.contains(&tag) => self.other(file, element, depth, scope),
            None => Err(unknown_tag(&place, tag)),
        }
    }

    fn plugin(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        depth: usize,
        class: PluginClass,
        parent: &mut Scope,
    ) -> Result<(), SceneError> {
        let path = parent.path_of_next(class.tag());
        let attributes = self.attributes(file, element, &path, &["type"], &["id", "name"])?;
        let location = file.place(element, path);
        let mut scope = Scope::new(class, attributes.text("type"), location.clone());
        if let Some(id) = attributes.get("id") {
            if id.is_empty() {
                return Err(SceneError::new(&location, "the id is empty", "give an id or leave it out"));
            }
            scope.draft.id = id.to_owned();
        }
        self.contents(file, element, depth, &mut scope)?;
        let name = attributes.get("name").unwrap_or_default().to_owned();
        parent.draft.children.push(DraftChild { name, target: Target::Plugin(scope.draft), location });
        Ok(())
    }

    fn value(&mut self, file: &File<'_>, element: Node<'_, '_>, scope: &mut Scope) -> Result<(), SceneError> {
        let tag = element.tag_name().name();
        let vector = ["point", "vector"].contains(&tag);
        let path = parameter_path(element, scope);
        let place = file.place(element, path.as_str());
        if tag == "spectrum" && (element.has_attribute("filename") || element.has_attribute("type")) {
            return Err(SceneError::new(&place, "spectra are not supported", values::SPECTRUM_REMEDY));
        }
        let (required, optional): (&[&str], &[&str]) =
            if vector { (&["name"], &["value", "x", "y", "z"]) } else { (&["name", "value"], &[]) };
        let attributes = self.attributes(file, element, &path, required, optional)?;
        self.refuse_contents(file, element, &path)?;
        let text = attributes.text("value");
        let value = match tag {
            "integer" => values::integer(text).map(Value::Integer),
            "float" => values::float(text).map(Value::Float),
            "boolean" => values::boolean(text).map(Value::Boolean),
            "rgb" => values::rgb(text),
            "spectrum" => values::spectrum(text),
            _ if vector => attributes.triple(0.0).map(Value::Vector),
            _ => Ok(Value::String(text.to_owned())),
        };
        let value = value.map_err(|refusal| refused(&place, tag, refusal))?;
        scope.draft.parameters.push(Parameter { name: attributes.text("name").to_owned(), value, location: place });
        Ok(())
    }

    fn transform(&mut self, file: &File<'_>, element: Node<'_, '_>, scope: &mut Scope) -> Result<(), SceneError> {
        let path = parameter_path(element, scope);
        let attributes = self.attributes(file, element, &path, &["name"], &[])?;
        let mut matrix = glam::DMat4::IDENTITY;
        for child in element.children() {
            if child.is_element() {
                matrix = self.step(file, child, &path)? * matrix;
            } else {
                self.refuse_text(file, child, &path)?;
            }
        }
        let (name, value) = (attributes.text("name").to_owned(), Value::Transform(matrix));
        scope.draft.parameters.push(Parameter { name, value, location: file.place(element, path) });
        Ok(())
    }

    fn step(&mut self, file: &File<'_>, element: Node<'_, '_>, path: &str) -> Result<glam::DMat4, SceneError> {
        let tag = element.tag_name().name();
        let place = file.place(element, path);
        let (required, optional): (&[&str], &[&str]) = match tag {
            "translate" | "scale" => (&[], &["value", "x", "y", "z"]),
            "rotate" => (&["angle"], &["value", "x", "y", "z"]),
            "lookat" => (&["origin", "target", "up"], &[]),
            "matrix" => (&["value"], &[]),
            _ => {
                let problem = format!("there is no transform step <{}>", tag.chars().take(60).collect::<String>());
                return Err(SceneError::new(&place, problem, nearest_name(tag, &STEP_TAGS)));
            }
        };
        let attributes = self.attributes(file, element, path, required, optional)?;
        self.refuse_contents(file, element, path)?;
        step_matrix(tag, &attributes).map_err(|refusal| refused(&place, tag, refusal))
    }

    fn other(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        depth: usize,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        let tag = element.tag_name().name();
        let path = if tag == "ref" { scope.path_of_next(tag) } else { scope.draft.location.path.clone() };
        let (required, optional): (&[&str], &[&str]) = match tag {
            "ref" => (&["id"], &["name"]),
            "default" => (&["name", "value"], &[]),
            "alias" => (&["id", "as"], &[]),
            _ => (&["filename"], &[]),
        };
        let attributes = self.attributes(file, element, &path, required, optional)?;
        self.refuse_contents(file, element, &path)?;
        let location = file.place(element, path);
        match tag {
            "ref" => {
                if scope.draft.class == PluginClass::Scene {
                    let remedy = "remove it, or move it into the plugin that is to use it";
                    return Err(SceneError::new(&location, "a <ref> directly in the scene has no effect", remedy));
                }
                let name = attributes.get("name").unwrap_or_default().to_owned();
                let target = Target::Reference(attributes.text("id").to_owned());
                scope.draft.children.push(DraftChild { name, target, location });
            }
            "default" => {
                self.parameters.set_default(attributes.text("name"), attributes.text("value"), &location)?;
            }
            "alias" => {
                let (known, other) = (attributes.text("id").to_owned(), attributes.text("as").to_owned());
                self.aliases.push(Alias { known, other, location });
            }
            _ => self.include(attributes.text("filename"), &location, depth, scope)?,
        }
        Ok(())
    }

    fn include(&mut self, name: &str, location: &Location, depth: usize, scope: &mut Scope) -> Result<(), SceneError> {
        if self.open.iter().any(|open| open == name) {
            let problem = format!("file \"{name}\" includes itself");
            return Err(SceneError::new(location, problem, "remove this <include>"));
        }
        if self.open.len() > INCLUDE_DEPTH_LIMIT {
            let problem = format!("files include files more than {INCLUDE_DEPTH_LIMIT} deep");
            return Err(SceneError::new(location, problem, "include the innermost files directly"));
        }
        if self.includes.len() >= INCLUDE_LIMIT {
            let problem = format!("the scene includes more than {INCLUDE_LIMIT} files");
            return Err(SceneError::new(location, problem, "merge some of them"));
        }
        let bytes = self.bundle.read(name, location)?;
        let start = Location { file: name.to_owned(), line: 0, path: location.path.clone() };
        let text = File::text(&bytes, &start)?;
        let document = File::parse(text, &start)?;
        let file = File::new(name, text);
        self.includes.push((name.to_owned(), location.clone()));
        self.open.push(name.to_owned());
        let root = document.root_element();
        if root.tag_name().name() == "scene" {
            self.check_version(&file, root)?;
            self.contents(&file, root, depth, scope)?;
        } else {
            self.child(&file, root, depth, scope)?;
        }
        self.open.pop();
        Ok(())
    }
}

/// The path of a parameter: its plugin's path and its name, if it has one.
fn parameter_path(element: Node<'_, '_>, scope: &Scope) -> String {
    let name = element.attribute("name").unwrap_or(element.tag_name().name());
    format!("{}/{name}", scope.draft.location.path)
}

fn unknown_tag(place: &Location, tag: &str) -> SceneError {
    let shown_tag: String = tag.chars().take(60).collect();
    if UNSUPPORTED_TAGS.contains(&tag) {
        return SceneError::new(place, format!("<{shown_tag}> is not supported"), "remove it");
    }
    if STEP_TAGS.contains(&tag) {
        let problem = format!("<{shown_tag}> stands outside of a transform");
        return SceneError::new(place, problem, "put it into <transform name=\"to_world\">");
    }
    let known: Vec<&str> = plugins::tags().chain(VALUE_TAGS).chain(OTHER_TAGS).collect();
    SceneError::new(place, format!("there is no tag <{shown_tag}>"), nearest_name(tag, &known))
}
