//! From what a user wrote to what methods read: description, check, prepare.

pub mod bundle;
pub mod description;
pub mod error;
pub mod fields;
pub mod import;

use description::SceneDescription;
use error::SceneError;

/// A prepared scene: checked, with accelerator, light table and materials; immutable, shared by reference.
pub struct Scene {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// The method that the scene's `<integrator>` asks for, as the user wrote it; `None` when there is none.
    pub integrator: Option<crate::scene::Integrator>,
    /// Things the user should know, one sentence each (for example an integrator that was substituted).
    pub notices: Vec<String>,
}

/// The scene's `<integrator>`: plugin name and plain parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Integrator {
    /// Plugin name, for example `sppm` or `path`.
    pub name: String,
    /// Parameters as JSON values.
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

impl Scene {
    /// Checks a description and builds what methods need.
    pub fn prepare(description: &SceneDescription) -> Result<Self, SceneError> {
        let _ = description;
        todo!("lands with the geometry")
    }
}
