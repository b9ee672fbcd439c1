//! The files that a scene names: those it includes, and the folders that they are looked up in.

use super::super::draft::{Draft, Target};
use super::super::values::shown;
use super::super::xml_element::File;
use super::{Reader, Scope};
use crate::scene::bundle::{Bundle, normalized_name};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{Location, SceneError};

/// How deep files may include files, as in Mitsuba.
const INCLUDE_DEPTH_LIMIT: usize = 15;
/// How many files a scene may include in all.
const INCLUDE_LIMIT: usize = 1000;
/// How many folders a scene may search for files.
const SEARCH_FOLDER_LIMIT: usize = 16;

impl Reader<'_> {
    /// Takes a `<path>`, which is itself looked up in those before it.
    pub(super) fn search_folder(&mut self, folder: &str, location: &Location, scope: &Scope) -> Result<(), SceneError> {
        if scope.draft.class != PluginClass::Scene {
            return Err(SceneError::new(location, "a <path> inside a plugin", "put it directly into the scene"));
        }
        if self.search_folders.len() >= SEARCH_FOLDER_LIMIT {
            let problem = format!("the scene has more than {SEARCH_FOLDER_LIMIT} <path>s");
            return Err(SceneError::new(location, problem, "put the files into fewer folders"));
        }
        let candidates = self.search_folders.iter().rev().map(|known| format!("{known}/{folder}"));
        let names: Vec<String> = candidates.chain([folder.to_owned()]).collect();
        let mut found = None;
        for name in &names {
            let name = normalized_folder(name, location)?;
            found = found.or_else(|| self.bundle.contains_folder(&name).then_some(name));
        }
        match found {
            Some(found) => self.search_folders.push(found),
            // An archive holds a folder only where the scene needs a file of it.
            None if matches!(self.bundle, Bundle::Archive(_)) => {}
            None => {
                let problem = format!("<path>: there is no folder {}", shown(folder));
                return Err(SceneError::new(location, problem, "name it relative to the folder of the scene file"));
            }
        }
        Ok(())
    }

    /// The name of a file relative to the scene's folder, by the search folders.
    pub(in super::super) fn looked_up(&self, name: &str) -> String {
        let candidates = self.search_folders.iter().rev().map(|folder| format!("{folder}/{name}"));
        let found = candidates.filter(|_| !name.starts_with('/')).find(|candidate| self.bundle.contains(candidate));
        found.unwrap_or_else(|| name.to_owned())
    }

    /// Looks up the files that plugins name, in all search folders of the scene.
    pub(super) fn look_up_files(&self, draft: &mut Draft) {
        if self.search_folders.is_empty() {
            return;
        }
        for parameter in draft.parameters.iter_mut().filter(|parameter| parameter.name == "filename") {
            if let Value::String(name) = &mut parameter.value {
                *name = self.looked_up(name);
            }
        }
        for child in &mut draft.children {
            if let Target::Plugin(plugin) = &mut child.target {
                self.look_up_files(plugin);
            }
        }
    }

    /// Remembers a file that is read on the way.
    pub(in super::super) fn register_file(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        if self.includes.len() >= INCLUDE_LIMIT {
            let problem = format!("the scene includes more than {INCLUDE_LIMIT} files");
            return Err(SceneError::new(location, problem, "merge some of them"));
        }
        self.includes.push((name.to_owned(), location.clone()));
        Ok(())
    }

    pub(super) fn include(
        &mut self,
        name: &str,
        location: &Location,
        depth: usize,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        if self.open.iter().any(|open| open == name) {
            let problem = format!("file \"{name}\" includes itself");
            return Err(SceneError::new(location, problem, "remove this <include>"));
        }
        if self.open.len() > INCLUDE_DEPTH_LIMIT {
            let problem = format!("files include files more than {INCLUDE_DEPTH_LIMIT} deep");
            return Err(SceneError::new(location, problem, "include the innermost files directly"));
        }
        self.register_file(name, location)?;
        let bytes = self.bundle.read(name, location)?;
        let start = Location { file: name.to_owned(), line: 0, path: location.path.clone() };
        let text = File::text(&bytes, &start)?;
        let document = File::parse(text, &start)?;
        let file = File::new(name, text);
        self.open.push(name.to_owned());
        let root = document.root_element();
        if root.tag_name().name() == "scene" {
            let version = self.version_of(&file, root)?;
            if version.is_old() != self.version.is_old() {
                let problem = "scenes of Mitsuba 3 and of Mitsuba 0.6 or before include each other";
                return Err(SceneError::new(location, problem, "convert one of them with photonfarm import"));
            }
            self.contents(&file, root, depth, scope)?;
        } else {
            self.child(&file, root, depth, scope)?;
        }
        self.open.pop();
        Ok(())
    }
}

/// The name of a folder without `.` and inner `..` parts; `.` for the scene's own.
fn normalized_folder(folder: &str, location: &Location) -> Result<String, SceneError> {
    let name = normalized_name(&format!("{folder}/file"), location)?;
    Ok(name.strip_suffix("/file").unwrap_or(".").to_owned())
}
