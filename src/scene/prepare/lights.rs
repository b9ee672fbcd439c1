//! Lights of a description: those on shapes, and those that stand alone.

use std::sync::Arc;

use crate::math::Rgb;
use crate::scene::description::{Node, SceneDescription};
use crate::scene::error::{Location, SceneError};
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::light::area::{self, Emission};
use crate::scene::light::{self, AreaLight, DirectionalArea, GroupName, Light, LightGroups, LightTable, Surroundings};
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

/// A shape that emits.
pub(super) struct AreaLightShape {
    /// Its index.
    pub(super) shape: usize,
    pub(super) emission: Emission,
    /// The user's id of the shape, or empty.
    pub(super) name: String,
}

/// Lights in the order of their table, and what the user calls them.
#[derive(Default)]
pub(super) struct PlacedLights {
    lights: Vec<Light>,
    names: Vec<String>,
    /// The groups that they name.
    groups: Vec<Option<GroupName>>,
}

impl PlacedLights {
    fn push(&mut self, light: Light, name: String, group: Option<GroupName>) {
        self.lights.push(light);
        self.names.push(name);
        self.groups.push(group);
    }
}

/// Turns the shapes that emit into lights.
pub(super) fn place_area_lights(
    geometry: &mut Geometry,
    members: &[Vec<u32>],
    area_lights: Vec<AreaLightShape>,
    placed: &mut PlacedLights,
) {
    for AreaLightShape { shape, emission, name } in area_lights {
        let (primitives, group) = (members[shape].clone(), emission.group.clone());
        if emission.along_normal {
            if let Some(light) = DirectionalArea::new(emission, primitives, geometry) {
                placed.push(Light::DirectionalArea(light), name, group);
            }
        } else if let Some(light) = AreaLight::new(emission, primitives, geometry) {
            geometry.set_light(shape, placed.lights.len() as u32);
            placed.push(Light::AreaLight(light), name, group);
        }
    }
}

pub(super) fn light_table(
    geometry: &Geometry,
    (mut placed, seen_only): (PlacedLights, Vec<Emission>),
    emitters: &[&Arc<Node>],
    sensor: &Node,
    textures: &mut TextureReader<'_>,
    description: &SceneDescription,
) -> Result<LightTable, SceneError> {
    let surroundings = Surroundings::new(geometry.bounds());
    if !placed.lights.iter().all(|light| light.power().is_finite()) {
        return Err(too_bright(&description.root.location, "area"));
    }
    let mut night = None;
    for node in emitters {
        let (light, group) = light::read(node, surroundings, textures, &description.bundle, sensor)?;
        if light.is_environment() && placed.lights.iter().any(Light::is_environment) {
            return Err(SceneError::new(&node.location, "the scene has two environments", "remove one of them"));
        }
        if !light.power().is_finite() {
            return Err(too_bright(&node.location, &node.plugin));
        }
        night = night.or_else(|| night_of(node, &light));
        placed.push(light, node.id.clone(), group);
    }
    let PlacedLights { lights, names, groups } = placed;
    let seen_groups: Vec<Option<&GroupName>> = seen_only.iter().map(|emission| emission.group.as_ref()).collect();
    let groups = LightGroups::new(&groups, &seen_groups)?;
    let known = |table: LightTable| table.with_names(names).with_seen_only(seen_only).with_groups(groups);
    LightTable::new(lights, geometry).map(known).ok_or_else(|| {
        night.unwrap_or_else(|| {
            SceneError::new(
                &description.root.location,
                "nothing in the scene emits light",
                "add an emitter with a radiance above 0",
            )
        })
    })
}

fn too_bright(location: &Location, plugin: &str) -> SceneError {
    let problem = format!("an emitter \"{plugin}\" sends more light than a number of 32 bits holds");
    SceneError::new(location, problem, "give smaller numbers")
}

/// Why a day is black, for where nothing else emits.
fn night_of(node: &Node, light: &Light) -> Option<SceneError> {
    let where_the_sun_is = match light {
        Light::SunSky(day) if day.elevation() <= 0.0 => format!("{:.1}° below the horizon", -day.elevation()),
        Light::EnvironmentMap(map) if node.plugin == "timed_sunsky" && map.power() == Rgb::ZERO => {
            "below the horizon all the time".to_owned()
        }
        _ => return None,
    };
    let problem =
        format!("the sun of the {} stands {where_the_sun_is}, and nothing else in the scene emits light", node.plugin);
    Some(SceneError::new(&node.location, problem, "let the sun rise, or add an emitter"))
}
