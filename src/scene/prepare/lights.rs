//! Lights of a description: those on shapes, and those that stand alone.

use std::sync::Arc;

use crate::scene::description::{Node, SceneDescription};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::light::area::{self, Emission};
use crate::scene::light::{self, AreaLight, Light, LightTable, Surroundings};
use crate::scene::texture::TextureReader;

pub(super) fn read_area_light(node: &Node, textures: &mut TextureReader<'_>) -> Result<Emission, SceneError> {
    if node.plugin != "area" {
        let problem = format!("a shape cannot carry emitter \"{}\"", node.plugin);
        return Err(SceneError::new(
            &node.location,
            problem,
            "only \"area\" stands in a shape; put others in the scene",
        ));
    }
    let mut fields = Fields::new(node);
    let emission = area::read(&mut fields, textures)?;
    light::check_sampling_weight(&mut fields)?;
    fields.finish()?;
    Ok(emission)
}

/// Turns the shapes that emit into lights.
pub(super) fn place_area_lights(
    geometry: &mut Geometry,
    members: &[Vec<u32>],
    area_lights: Vec<(usize, Emission)>,
    lights: &mut Vec<Light>,
) {
    for (shape, emission) in area_lights {
        if let Some(light) = AreaLight::new(emission, members[shape].clone(), geometry) {
            geometry.set_light(shape, lights.len() as u32);
            lights.push(Light::AreaLight(light));
        }
    }
}

pub(super) fn light_table(
    geometry: &Geometry,
    mut lights: Vec<Light>,
    emitters: &[&Arc<Node>],
    textures: &mut TextureReader<'_>,
    description: &SceneDescription,
) -> Result<LightTable, SceneError> {
    let surroundings = Surroundings::new(geometry.bounds());
    for node in emitters {
        let light = light::read(node, surroundings, textures, &description.bundle)?;
        if light.is_environment() && lights.iter().any(Light::is_environment) {
            return Err(SceneError::new(&node.location, "the scene has two environments", "remove one of them"));
        }
        lights.push(light);
    }
    LightTable::new(lights, geometry).ok_or_else(|| {
        SceneError::new(
            &description.root.location,
            "nothing in the scene emits light",
            "add an emitter with a radiance above 0",
        )
    })
}
