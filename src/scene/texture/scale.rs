//! `scale`: a nested texture times a constant, and a constant more. Not in Mitsuba; formats with factors on textures need it.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `scale` | factor, a number, a color or a texture | ≥ 0 | 1 |
//! | `offset` | what is added to the product, a number or a color | ≥ 0 | 0 |
//! | `invert` | the result is 1 minus the scaled color, and at least 0 (boolean) | – | false |
//! | `clamp` | the result is held to 0 to 1 (boolean) | – | false |
//! | a nested texture | what is scaled | – | required |

use super::{Texture, TextureReader, number_of};
use crate::math::{Rgb, Vec2};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;

/// A texture times a color.
#[derive(Clone, Debug)]
pub struct Scale {
    factor: Texture,
    offset: Rgb,
    invert: bool,
    clamp: bool,
    nested: Texture,
}

impl Scale {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let factor = textures.color(fields, "scale")?.unwrap_or(Texture::grey(1.0));
        let offset = fields.rgb("offset")?.unwrap_or([0.0; 3]);
        let offset = Rgb::from_array(offset.map(|channel| channel as f32));
        let invert = fields.boolean("invert")?.unwrap_or(false);
        let clamp = fields.boolean("clamp")?.unwrap_or(false);
        let Some(node) = fields.child(PluginClass::Texture) else {
            return Err(SceneError::new(fields.location(), "\"scale\" holds no texture", "nest the texture to scale"));
        };
        Ok(Self { factor, offset, invert, clamp, nested: textures.texture(node)? })
    }

    #[inline]
    fn changed(&self, color: Rgb, factor: Rgb) -> Rgb {
        let scaled = color * factor + self.offset;
        let turned = if self.invert { (Rgb::ONE - scaled).max(Rgb::ZERO) } else { scaled };
        if self.clamp { turned.clamp(Rgb::ZERO, Rgb::ONE) } else { turned }
    }

    /// The scaled color at `point`.
    pub fn color(&self, point: &TexturePoint) -> Rgb {
        self.changed(self.nested.color(point), self.factor.color(point))
    }

    /// That of the scaled number; of a tinted color, the mean of its channels' slopes stands for the luminance's, and a factor that
    /// varies has none. Where values are held to an end of the range, it is that of the values themselves.
    pub fn gradient(&self, point: &TexturePoint) -> Vec2 {
        let slope = self.nested.gradient(point) * number_of(self.factor.color(point));
        if self.invert { -slope } else { slope }
    }

    /// The scaled mean; where values are held to an end of the range, that of the values themselves, held.
    pub fn mean(&self) -> Rgb {
        self.changed(self.nested.mean(), self.factor.mean())
    }

    /// The scaled bounds.
    pub fn range(&self) -> [Rgb; 2] {
        let ([low, high], [least, most]) = (self.nested.range(), self.factor.range());
        let [low, high] = [self.changed(low, least), self.changed(high, most)];
        if self.invert { [high, low] } else { [low, high] }
    }
}
