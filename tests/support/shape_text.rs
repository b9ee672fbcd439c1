//! Shapes that a test writes down, read without a scene round them.

use std::sync::Arc;

use photonfarm::import::load_bytes;
use photonfarm::scene::SceneError;
use photonfarm::scene::bundle::Bundle;
use photonfarm::scene::description::{Node, PluginClass};
use photonfarm::scene::fields::Fields;
use photonfarm::scene::geometry::mesh::ShapeGeometry;
use photonfarm::scene::geometry::primitive::SHAPES;

/// The shapes that Mitsuba XML describes. `files` are name and bytes.
pub(crate) fn read_shapes(body: &str, files: &[(&str, &[u8])]) -> Result<Vec<ShapeGeometry>, SceneError> {
    let files = files.iter().map(|(name, bytes)| ((*name).to_owned(), Arc::from(*bytes)));
    let bundle = Bundle::Archive(Arc::new(files.collect()));
    let read = |node: &Arc<Node>| {
        let (_, read) = SHAPES.iter().find(|(name, _)| *name == node.plugin).expect("the plugin is known");
        read(&mut Fields::new(node), &bundle)
    };
    shape_nodes(body).iter().map(read).collect()
}

/// The nodes of the shapes that Mitsuba XML describes.
pub(crate) fn shape_nodes(body: &str) -> Vec<Arc<Node>> {
    let text = format!("<scene version='3.0.0'>{body}</scene>");
    let root = load_bytes("test.xml", text.as_bytes(), &[]).expect("the text is good").root;
    Fields::new(&root).children(PluginClass::Shape).into_iter().cloned().collect()
}
