//! `scale`: a nested texture times a constant. Not in Mitsuba; formats with factors on textures need it.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `scale` | factor, a number or a color | ≥ 0 | 1 |
//! | a nested texture | what is scaled | – | required |

use super::{Texture, TextureReader, number_of};
use crate::math::{Rgb, Vec2};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// A texture times a color.
#[derive(Clone, Debug)]
pub struct Scale {
    factor: Rgb,
    nested: Texture,
}

impl Scale {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let factor = fields.rgb("scale")?.unwrap_or([1.0; 3]).map(|channel| channel as f32);
        let Some(node) = fields.child(PluginClass::Texture) else {
            return Err(SceneError::new(fields.location(), "\"scale\" holds no texture", "nest the texture to scale"));
        };
        Ok(Self { factor: Rgb::from_array(factor), nested: textures.texture(node)? })
    }

    /// The scaled color at `uv`.
    pub fn color(&self, uv: Vec2) -> Rgb {
        self.nested.color(uv) * self.factor
    }

    /// That of the scaled number; of a tinted color, the mean of its channels' slopes stands for the luminance's.
    pub fn gradient(&self, uv: Vec2) -> Vec2 {
        self.nested.gradient(uv) * number_of(self.factor)
    }

    /// The scaled mean.
    pub fn mean(&self) -> Rgb {
        self.nested.mean() * self.factor
    }

    /// The scaled bounds.
    pub fn range(&self) -> [Rgb; 2] {
        self.nested.range().map(|bound| bound * self.factor)
    }
}
