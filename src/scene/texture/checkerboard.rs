//! `checkerboard`: two colors in turn, four fields to a unit square of texture coordinates.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `color0` | color, or texture, of the fields at the corners (0, 0) and (1, 1) | 0.4 |
//! | `color1` | color, or texture, of the others | 0.2 |
//! | `to_uv` | transform of texture coordinates | identity |
//! | `swaps_numbers` | whether the two change places where a number is asked for, as in Mitsuba 3 (its `eval_1`, version 3.9.1); not in Mitsuba | true |

use glam::Affine2;

use super::{Texture, TextureReader, to_uv};
use crate::math::{Rgb, Vec2};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;

/// Two textures in turn.
#[derive(Clone, Debug)]
pub struct Checkerboard {
    colors: [Texture; 2],
    to_uv: Affine2,
    swaps_numbers: bool,
}

impl Checkerboard {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let first = textures.color(fields, "color0")?.unwrap_or(Texture::grey(0.4));
        let second = textures.color(fields, "color1")?.unwrap_or(Texture::grey(0.2));
        let swaps_numbers = fields.boolean("swaps_numbers")?.unwrap_or(true);
        Ok(Self { colors: [first, second], to_uv: to_uv::read(fields)?, swaps_numbers })
    }

    /// Whether `uv` lies in a field of the second color.
    fn is_second(&self, uv: Vec2) -> bool {
        let place = self.to_uv.transform_point2(uv);
        let place = place - place.floor();
        (place.x > 0.5) != (place.y > 0.5)
    }

    /// The color at `point`.
    pub fn color(&self, point: &TexturePoint) -> Rgb {
        self.colors[usize::from(self.is_second(point.uv))].color(point)
    }

    /// The number at `point`.
    pub fn number(&self, point: &TexturePoint) -> f32 {
        self.of_number(point).number(point)
    }

    /// That within the field: the steps between fields have none.
    pub fn gradient(&self, point: &TexturePoint) -> Vec2 {
        self.of_number(point).gradient(point)
    }

    fn of_number(&self, point: &TexturePoint) -> &Texture {
        &self.colors[usize::from(self.is_second(point.uv) != self.swaps_numbers)]
    }

    /// Half of each.
    pub fn mean(&self) -> Rgb {
        (self.colors[0].mean() + self.colors[1].mean()) * 0.5
    }

    /// Those of both.
    pub fn range(&self) -> [Rgb; 2] {
        let [first, second] = [self.colors[0].range(), self.colors[1].range()];
        [first[0].min(second[0]), first[1].max(second[1])]
    }
}
