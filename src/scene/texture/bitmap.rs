//! `bitmap`: an image; v = 0 is its top row.
//!
//! | parameter | meaning | values | default |
//! |---|---|---|---|
//! | `filename` | PNG, JPEG, OpenEXR, Radiance HDR, TGA or BMP | – | required |
//! | `filter_type` | between texels | `bilinear`, `nearest` | `bilinear` |
//! | `wrap_mode` | outside of the unit square | `repeat`, `mirror`, `clamp` | `repeat` |
//! | `raw` | integers stand for themselves; else they are sRGB | boolean | false |
//! | `channel` | one channel as a grey, not in Mitsuba; alpha is always raw, and 1 where there is none | `r`, `g`, `b`, `a` | all |
//! | `to_uv` | transform of texture coordinates | – | identity |
//!
//! The middle of texel (i, j) of w × h lies at ((i + ½)/w, (j + ½)/h).

use std::sync::Arc;

use glam::Affine2;

use super::raster::Raster;
use super::reader::ImageChoice;
use super::{TextureReader, number_of, to_uv};
use crate::math::{Rgb, Vec2};
use crate::scene::error::{SceneError, nearest_name};
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;

/// An image over texture coordinates.
#[derive(Clone, Debug)]
pub struct Bitmap {
    raster: Arc<Raster>,
    to_uv: Affine2,
    wrap: Wrap,
    nearest: bool,
}

/// What lies outside of the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

/// Values of a string parameter and what they mean.
fn choice<T: Copy>(fields: &mut Fields<'_>, name: &'static str, values: &[(&str, T)]) -> Result<Option<T>, SceneError> {
    let Some(text) = fields.string(name)? else { return Ok(None) };
    if let Some((_, value)) = values.iter().find(|(known, _)| *known == text) {
        return Ok(Some(*value));
    }
    let known: Vec<&str> = values.iter().map(|(known, _)| *known).collect();
    Err(fields.error(name, format!("there is no {name} \"{text}\""), nearest_name(text, &known)))
}

impl Bitmap {
    /// Reads the parameters and the image.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let nearest = choice(fields, "filter_type", &[("bilinear", false), ("nearest", true)])?.unwrap_or(false);
        let wraps = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
        let wrap = choice(fields, "wrap_mode", &wraps)?.unwrap_or(Wrap::Repeat);
        let raw = fields.boolean("raw")?.unwrap_or(false);
        let channel = choice(fields, "channel", &[("r", 0), ("g", 1), ("b", 2), ("a", 3)])?;
        // Mitsuba's storage precision: what is kept here loses nothing.
        fields.ignore(&["format", "accel"]);
        let to_uv = to_uv::read(fields)?;
        let raster = textures.image(fields, ImageChoice { raw, channel })?;
        Ok(Self { raster, to_uv, wrap, nearest })
    }

    /// The color at `point`.
    #[inline]
    pub fn color(&self, point: &TexturePoint) -> Rgb {
        let place = self.to_uv.transform_point2(point.uv);
        if self.nearest {
            let [column, row] = self.nearest_texel(place);
            return self.raster.texel(column, row);
        }
        let ([left, right], x, _) = self.wrap.neighbors(place.x, self.raster.width());
        let ([above, below], y, _) = self.wrap.neighbors(place.y, self.raster.height());
        let upper = self.raster.texel(left, above).lerp(self.raster.texel(right, above), x);
        let lower = self.raster.texel(left, below).lerp(self.raster.texel(right, below), x);
        upper.lerp(lower, y)
    }

    fn nearest_texel(&self, place: Vec2) -> [usize; 2] {
        let index =
            |coordinate: f32, size: usize| ((self.wrap.fold(coordinate).0 * size as f32) as usize).min(size - 1);
        [index(place.x, self.raster.width()), index(place.y, self.raster.height())]
    }

    /// That of the bilinear surface through the texels' numbers; 0 for `nearest`.
    pub fn gradient(&self, point: &TexturePoint) -> Vec2 {
        if self.nearest {
            return Vec2::ZERO;
        }
        let place = self.to_uv.transform_point2(point.uv);
        let (width, height) = (self.raster.width(), self.raster.height());
        let ([left, right], x, slope_x) = self.wrap.neighbors(place.x, width);
        let ([above, below], y, slope_y) = self.wrap.neighbors(place.y, height);
        let number = |column, row| number_of(self.raster.texel(column, row));
        let (a, b) = (number(left, above), number(right, above));
        let (c, d) = (number(left, below), number(right, below));
        let along_x = (b - a) * (1.0 - y) + (d - c) * y;
        let along_y = (c - a) * (1.0 - x) + (d - b) * x;
        let gradient = Vec2::new(along_x * width as f32 * slope_x, along_y * height as f32 * slope_y);
        self.to_uv.matrix2.transpose() * gradient
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.raster.width() as u32, self.raster.height() as u32]
    }

    /// The mean of the texels.
    pub fn mean(&self) -> Rgb {
        self.raster.mean()
    }

    /// Those of the texels.
    pub fn range(&self) -> [Rgb; 2] {
        self.raster.range()
    }
}

impl Wrap {
    /// The coordinate within [0, 1], and the slope of this map.
    #[inline]
    fn fold(self, coordinate: f32) -> (f32, f32) {
        match self {
            Self::Repeat => (coordinate - coordinate.floor(), 1.0),
            Self::Mirror => {
                let half = 0.5 * coordinate;
                let turn = 2.0 * (half - half.floor());
                if turn > 1.0 { (2.0 - turn, -1.0) } else { (turn, 1.0) }
            }
            Self::Clamp => (coordinate.clamp(0.0, 1.0), 1.0),
        }
    }

    /// The texels on either side, the share of the second, and the slope of the fold.
    #[inline]
    fn neighbors(self, coordinate: f32, size: usize) -> ([usize; 2], f32, f32) {
        let (folded, slope) = self.fold(coordinate);
        let place = folded * size as f32 - 0.5;
        let floor = place.floor();
        let (first, last) = (floor as isize, size as isize - 1);
        let texels = match self {
            Self::Repeat => [if first < 0 { last } else { first }, if first >= last { 0 } else { first + 1 }],
            // Beyond an edge a mirror shows the texel at the edge again.
            Self::Mirror | Self::Clamp => [first.max(0), (first + 1).min(last)],
        };
        // Rounding, and coordinates that are not finite, stay inside.
        (texels.map(|texel| texel.clamp(0, last) as usize), place - floor, slope)
    }
}
