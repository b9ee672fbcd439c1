//! Lights of a description: those on shapes, and those that stand alone.

use std::sync::Arc;

use crate::scene::description::{Node, SceneDescription};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::light::area::{self, Emission};
use crate::scene::light::{self, AreaLight, DirectionalArea, Light, LightTable, Surroundings};
use crate::scene::texture::TextureReader;

pub(super) fn read_area_light(node: &Node, textures: &mut TextureReader<'_>) -> Result<Emission, SceneError> {
    let read = match node.plugin.as_str() {
        "area" => area::read,
        "directionalarea" => area::read_along_normal,
        _ => return Err(not_of_a_shape(node)),
    };
    let mut fields = Fields::new(node);
    let emission = read(&mut fields, textures)?;
    light::check_sampling_weight(&mut fields)?;
    fields.finish()?;
    Ok(emission)
}

fn not_of_a_shape(node: &Node) -> SceneError {
    let problem = format!("a shape cannot carry emitter \"{}\"", node.plugin);
    let remedy = "only \"area\" and \"directionalarea\" stand in a shape; put others in the scene";
    SceneError::new(&node.location, problem, remedy)
}

/// Turns the shapes that emit into lights.
pub(super) fn place_area_lights(
    geometry: &mut Geometry,
    members: &[Vec<u32>],
    area_lights: Vec<(usize, Emission)>,
    lights: &mut Vec<Light>,
) {
    for (shape, emission) in area_lights {
        let primitives = members[shape].clone();
        if emission.along_normal {
            lights.extend(DirectionalArea::new(emission, primitives, geometry).map(Light::DirectionalArea));
        } else if let Some(light) = AreaLight::new(emission, primitives, geometry) {
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
