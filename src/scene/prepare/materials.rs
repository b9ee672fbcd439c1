//! Materials of a description: each is read once, however many shapes have it.

use std::sync::Arc;

use super::Builder;
use crate::scene::description::Node;
use crate::scene::error::SceneError;
use crate::scene::geometry::Shape;
use crate::scene::material::{self, Material};
use crate::scene::names::{DEFAULT_MATERIAL, Name, given_name_of_material};

/// A material that was read, as a shape without light.
pub(super) struct KnownMaterial {
    shape: Shape,
    /// It reads attributes of the shape that it was read for, and is no other shape's.
    is_of_one_shape: bool,
}

impl Builder<'_> {
    /// A shape with the material, and what of texture coordinates that needs.
    pub(super) fn material(&mut self, node: &Arc<Node>) -> Result<Shape, SceneError> {
        let address = Arc::as_ptr(node);
        if let Some(known) = self.material_of_node.get(&address)
            && !(known.is_of_one_shape && self.textures.is_in_shape())
        {
            return Ok(known.shape);
        }
        let attributes_asked = self.textures.attributes_asked();
        let asked = (self.textures.coordinates_asked(), self.textures.partials_asked());
        self.materials.push(material::read(node, &mut self.textures)?);
        self.name_material(node);
        let shape = Shape {
            needs_uv: self.textures.coordinates_asked() > asked.0,
            needs_partials: self.textures.partials_asked() > asked.1,
            ..Shape::new(self.materials.len() as u32 - 1)
        };
        let is_of_one_shape = self.textures.attributes_asked() > attributes_asked;
        self.material_of_node.insert(address, KnownMaterial { shape, is_of_one_shape });
        Ok(shape)
    }

    /// Names the newest material. One that is read once for each shape is the same to people.
    fn name_material(&mut self, node: &Arc<Node>) {
        let known = self.material_of_node.get(&Arc::as_ptr(node));
        let first = known.map_or(self.materials.len() - 1, |known| known.shape.material as usize);
        let number = self.material_names.get(first).map_or(first as u32 + 1, |name| name.number);
        self.material_names.push(Name { given: given_name_of_material(node).to_owned(), number });
    }

    /// Mitsuba gives shapes without a bsdf a two-sided grey of reflectance 0.5, but black to those that emit.
    pub(super) fn default_material(&mut self, emits: bool) -> u32 {
        self.materials.push(if emits { Material::black() } else { Material::default_grey() });
        self.material_names.push(Name { given: DEFAULT_MATERIAL.to_owned(), number: self.materials.len() as u32 });
        self.materials.len() as u32 - 1
    }
}
