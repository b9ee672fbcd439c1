//! `bumpmap`: shading normals as if the surface were displaced along its normals [Blinn 1978].
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | a nested texture | displacement | m | required |
//! | `scale` | factor on it | – | 1 |
//! | a nested bsdf | the surface | – | required |

use crate::math::Vec3;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::{Geometry, Interaction};
use crate::scene::texture::{Texture, TextureReader};

/// A displacement along the shading normal.
#[derive(Clone, Debug)]
pub struct BumpMap {
    displacement: Texture,
    scale: f32,
}

impl BumpMap {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let scale = fields.float("scale")?.unwrap_or(1.0) as f32;
        match fields.child(PluginClass::Texture) {
            Some(node) => Ok(Self { displacement: textures.texture(node)?, scale }),
            None => Err(SceneError::new(fields.location(), "\"bumpmap\" holds no texture", "nest the displacement")),
        }
    }

    /// The unit normal of the displaced surface in world space; none where texture coordinates do not tell points apart.
    pub fn normal(&self, geometry: &Geometry, hit: &Interaction) -> Option<Vec3> {
        let smooth = hit.frame.normal;
        let slope = self.displacement.gradient(hit.uv) * self.scale;
        let [along_u, along_v] = geometry.partials(hit);
        let displaced = |along: Vec3, slope: f32| along + smooth * (slope - smooth.dot(along));
        let normal = displaced(along_u, slope.x).cross(displaced(along_v, slope.y)).try_normalize()?;
        Some(if normal.dot(hit.geometric_normal) < 0.0 { -normal } else { normal })
    }
}
