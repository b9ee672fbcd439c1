//! Textures: `bitmap` nodes that name an encoded image, and `scale` for the factor in front of it.

use std::collections::HashMap;

use glam::{DMat4, DVec4};

use super::super::draft::Draft;
use super::entry::Entry;
use super::uri::{self, Uri};
use super::{GENERATED_FOLDER, Input, Output, extensions};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// What the pixels of an image mean.
#[derive(Clone, Copy)]
pub(super) enum Meaning {
    /// Colors in sRGB.
    Color,
    /// Vectors, as they are.
    Vectors,
    /// Numbers, as they are, in one channel: `r`, `g`, `b` or `a`.
    Channel(&'static str),
}

/// A parameter that is a value or a texture.
#[derive(Clone)]
pub(super) enum Slot {
    Value(Value),
    Texture(Draft),
}

impl Slot {
    /// `texture` times `factor` (a float or a color), or the factor alone.
    pub(super) fn product(texture: Option<Draft>, factor: Value) -> Self {
        let is = |wanted: f64| match &factor {
            Value::Float(number) => *number == wanted,
            Value::Rgb(channels) => *channels == [wanted; 3],
            _ => false,
        };
        match texture {
            Some(texture) if is(1.0) => Self::Texture(texture),
            Some(texture) if !is(0.0) => {
                let scale = Draft::new(PluginClass::Texture, "scale", &texture.location);
                Self::Texture(scale.with("scale", factor).with_child("texture", texture))
            }
            _ => Self::Value(factor),
        }
    }

    /// Gives `plugin` the parameter `name`.
    pub(super) fn put(self, plugin: Draft, name: &str) -> Draft {
        match self {
            Self::Value(value) => plugin.with(name, value),
            Self::Texture(texture) => plugin.with_child(name, texture),
        }
    }
}

/// The images of a file that are in use, by index; `None` for those that cannot be read.
#[derive(Default)]
pub(super) struct Images {
    names: HashMap<usize, Option<String>>,
}

/// Reads the textures of one material.
pub(super) struct Textures<'r, 'a> {
    pub input: &'r Input<'a>,
    pub output: &'r mut Output,
    pub images: &'r mut Images,
    /// The set of texture coordinates that the material's first texture uses.
    pub set: Option<usize>,
    /// Whether the material is that of vertices with colors.
    pub colored: bool,
}

impl<'a> Textures<'_, 'a> {
    /// The texture that the texture info `key` of `owner` refers to.
    ///
    /// # Errors
    /// On references to nothing, and images that cannot be named.
    pub(super) fn read(&mut self, owner: &Entry<'a>, key: &str, meaning: Meaning) -> Result<Option<Draft>, SceneError> {
        let Some(info) = owner.child(key)? else { return Ok(None) };
        extensions::report_unread(&info, self.output)?;
        let Some((_, texture)) = info.reference("index", "textures")? else {
            return Err(info.error("the texture has no \"index\"", "export the scene again"));
        };
        extensions::report_unread(&texture, self.output)?;
        let name = match texture.reference("source", "images")? {
            Some((index, image)) => self.image(index, &image)?,
            None => None,
        };
        let Some(name) = name else {
            let explanation = "it has no image of a supported format";
            self.output.notices.add(Notice::ignored(&info.location(), "a texture", explanation));
            return Ok(None);
        };
        let transform = info.extension("KHR_texture_transform")?;
        let overridden = transform.as_ref().map(|transform| transform.integer("texCoord")).transpose()?.flatten();
        let set = overridden.or(info.integer("texCoord")?).unwrap_or(0);
        if *self.set.get_or_insert(set) != set {
            let explanation = "all textures of a material use the coordinates of the first";
            self.output.notices.add(Notice::approximated(
                &info.location(),
                "a second set of texture coordinates",
                explanation,
            ));
        }
        let mut bitmap =
            Draft::new(PluginClass::Texture, "bitmap", &info.location()).with("filename", Value::String(name));
        if !matches!(meaning, Meaning::Color) {
            bitmap = bitmap.with("raw", Value::Boolean(true));
        }
        if let Meaning::Channel(channel) = meaning {
            bitmap = bitmap.with("channel", Value::String(channel.to_owned()));
        }
        bitmap = self.sampled(bitmap, &texture)?;
        Ok(Some(match transform {
            Some(transform) => bitmap.with("to_uv", Value::Transform(to_uv(&transform)?)),
            None => bitmap,
        }))
    }

