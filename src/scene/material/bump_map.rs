//! `bumpmap`: shading normals as if the surface were displaced along its normals [Blinn 1978].
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | a nested texture | displacement | m | required |
//! | `scale` | factor on it | – | 1 |
//!
//! See [`turned_normal`](super::turned_normal) for what it shares with `normalmap`.

use super::View;
use super::turned_normal::{NormalSource, TurnedNormal};
use crate::math::Vec3;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// `bumpmap`.
pub type BumpMap = TurnedNormal<Displacement>;

/// A displacement along the shading normal.
#[derive(Clone, Debug)]
pub struct Displacement {
    displacement: Texture,
    scale: f32,
}

impl NormalSource for Displacement {
    fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let scale = fields.float("scale")?.unwrap_or(1.0) as f32;
        textures.ask_for_partials();
        match fields.child(PluginClass::Texture) {
            Some(node) => Ok(Self { displacement: textures.texture(node)?, scale }),
            None => Err(SceneError::new(fields.location(), "\"bumpmap\" holds no texture", "nest the displacement")),
        }
    }

    fn normal(&self, view: &View) -> Option<Vec3> {
        let slope = self.displacement.gradient(&view.point) * self.scale;
        // The displaced partial derivatives are (a, 0, slope.x) and (b, c, slope.y).
        let [a, b, c] = view.point.detail.partials();
        let normal = Vec3::new(-slope.x * c, slope.x * b - a * slope.y, a * c).try_normalize()?;
        Some(if normal.z < 0.0 { -normal } else { normal })
    }
}
