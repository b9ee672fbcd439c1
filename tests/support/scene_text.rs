//! Scenes that a test writes down: Mitsuba XML without the frame round it, and the files it refers to.

use std::sync::Arc;

use photonfarm::import::load_bytes;
use photonfarm::scene::bundle::Bundle;
use photonfarm::scene::{Scene, SceneError};

/// Imports and prepares the scene with `body` between its `<scene>` tags. `files` are name and text.
pub(crate) fn prepare(body: &str, files: &[(&str, String)]) -> Result<Scene, SceneError> {
    let text = format!("<scene version='3.0.0'>{body}</scene>");
    let mut description = load_bytes("test.xml", text.as_bytes(), &[])?;
    let files = files.iter().map(|(name, text)| ((*name).to_owned(), Arc::from(text.as_bytes())));
    description.bundle = Bundle::Archive(Arc::new(files.collect()));
    Scene::prepare(&description)
}
