//! `normalmap`: shading normals from an image.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `normalmap` | a color or a texture, whose bitmap is `raw`: red, green and blue from 0 to 1 are coordinates from -1 to 1 along ∂p/∂u, across it and along the shading normal | required |
//!
//! See [`turned_normal`](super::turned_normal) for what it shares with `bumpmap`.

use super::View;
use super::turned_normal::{NormalSource, TurnedNormal};
use crate::math::{Rgb, Vec3};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// `normalmap`.
pub type NormalMap = TurnedNormal<NormalImage>;

/// Normals in the shading frame.
#[derive(Clone, Debug)]
pub struct NormalImage {
    normals: Texture,
}

impl NormalSource for NormalImage {
    fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        if let Some(node) = fields.named_child(PluginClass::Texture, "normalmap") {
            return Ok(Self { normals: textures.texture(node)? });
        }
        let Some(everywhere) = fields.rgb("normalmap")? else {
            let problem = "\"normalmap\" has no texture \"normalmap\"";
            return Err(SceneError::new(fields.location(), problem, "nest <texture name=\"normalmap\" …>"));
        };
        Ok(Self { normals: Texture::Constant(Rgb::from_array(everywhere.map(|coordinate| coordinate as f32))) })
    }

    fn normal(&self, view: &View) -> Option<Vec3> {
        (self.normals.color(&view.point) * 2.0 - 1.0).try_normalize()
    }
}
