//! Scenes that a test writes down, with binary files: Mitsuba XML without the frame round it, and images.

use std::io::Cursor;
use std::sync::Arc;

use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use photonfarm::import::load_bytes;
use photonfarm::scene::bundle::Bundle;
use photonfarm::scene::{Scene, SceneError};

/// Imports and prepares the scene with `body` between its `<scene>` tags. `files` are name and content.
pub(crate) fn prepare(body: &str, files: &[(&str, &[u8])]) -> Result<Scene, SceneError> {
    let text = format!("<scene version='3.0.0'>{body}</scene>");
    let mut description = load_bytes("test.xml", text.as_bytes(), &[])?;
    let files = files.iter().map(|(name, bytes)| ((*name).to_owned(), Arc::from(*bytes)));
    description.bundle = Bundle::Archive(Arc::new(files.collect()));
    Scene::prepare(&description)
}

/// An OpenEXR file with the colors at (column, row).
pub(crate) fn exr_file(width: usize, height: usize, color: impl Fn(usize, usize) -> [f32; 3] + Sync) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|place: Vec2<usize>| {
        let [red, green, blue] = color(place.x(), place.y());
        (red, green, blue)
    });
    let layer = Layer::new((width, height), LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut file).expect("images can be written");
    file.into_inner()
}
