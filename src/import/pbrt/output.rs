//! What an import makes: plugins, mesh files, and notices of what it could not represent.

use std::collections::HashSet;
use std::sync::Arc;

use super::super::draft::{Draft, Target};
use super::super::gzip;
use super::super::notices::Notices;
use super::super::values::shown;
use super::mesh::Mesh;
use super::parameters::{Parameter, Parameters, Unused};
use crate::scene::bundle::{Bundle, Generated};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;

/// The most triangles of meshes that stand in the text or are made of curved shapes.
const TRIANGLE_LIMIT: usize = 16_000_000;
/// The most shapes, instances, lights, materials and textures together.
const PLUGIN_LIMIT: usize = 500_000;
/// How many different things a scene may have that cannot be represented.
const NOTICE_LIMIT: usize = 2000;

/// How the names of compressed files end.
const GZIP: &str = ".gz";

/// Whether a file is compressed, by its name.
pub(super) fn is_compressed(name: &str) -> bool {
    name.to_ascii_lowercase().ends_with(GZIP)
}

/// The scene so far.
pub(super) struct Output<'a> {
    pub bundle: &'a Bundle,
    /// The files that were read, with the places that name them.
    pub includes: Vec<(String, Location)>,
    pub made: Generated,
    /// The ids of textures that may have values above 1.
    pub bright: HashSet<String>,
    pub notices: Notices,
    subjects: HashSet<String>,
    /// What stands in the scene.
    pub plugins: Vec<Draft>,
    count: usize,
    triangles: usize,
}

impl<'a> Output<'a> {
    /// An empty scene.
    pub(super) fn new(bundle: &'a Bundle) -> Self {
        let (includes, made, notices) = (Vec::new(), Generated::default(), Notices::default());
        let (subjects, plugins) = (HashSet::new(), Vec::new());
        let bright = HashSet::new();
        Self { bundle, includes, made, bright, notices, subjects, plugins, count: 0, triangles: 0 }
    }

    /// Something similar takes the place of `subject`.
    pub(super) fn approximated(
        &mut self,
        place: &Location,
        subject: impl Into<String>,
        explanation: impl Into<String>,
    ) {
        self.notice(Notice::approximated(place, subject, explanation));
    }

    /// The scene has no `subject`.
    pub(super) fn ignored(&mut self, place: &Location, subject: impl Into<String>, explanation: impl Into<String>) {
        self.notice(Notice::ignored(place, subject, explanation));
    }

    fn notice(&mut self, notice: Notice) {
        if self.subjects.len() < NOTICE_LIMIT || self.subjects.contains(&notice.subject) {
            self.subjects.insert(notice.subject.clone());
            self.notices.add(notice);
        }
    }

    /// Reports the parameters of `what` that nobody asked for.
    ///
    /// # Errors
    /// When too much of the scene cannot be represented.
    pub(super) fn report_unused(&mut self, what: &str, parameters: &Parameters) -> Result<(), SceneError> {
        for Unused { parameter: Parameter { name, place, .. }, explanation } in parameters.unused() {
            self.ignored(place, format!("parameter {} of {what}", shown(name)), explanation);
        }
        if self.subjects.len() < NOTICE_LIMIT {
            return Ok(());
        }
        let problem = format!("the scene has {NOTICE_LIMIT} different things that cannot be represented");
        Err(SceneError::new(&parameters.place, problem, "make sure that this is a scene of pbrt-v4"))
    }

    /// Makes room for one more plugin.
    pub(super) fn count_plugin(&mut self, place: &Location) -> Result<usize, SceneError> {
        self.count += 1;
        if self.count <= PLUGIN_LIMIT {
            return Ok(self.count);
        }
        let problem = format!("the scene has more than {PLUGIN_LIMIT} shapes, lights, materials and textures");
        Err(SceneError::new(place, problem, "join shapes of one material to meshes"))
    }

    /// Adds a plugin to the scene.
    pub(super) fn add(&mut self, plugin: Draft) -> Result<(), SceneError> {
        self.count_plugin(&plugin.location)?;
        self.plugins.push(plugin);
        Ok(())
    }

    /// Adds a plugin that others refer to, and gives its id.
    pub(super) fn define(&mut self, kind: &str, name: &str, plugin: Draft) -> Result<String, SceneError> {
        let number = self.count_plugin(&plugin.location)?;
        let name: String = name.chars().take(80).collect();
        let id = format!("{kind}-{number}-{name}");
        self.plugins.push(Draft { id: id.clone(), ..plugin });
        Ok(id)
    }

    /// A `ply` shape of a mesh that is kept in memory.
    pub(super) fn mesh_shape(&mut self, mesh: Mesh, place: &Location) -> Result<Draft, SceneError> {
        self.count_triangles(mesh.triangles.len(), place)?;
        let name = format!("pbrt-{}.ply", self.made.meshes.len());
        let shape = Draft::new(PluginClass::Shape, "ply", place).with_text("filename", &name);
        let shape = if mesh.normals.is_empty() { shape.with_flag("face_normals", true) } else { shape };
        self.made.meshes.insert(name, mesh.into_triangles().into());
        Ok(shape)
    }

    /// Makes room for triangles.
    pub(super) fn count_triangles(&mut self, count: usize, place: &Location) -> Result<(), SceneError> {
        self.triangles = self.triangles.saturating_add(count);
        if self.triangles <= TRIANGLE_LIMIT {
            return Ok(());
        }
        let problem = format!("the scene's text makes more than {TRIANGLE_LIMIT} triangles");
        Err(SceneError::new(place, problem, "put big meshes into PLY files"))
    }

    /// The bytes of a file that the scene consists of, unpacked if its name ends in `.gz`.
    pub(super) fn read(&mut self, name: &str, place: &Location) -> Result<Arc<[u8]>, SceneError> {
        let content = self.bundle.read(name, place)?;
        if !is_compressed(name) {
            return Ok(content);
        }
        gzip::unpacked(&content, name, place)
    }

    /// Keeps an unpacked file, and gives the name by which shapes find it.
    pub(super) fn keep_unpacked(&mut self, name: &str, content: Arc<[u8]>, place: &Location) -> String {
        let kept = format!("unpacked/{}", &name[..name.len() - GZIP.len()]);
        if self.made.files.insert(kept.clone(), content).is_none() {
            self.includes.push((name.to_owned(), place.clone()));
        }
        kept
    }

    /// Leaves out the materials and textures that nothing refers to, so that they need not be readable.
    pub(super) fn drop_unused(&mut self) {
        fn collect(draft: &Draft, ids: &mut HashSet<String>) {
            for child in &draft.children {
                match &child.target {
                    Target::Reference(id) => {
                        ids.insert(id.clone());
                    }
                    Target::Plugin(plugin) => collect(plugin, ids),
                }
            }
        }
        let is_definition = |plugin: &Draft| matches!(plugin.class, PluginClass::Bsdf | PluginClass::Texture);
        let mut used = HashSet::new();
        self.plugins.iter().filter(|plugin| !is_definition(plugin)).for_each(|plugin| collect(plugin, &mut used));
        // Definitions refer to earlier ones only.
        for definition in self.plugins.iter().rev().filter(|plugin| is_definition(plugin)) {
            if used.contains(&definition.id) {
                collect(definition, &mut used);
            }
        }
        self.plugins.retain(|plugin| !is_definition(plugin) || used.contains(&plugin.id));
    }
}

/// A whole number as a parameter.
pub(super) fn with_integer(draft: Draft, name: &str, number: i64) -> Draft {
    draft.with(name, Value::Integer(number))
}
