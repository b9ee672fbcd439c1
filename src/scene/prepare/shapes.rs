//! Shapes: what they are made of and what they emit.

use std::sync::Arc;

use super::checks::check_reach;
use super::lights::{AreaLightShape, read_area_light};
use super::{Builder, instancing};
use crate::math::Rgb;
use crate::scene::description::{Node, PluginClass};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::Shape;
use crate::scene::geometry::mesh::ShapeGeometry;
use crate::scene::geometry::primitive::{Primitive, SHAPES};
use crate::scene::geometry::surface::SEEN_ONLY;
use crate::scene::geometry::transform::ToWorld;
use crate::scene::light::area::Emission;
use crate::scene::light::directional_area::is_flat;
use crate::scene::names::{Name, given_name};
use crate::scene::notice::Notice;
use crate::scene::unsupported::unknown_plugin;

/// A parameter of Mitsuba's shapes that steers how it finds derivatives.
pub(super) const OF_DERIVATIVES: &str = "silhouette_sampling_weight";

impl Builder<'_> {
    /// Adds a shape, or all that it holds.
    pub(super) fn add_shape(&mut self, node: &Arc<Node>) -> Result<(), SceneError> {
        if instancing::PLUGINS.contains(&node.plugin.as_str()) {
            return self.add_instancing(node);
        }
        if node.plugin == MERGE {
            return members(node)?.into_iter().try_for_each(|member| self.add_shape(member));
        }
        let (shape, geometry, emission) = self.read_shape(node)?;
        if let Some(emission) = emission {
            let shape = self.shapes.len();
            self.area_lights.push(AreaLightShape { shape, emission, name: node.id.clone() });
        }
        self.shapes.push((shape, geometry));
        let name = self.object_name(given_name(node));
        self.shape_names.push(name);
        Ok(())
    }

    /// The name of the next object of the scene.
    pub(super) fn object_name(&self, given: &str) -> Name {
        let before = self.shape_names.len() + self.instancing.count();
        Name { given: given.to_owned(), number: before as u32 + 1 }
    }

    /// A shape that is made of primitives, and what it emits.
    pub(super) fn read_shape(&mut self, node: &Node) -> Result<(Shape, ShapeGeometry, Option<Emission>), SceneError> {
        let Some((_, read)) = SHAPES.iter().find(|(name, _)| *name == node.plugin) else {
            let known: Vec<&str> =
                SHAPES.iter().map(|(name, _)| *name).chain(instancing::PLUGINS).chain([MERGE]).collect();
            return Err(unknown_plugin(node, &known));
        };
        let mut fields = Fields::new(node);
        let mut geometry = read(&mut fields, self.bundle)?;
        fields.ignore(&[OF_DERIVATIVES]);
        self.textures.set_shape(Some(std::mem::take(&mut geometry.attributes)));
        let asked = self.textures.attributes_asked();
        if node.plugin == "sphere" && !ToWorld::read(&mut fields)?.is_similarity() {
            let explanation = "it stays a sphere, with the scale along x";
            let notice = Notice::approximated(&node.location, "a sphere that is scaled unevenly", explanation);
            self.notices.push(notice.to_string());
        }
        let emitter = fields.child(PluginClass::Emitter);
        let shape = match fields.child(PluginClass::Bsdf) {
            Some(node) => self.material(node)?,
            None => Shape::new(self.default_material(emitter.is_some())),
        };
        let shape = Shape { boundary: self.boundary_of(&mut fields, &node.location)?, ..shape };
        let emitter = emitter.map(|node| read_area_light(node, &mut self.textures)).transpose()?;
        fields.finish()?;
        geometry.needs_places = self.textures.attributes_asked() > asked;
        self.textures.set_shape(None);
        if geometry.needs_places && shape.needs_partials {
            let problem = "a shape with a bumpmap reads a mesh_attribute";
            return Err(SceneError::new(
                &node.location,
                problem,
                "take one of them off, or make the bumpmap a normalmap",
            ));
        }
        self.check_extent(node, &geometry)?;
        let emitter = emitter.filter(|emission| emission.radiance.range()[1] != Rgb::ZERO);
        if emitter.as_ref().is_some_and(|emission| emission.along_normal && !is_flat(&geometry.primitives)) {
            let problem = format!("\"directionalarea\" stands in a \"{}\" that is not flat", node.plugin);
            return Err(SceneError::new(
                &node.location,
                problem,
                "use flat shapes that face one way, each with its own",
            ));
        }
        let needs_uv = shape.needs_uv || emitter.as_ref().is_some_and(|emission| emission.radiance.varies());
        let mut shape = Shape { needs_uv, ..shape };
        if let Some(shown) = emitter.as_ref().filter(|emission| emission.seen_only) {
            shape.light = SEEN_ONLY + self.seen_only.len() as u32;
            self.seen_only.push(shown.clone());
            return Ok((shape, geometry, None));
        }
        Ok((shape, geometry, emitter))
    }

    /// A shape must have area, in numbers that single precision can hold.
    fn check_extent(&mut self, node: &Node, geometry: &ShapeGeometry) -> Result<(), SceneError> {
        let area: f64 = geometry.primitives.iter().map(|primitive| f64::from(primitive.area())).sum();
        if !(area > 0.0 && area.is_finite()) {
            let problem = format!("shape \"{}\" has an area of {} m²", node.plugin, shown_number(area));
            return Err(SceneError::new(&node.location, problem, "check its size and its to_world"));
        }
        check_reach(node, geometry.primitives.iter().map(Primitive::bounds))?;
        self.notices.extend(geometry.notices.iter().map(|notice| format!("{}: {notice}", node.location)));
        if geometry.degenerate > 0 {
            self.notices
                .push(format!("{}: {} triangles without area are left out", node.location, geometry.degenerate));
        }
        Ok(())
    }
}

/// `merge`: Mitsuba makes one mesh of those of its members that have the same bsdf; here they stay what they are, which looks the same.
pub(super) const MERGE: &str = "merge";

/// The shapes that a `merge` holds.
pub(super) fn members(merge: &Node) -> Result<Vec<&Arc<Node>>, SceneError> {
    let mut fields = Fields::new(merge);
    let members = fields.children(PluginClass::Shape);
    fields.ignore(&[OF_DERIVATIVES]);
    fields.finish()?;
    Ok(members)
}
