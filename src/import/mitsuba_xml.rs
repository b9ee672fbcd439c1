//! Mitsuba scenes in XML: those of Mitsuba 3, and with [`mitsuba_old`] those of Mitsuba 0.6 and before.

mod animation;
mod files;
mod spectral;

use std::collections::BTreeMap;

use glam::DMat4;
use roxmltree::Node;

use super::draft::{Alias, Draft, DraftChild, Reading, Target};
use super::mitsuba_old::{self, Old, Version};
use super::motion::Motion;
use super::spectra::{self, Purpose};
use super::substitution::Parameters;
use super::values::{self, Refusal, shown};
use super::xml_element::{Attributes, File, notice_of_axis, step_matrix};
use super::xml_tags::{OTHER_TAGS, STEP_TAGS, VALUE_TAGS, unknown_tag};
use super::{DEPTH_LIMIT, plugins};
use crate::scene::bundle::Bundle;
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::{Location, SceneError, nearest_name};
use crate::scene::notice::Notice;

/// Reads a scene file and everything that it includes from `bundle`.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
    moment: Option<f64>,
) -> Result<Reading, SceneError> {
    let parameters = Parameters::new(defines);
    let mut reader = Reader {
        bundle,
        parameters,
        aliases: Vec::new(),
        includes: Vec::new(),
        open: Vec::new(),
        search_folders: Vec::new(),
        notices: Vec::new(),
        motion: Motion::at(moment),
        version: Version(3, 0),
        old: Old::default(),
    };
    let text = File::text(bytes, location)?;
    let document = File::parse(text, location)?;
    let file = File::new(&location.file, text);
    let root = document.root_element();
    if root.tag_name().name() != "scene" {
        let problem = format!("the outermost tag is <{}>", root.tag_name().name());
        return Err(SceneError::new(&file.place(root, ""), problem, "put everything into <scene version=\"3.0.0\">"));
    }
    let mut scope = Scope::new(PluginClass::Scene, "scene", file.place(root, "scene"));
    reader.version = reader.version_of(&file, root)?;
    reader.open.push(location.file.clone());
    reader.contents(&file, root, 0, &mut scope)?;
    reader.parameters.check_all_used(&scope.draft.location)?;
    reader.look_up_files(&mut scope.draft);
    let Reader { aliases, includes, notices, motion, version, old, .. } = reader;
    let reading = Reading { root: scope.draft, aliases, includes, notices, moves: motion.span };
    if version.is_old() { mitsuba_old::translate(reading, version, old, bundle) } else { Ok(reading) }
}

/// A plugin that is being read.
pub(super) struct Scope {
    pub(super) draft: Draft,
    /// How many children of each tag there have been, for their paths.
    counts: BTreeMap<String, usize>,
}

impl Scope {
    fn new(class: PluginClass, plugin: &str, location: Location) -> Self {
        Self { draft: Draft::new(class, plugin, &location), counts: BTreeMap::new() }
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

pub(super) struct Reader<'a> {
    pub(super) bundle: &'a Bundle,
    parameters: Parameters,
    aliases: Vec<Alias>,
    includes: Vec<(String, Location)>,
    /// The files that are being read, each included by the one before.
    open: Vec<String>,
    /// The folders of `<path>`, relative to the scene's: the last one is searched first, and the scene's own at the end.
    search_folders: Vec<String>,
    pub(super) notices: Vec<Notice>,
    motion: Motion,
    /// The scene file's.
    version: Version,
    /// What reading leaves to the translation of an old scene.
    pub(super) old: Old,
}

impl Reader<'_> {
    fn version_of(&mut self, file: &File<'_>, scene: Node<'_, '_>) -> Result<Version, SceneError> {
        let place = file.place(scene, "scene");
        let attributes = self.attributes(file, scene, "scene", &["version"], &["id"])?;
        let version = attributes.text("version");
        Version::parse(version).ok_or_else(|| {
            SceneError::new(&place, format!("{} is not a version", shown(version)), "write version=\"3.0.0\"")
        })
    }

