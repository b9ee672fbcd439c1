//! Emitter plugins that stand alone; `area` belongs to a shape.

use super::{
    Constant, Directional, EnvironmentMap, GroupName, Ies, Light, Point, Projector, Spot, SunSky, Surroundings, groups,
    sun_sky,
};
use crate::scene::bundle::Bundle;
use crate::scene::camera;
use crate::scene::description::Node;
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::texture::TextureReader;
use crate::scene::unsupported::unknown_plugin;

/// What an emitter is read from.
struct Source<'a, 'b> {
    fields: Fields<'a>,
    surroundings: Surroundings,
    textures: &'a mut TextureReader<'b>,
    bundle: &'a Bundle,
    /// The scene's.
    sensor: &'a Node,
}

type ReadEmitter = fn(&mut Source<'_, '_>) -> Result<Light, SceneError>;

/// Emitter plugins by name.
const EMITTERS: &[(&str, ReadEmitter)] = &[
    ("point", |source| Ok(Light::Point(Point::read(&mut source.fields)?))),
    ("spot", |source| Ok(Light::Spot(Spot::read(&mut source.fields, source.textures)?))),
    ("projector", |source| Ok(Light::Projector(Projector::read(&mut source.fields, source.textures)?))),
    ("ies", |source| Ok(Light::Ies(Ies::read(&mut source.fields, source.bundle)?))),
    ("directional", |source| Ok(Light::Directional(Directional::read(&mut source.fields, source.surroundings)?))),
    ("constant", |source| Ok(Light::Constant(Constant::read(&mut source.fields, source.surroundings)?))),
    ("envmap", |source| {
        let map = EnvironmentMap::read(&mut source.fields, source.textures, source.surroundings)?;
        Ok(Light::EnvironmentMap(map))
    }),
    ("sunsky", |source| Ok(Light::SunSky(SunSky::read(&mut source.fields, source.surroundings)?))),
    ("timed_sunsky", |source| {
        let shutter = camera::shutter(&mut Fields::new(source.sensor))?;
        sun_sky::timed::read(&mut source.fields, shutter, source.surroundings)
    }),
];

/// Reads an emitter node, for pictures by a sensor, and the light group that it names.
///
/// # Errors
/// Unknown plugins and parameters, and parameters out of range, with their place.
pub fn read(
    node: &Node,
    surroundings: Surroundings,
    textures: &mut TextureReader<'_>,
    bundle: &Bundle,
    sensor: &Node,
) -> Result<(Light, Option<GroupName>), SceneError> {
    let Some((_, read)) = EMITTERS.iter().find(|(name, _)| *name == node.plugin) else {
        let known: Vec<&str> = EMITTERS.iter().map(|(name, _)| *name).collect();
        return Err(unknown_plugin(node, &known));
    };
    let mut source = Source { fields: Fields::new(node), surroundings, textures, bundle, sensor };
    let light = read(&mut source)?;
    check_sampling_weight(&mut source.fields)?;
    let group = groups::read(&mut source.fields)?;
    source.fields.finish()?;
    Ok((light, group))
}

/// Reads `sampling_weight`, which says how often Mitsuba samples an emitter. Lights are picked by their importance here, so that it
/// changes no picture.
///
/// # Errors
/// When the weight is not above 0: Mitsuba then never samples the emitter, and one that directions cannot hit is dark.
pub fn check_sampling_weight(fields: &mut Fields<'_>) -> Result<(), SceneError> {
    match fields.float("sampling_weight")? {
        Some(weight) if weight <= 0.0 => {
            let remedy = "give a number above 0, or remove the emitter";
            Err(fields.error("sampling_weight", format!("\"sampling_weight\" is {}", shown_number(weight)), remedy))
        }
        _ => Ok(()),
    }
}