    /// Adds what the texture's sampler says about its border and its filter.
    fn sampled(&mut self, mut bitmap: Draft, texture: &Entry<'a>) -> Result<Draft, SceneError> {
        let Some((_, sampler)) = texture.reference("sampler", "samplers")? else { return Ok(bitmap) };
        let wrap = |key: &str| match sampler.integer(key)? {
            None | Some(10497) => Ok("repeat"),
            Some(33071) => Ok("clamp"),
            Some(33648) => Ok("mirror"),
            Some(other) => Err(sampler.error(format!("there is no {key} {other}"), "give 10497, 33071 or 33648")),
        };
        let [u, v] = [wrap("wrapS")?, wrap("wrapT")?];
        if u != v {
            let explanation = format!("\"{u}\" holds for both directions");
            self.output.notices.add(Notice::approximated(
                &sampler.location(),
                "different wrapS and wrapT",
                explanation,
            ));
        }
        if u != "repeat" {
            bitmap = bitmap.with("wrap_mode", Value::String(u.to_owned()));
        }
        if sampler.integer("magFilter")? == Some(9728) {
            bitmap = bitmap.with("filter_type", Value::String("nearest".to_owned()));
        }
        Ok(bitmap)
    }

    /// The name of an image's file in the bundle; images inside of buffers and URIs become files.
    fn image(&mut self, index: usize, image: &Entry<'a>) -> Result<Option<String>, SceneError> {
        if let Some(name) = self.images.names.get(&index) {
            return Ok(name.clone());
        }
        let content = match uri::read(image)? {
            Some(Uri::File(name)) => {
                self.images.names.insert(index, Some(name.clone()));
                return Ok(Some(name));
            }
            Some(Uri::Data(text)) => {
                self.output.budget.take(uri::decoded_size(text), image)?;
                Some(uri::decode(text, image)?)
            }
            None => match image.reference("bufferView", "bufferViews")? {
                Some((_, view)) => {
                    let bytes = self.input.buffers.view(&view)?;
                    self.output.budget.take(bytes.len() as u64, image)?;
                    Some(bytes.to_vec())
                }
                None => None,
            },
        };
        let name = content.and_then(|content| {
            let name = format!("{GENERATED_FOLDER}image_{index}.{}", extension_of(&content)?);
            self.output.made.files.insert(name.clone(), content.into());
            Some(name)
        });
        self.images.names.insert(index, name.clone());
        Ok(name)
    }
}

/// The usual extension of a file with this content; nothing for other formats than glTF's two.
fn extension_of(content: &[u8]) -> Option<&'static str> {
    match content {
        [0x89, b'P', b'N', b'G', ..] => Some("png"),
        [0xff, 0xd8, ..] => Some("jpg"),
        _ => None,
    }
}

/// KHR_texture_transform: scale, then rotation, then offset of the coordinates, whose v grows downwards; there a
/// rotation counter-clockwise has the signs below (the specification's listing has them the other way round, which its
/// issue 1563 calls wrong).
fn to_uv(transform: &Entry<'_>) -> Result<DMat4, SceneError> {
    let [x, y] = transform.numbers("offset")?.unwrap_or([0.0; 2]);
    let [u, v] = transform.numbers("scale")?.unwrap_or([1.0; 2]);
    let (sine, cosine) = libm::sincos(transform.number("rotation")?.unwrap_or(0.0));
    let columns = [DVec4::new(cosine * u, -sine * u, 0.0, 0.0), DVec4::new(sine * v, cosine * v, 0.0, 0.0)];
    Ok(DMat4::from_cols(columns[0], columns[1], DVec4::Z, DVec4::new(x, y, 0.0, 1.0)))
}