    /// The attributes of `element`: all of `required`, perhaps some of `optional`, and no others.
    pub(super) fn attributes<'n>(
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
    pub(super) fn refuse_contents(&self, file: &File<'_>, element: Node<'_, '_>, path: &str) -> Result<(), SceneError> {
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
        let old = self.version.is_old();
        match if old { mitsuba_old::class_of_tag(tag) } else { plugins::class_of_tag(tag) } {
            Some(PluginClass::Scene) => Err(SceneError::new(&place, "a <scene> inside a scene", "use <include>")),
            Some(class) => self.plugin(file, element, depth, class, scope),
            None if old && mitsuba_old::COLOR_TAGS.contains(&tag) => self.old_child(file, element, scope),
            None if tag == "transform" => self.transform(file, element, scope),
            None if tag == "animation" => self.animation(file, element, scope),
            None if VALUE_TAGS.contains(&tag) => self.value(file, element, depth, scope),
            None if OTHER_TAGS.contains(&tag) => self.other(file, element, depth, scope),
            None if old && !STEP_TAGS.contains(&tag) => self.old_child(file, element, scope),
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
        if class == PluginClass::Texture && spectra::PLUGINS.contains(&scope.draft.plugin.as_str()) {
            return self.spectral_plugin(&name, scope.draft, parent);
        }
        parent.draft.children.push(DraftChild { name, target: Target::Plugin(scope.draft), location });
        Ok(())
    }

    fn value(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        depth: usize,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        let tag = element.tag_name().name();
        let vector = ["point", "vector"].contains(&tag);
        let path = parameter_path(element, scope);
        let place = file.place(element, path.as_str());
        if tag == "spectrum" && (element.has_attribute("filename") || element.has_attribute("type")) {
            return self.spectrum(file, element, depth, scope);
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
            "spectrum" => spectra::text(text, Purpose::of(scope.draft.class, attributes.text("name"))),
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
        let matrix = self.steps(file, element, &path)?;
        let (name, value) = (attributes.text("name").to_owned(), Value::Transform(matrix));
        scope.draft.parameters.push(Parameter { name, value, location: file.place(element, path) });
        Ok(())
    }

    /// The product of the steps in a `<transform>`, each applied after the one before.
    pub(super) fn steps(&mut self, file: &File<'_>, element: Node<'_, '_>, path: &str) -> Result<DMat4, SceneError> {
        let mut matrix = DMat4::IDENTITY;
        for child in element.children() {
            if child.is_element() {
                matrix = self.step(file, child, path)? * matrix;
            } else {
                self.refuse_text(file, child, path)?;
            }
        }
        Ok(matrix)
    }

    fn step(&mut self, file: &File<'_>, element: Node<'_, '_>, path: &str) -> Result<DMat4, SceneError> {
        let tag = element.tag_name().name();
        let place = file.place(element, path);
        let (required, optional): (&[&str], &[&str]) = match tag {
            "lookat" | "lookAt" if self.version.is_old() => return self.old_look_at(file, element, path),
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
        self.notices.extend(notice_of_axis(tag, &attributes, self.version, &place));
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
            "path" => (&["value"], &[]),
            _ => (&["filename"], &[]),
        };
        let attributes = self.attributes(file, element, &path, required, optional)?;
        self.refuse_contents(file, element, &path)?;
        let location = file.place(element, path);
        match tag {
            "ref" => {
                if scope.draft.class == PluginClass::Scene {
                    let explanation = "it stands directly in the scene, where it has no effect";
                    let subject = format!("<ref id={}>", shown(attributes.text("id")));
                    self.notices.push(Notice::ignored(&location, subject, explanation));
                    return Ok(());
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
            "path" => self.search_folder(attributes.text("value"), &location, scope)?,
            _ => {
                let name = self.looked_up(attributes.text("filename"));
                self.include(&name, &location, depth, scope)?;
            }
        }
        Ok(())
    }
}

/// The path of a parameter: its plugin's path and its name, if it has one.
pub(super) fn parameter_path(element: Node<'_, '_>, scope: &Scope) -> String {
    let name = element.attribute("name").unwrap_or(element.tag_name().name());
    format!("{}/{name}", scope.draft.location.path)
}
