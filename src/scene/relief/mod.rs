//! Reliefs: `normalmap` and `bumpmap`, which turn a surface's shading normal. One file per kind, one row in the table.
//!
//! In a scene they are bsdfs round a bsdf. They scatter nothing themselves: they are taken off the material, and the shading
//! normal is turned once where a path meets the surface, so that transport knows of no relief. Hence a material has one
//! relief at most; several materials in one, each with its own, are refused.

pub mod bump_map;
pub mod normal_map;

use std::sync::Arc;

use super::description::{Node, PluginClass};
use super::error::SceneError;
use super::fields::Fields;
use super::geometry::{Geometry, Interaction};
use super::texture::TextureReader;
use crate::math::{Frame, Vec3};

pub use bump_map::BumpMap;
pub use normal_map::NormalMap;

/// What turns the shading normals of a surface.
#[derive(Clone, Debug)]
pub enum Relief {
    /// See [`NormalMap`].
    NormalMap(NormalMap),
    /// See [`BumpMap`].
    BumpMap(BumpMap),
}

/// Reads the parameters of a relief plugin.
type ReadRelief = fn(&mut Fields<'_>, &mut TextureReader<'_>) -> Result<Relief, SceneError>;

/// Relief plugins by name.
const RELIEFS: &[(&str, ReadRelief)] = &[
    ("normalmap", |fields, textures| Ok(Relief::NormalMap(NormalMap::read(fields, textures)?))),
    ("bumpmap", |fields, textures| Ok(Relief::BumpMap(BumpMap::read(fields, textures)?))),
];

impl Relief {
    /// Turns the shading frame of a hit with texture coordinates.
    pub fn turn(&self, geometry: &Geometry, hit: &mut Interaction) {
        let normal = match self {
            Self::NormalMap(map) => map.normal(hit),
            Self::BumpMap(map) => map.normal(geometry, hit),
        };
        if let Some(normal) = normal {
            hit.frame = turned(&hit.frame, normal);
        }
    }
}

/// The frame round `normal` with its tangent as near as it can be to that of `frame`, and its bitangent on the same side.
fn turned(frame: &Frame, normal: Vec3) -> Frame {
    let Some(tangent) = (frame.tangent - normal * normal.dot(frame.tangent)).try_normalize() else {
        return Frame::from_normal(normal);
    };
    let side = frame.normal.cross(frame.tangent).dot(frame.bitangent);
    Frame { tangent, bitangent: normal.cross(tangent) * 1f32.copysign(side), normal }
}

/// Takes the relief off a material: the material without it, and the relief if there is one.
///
/// # Errors
/// When one relief holds another, or one of several nested materials has a relief.
pub fn take_off(node: &Arc<Node>, textures: &mut TextureReader<'_>) -> Result<(Arc<Node>, Option<Relief>), SceneError> {
    if let Some((name, read)) = RELIEFS.iter().find(|(name, _)| *name == node.plugin) {
        let mut fields = Fields::new(node);
        let relief = read(&mut fields, textures)?;
        let Some(nested) = fields.child(PluginClass::Bsdf) else {
            let problem = format!("\"{name}\" holds no bsdf");
            return Err(SceneError::new(&node.location, problem, "nest the bsdf of the surface"));
        };
        fields.finish()?;
        return match take_off(nested, textures)? {
            (material, None) => Ok((material, Some(relief))),
            _ => Err(SceneError::new(&nested.location, "one relief holds another", "remove one of them")),
        };
    }
    let nested: Vec<usize> =
        (0..node.children.len()).filter(|index| node.children[*index].node.class == PluginClass::Bsdf).collect();
    for index in &nested {
        let child = &node.children[*index].node;
        let (material, relief) = take_off(child, textures)?;
        if relief.is_none() {
            continue;
        }
        if nested.len() > 1 {
            let problem = format!("\"{}\" holds several bsdfs, one of them a \"{}\"", node.plugin, child.plugin);
            return Err(SceneError::new(&child.location, problem, "put one relief round all of them"));
        }
        let mut outer = Node::clone(node);
        outer.children[*index].node = material;
        return Ok((Arc::new(outer), relief));
    }
    Ok((node.clone(), None))
}
