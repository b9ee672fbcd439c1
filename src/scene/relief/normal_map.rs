//! `normalmap`: shading normals from an image.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `normalmap` | a texture, whose bitmap is `raw`: red, green and blue from 0 to 1 are coordinates from -1 to 1 along ∂p/∂u, across it and along the shading normal | required |
//! | a nested bsdf | the surface | required |

use crate::math::Vec3;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Interaction;
use crate::scene::texture::{Texture, TextureReader};

/// Normals in the shading frame.
#[derive(Clone, Debug)]
pub struct NormalMap {
    normals: Texture,
}

impl NormalMap {
    /// Reads the texture.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        match fields.named_child(PluginClass::Texture, "normalmap") {
            Some(node) => Ok(Self { normals: textures.texture(node)? }),
            None => {
                let problem = "\"normalmap\" has no texture \"normalmap\"";
                Err(SceneError::new(fields.location(), problem, "nest <texture name=\"normalmap\" …>"))
            }
        }
    }

    /// The unit normal in world space; none where the image holds no direction.
    pub fn normal(&self, hit: &Interaction) -> Option<Vec3> {
        hit.frame.to_world(self.normals.color(hit.uv) * 2.0 - 1.0).try_normalize()
    }
}
