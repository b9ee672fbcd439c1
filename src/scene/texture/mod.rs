//! Textures: what varies over a surface. Every parameter that may be textured is a [`Texture`]; most are constant.

use super::bundle::Bundle;
use super::error::SceneError;
use super::fields::Fields;
use crate::math::{Rgb, Vec2, color};

/// A color or a number over texture coordinates.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Constant(Rgb),
}

impl Texture {
    /// The same grey everywhere.
    pub fn grey(value: f32) -> Self {
        Self::Constant(Rgb::splat(value))
    }

    /// The color at `uv`; linear Rec. 709.
    #[inline]
    pub fn color(&self, _uv: Vec2) -> Rgb {
        match self {
            Self::Constant(color) => *color,
        }
    }

    /// The number at `uv`: the luminance of a color.
    #[inline]
    pub fn number(&self, uv: Vec2) -> f32 {
        match self {
            Self::Constant(color) if color.x == color.y && color.y == color.z => color.x,
            _ => color::luminance(self.color(uv)),
        }
    }

    /// Whether it varies, so that surfaces need texture coordinates.
    pub fn varies(&self) -> bool {
        match self {
            Self::Constant(_) => false,
        }
    }
}

/// Reads parameters that may be textures, and keeps what several of them share.
pub struct TextureReader<'a> {
    /// The scene's files.
    #[expect(dead_code, reason = "bitmaps read their files from here")]
    bundle: &'a Bundle,
}

impl<'a> TextureReader<'a> {
    /// A reader for a scene with these files.
    pub fn new(bundle: &'a Bundle) -> Self {
        Self { bundle }
    }

    /// A share of light within [0, 1] (more would make energy); `default` where it was not given.
    pub fn share(&mut self, fields: &mut Fields<'_>, name: &'static str, default: f32) -> Result<Texture, SceneError> {
        let texture = self.color(fields, name)?.unwrap_or(Texture::grey(default));
        match &texture {
            Texture::Constant(rgb) if rgb.max_element() > 1.0 => {
                let problem =
                    format!("\"{name}\" is {}, {}, {}: it would reflect more than arrives", rgb.x, rgb.y, rgb.z);
                Err(fields.error(name, problem, "give numbers from 0 to 1"))
            }
            Texture::Constant(_) => Ok(texture),
        }
    }

    /// A color of at least 0; `None` where it was not given.
    pub fn color(&mut self, fields: &mut Fields<'_>, name: &'static str) -> Result<Option<Texture>, SceneError> {
        let rgb = fields.rgb(name)?;
        Ok(rgb.map(|rgb| Texture::Constant(Rgb::from_array(rgb.map(|channel| channel as f32)))))
    }

    /// A number; `None` where it was not given. Its range is for the caller to check.
    pub fn number(&mut self, fields: &mut Fields<'_>, name: &'static str) -> Result<Option<Texture>, SceneError> {
        Ok(fields.float(name)?.map(|number| Texture::grey(number as f32)))
    }
}
