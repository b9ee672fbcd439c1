//! Spectra that are files or plugins of their own.

use roxmltree::Node;

use super::super::draft::{Draft, DraftChild, Target};
use super::super::spectra::{self, Purpose};
use super::super::xml_element::File;
use super::{Reader, Scope, parameter_path, refused};
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::SceneError;

impl Reader<'_> {
    /// A `<spectrum>` of a file, or a plugin.
    pub(super) fn spectrum(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        depth: usize,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        if element.has_attribute("type") {
            return self.plugin(file, element, depth, PluginClass::Texture, scope);
        }
        let path = parameter_path(element, scope);
        let location = file.place(element, path.as_str());
        let attributes = self.attributes(file, element, &path, &["name", "filename"], &[])?;
        self.refuse_contents(file, element, &path)?;
        let (name, spectrum) = (attributes.text("name"), self.looked_up(attributes.text("filename")));
        self.register_file(&spectrum, &location)?;
        let content = self.bundle.read(&spectrum, &location)?;
        let value = spectra::file(&content, Purpose::of(scope.draft.class, name));
        let value = value.map_err(|refusal| refused(&location, "spectrum", refusal))?;
        scope.draft.parameters.push(Parameter { name: name.to_owned(), value, location });
        Ok(())
    }

    /// A spectrum that is written as a plugin: the color in its place, or a texture of that where others may refer to it.
    pub(super) fn spectral_plugin(&mut self, name: &str, draft: Draft, parent: &mut Scope) -> Result<(), SceneError> {
        let rgb = spectra::of_plugin(&draft, Purpose::of(parent.draft.class, name))?;
        let location = draft.location.clone();
        if draft.id.is_empty() && parent.draft.class != PluginClass::Scene && !spectra::stays_texture(&parent.draft) {
            parent.draft.parameters.push(Parameter { name: name.to_owned(), value: Value::Rgb(rgb), location });
            return Ok(());
        }
        let mut texture = Draft::new(PluginClass::Texture, "rawconstant", &location).with_rgb("value", rgb);
        texture.id = draft.id;
        parent.draft.children.push(DraftChild { name: name.to_owned(), target: Target::Plugin(texture), location });
        Ok(())
    }
}
