//! Textures: what varies over a surface. Every parameter that may be textured is a [`Texture`]; most are constant. One file
//! per kind, one row in `textures!`; [`TextureReader`] reads them.

pub(crate) mod bitmap;
pub(crate) mod checkerboard;
mod image_file;
pub(crate) mod mesh_attribute;
pub(crate) mod raster;
pub(crate) mod reader;
pub(crate) mod scale;
mod to_uv;

use std::sync::Arc;

use super::error::SceneError;
use super::fields::Fields;
use super::geometry::TexturePoint;
use super::unsupported::unknown_plugin;
use crate::math::{Rgb, Vec2, color};

pub(crate) use bitmap::Bitmap;
pub(crate) use checkerboard::Checkerboard;
pub(crate) use mesh_attribute::{MeshAttribute, OfMesh};
pub(crate) use raster::Raster;
pub(crate) use reader::TextureReader;
pub(crate) use scale::Scale;

/// The plugin of [`Texture::Constant`]: a color, vector or number `value`, 1 by default.
const CONSTANT: &str = "rawconstant";

/// Reads the parameters of a texture plugin.
type ReadTexture = fn(&mut Fields<'_>, &mut TextureReader<'_>) -> Result<Texture, SceneError>;

macro_rules! textures {
    ($($kind:ident = $name:literal),+ $(,)?) => {
        /// A color or a number over a surface.
        #[derive(Clone, Debug)]
        pub enum Texture {
            /// The same everywhere.
            Constant(Rgb),
            $(#[doc = concat!("See [`", stringify!($kind), "`].")] $kind(Arc<$kind>)),+
        }

        /// Texture plugins by name.
        const TEXTURES: &[(&str, ReadTexture)] =
            &[$(($name, |fields, textures| Ok(Texture::$kind(Arc::new($kind::read(fields, textures)?))))),+];

        impl Texture {
            /// The color at `point`; linear Rec. 709.
            #[inline]
            pub fn color(&self, point: &TexturePoint) -> Rgb {
                match self {
                    Self::Constant(color) => *color,
                    $(Self::$kind(texture) => texture.color(point)),+
                }
            }

            /// The derivatives of [`Texture::number`] by u and v.
            pub fn gradient(&self, point: &TexturePoint) -> Vec2 {
                match self {
                    Self::Constant(_) => Vec2::ZERO,
                    $(Self::$kind(texture) => texture.gradient(point)),+
                }
            }

            /// The mean color over texture space, or over what a mesh brings along.
            pub fn mean(&self) -> Rgb {
                match self {
                    Self::Constant(color) => *color,
                    $(Self::$kind(texture) => texture.mean()),+
                }
            }

            /// Bounds on every color that it takes, by channel: the smallest and the largest.
            pub fn range(&self) -> [Rgb; 2] {
                match self {
                    Self::Constant(color) => [*color; 2],
                    $(Self::$kind(texture) => texture.range()),+
                }
            }
        }
    };
}

textures! {
    Bitmap = "bitmap",
    Checkerboard = "checkerboard",
    OfMesh = "mesh_attribute",
    Scale = "scale",
}

impl Texture {
    /// The same grey everywhere.
    pub fn grey(value: f32) -> Self {
        Self::Constant(Rgb::splat(value))
    }

    /// The number at `point`: the luminance of a color.
    #[inline]
    pub fn number(&self, point: &TexturePoint) -> f32 {
        match self {
            Self::Checkerboard(fields) => fields.number(point),
            other => number_of(other.color(point)),
        }
    }

    /// Width and height in texels; of other textures than bitmaps 1 × 1.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Bitmap(bitmap) => bitmap.size(),
            _ => [1, 1],
        }
    }

    /// Whether it varies, so that surfaces need texture coordinates.
    pub fn varies(&self) -> bool {
        !matches!(self, Self::Constant(_))
    }
}

/// A grey is its own luminance to the last bit.
#[inline]
fn number_of(rgb: Rgb) -> f32 {
    if rgb.x == rgb.y && rgb.y == rgb.z { rgb.x } else { color::luminance(rgb) }
}

/// Reads the plugin at `fields` by its row of the table.
fn read_plugin(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Texture, SceneError> {
    let plugin = &fields.node().plugin;
    if plugin == CONSTANT {
        // Three numbers that are no color are a vector.
        let vector = if fields.is_vector("value") { fields.vector("value")? } else { None };
        let color = match vector {
            Some(vector) => vector.to_array(),
            None => fields.rgb("value")?.unwrap_or([1.0; 3]),
        };
        return Ok(Texture::Constant(Rgb::from_array(color.map(|channel| channel as f32))));
    }
    let Some((_, read)) = TEXTURES.iter().find(|(name, _)| name == plugin) else {
        let known: Vec<&str> = TEXTURES.iter().map(|(name, _)| *name).chain([CONSTANT]).collect();
        return Err(unknown_plugin(fields.node(), &known));
    };
    read(fields, textures)
}
