//! Textures, and parameters that are a color, a number, or a texture.
//!
//! pbrt looks images up with v from their bottom, photonfarm from their top. Meshes are imported with 1 - v, which is
//! also what photonfarm's spheres have; textures therefore see pbrt's u and this program's v = 1 - v.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::super::resolve::resolve;
use super::super::values::shown;
use super::output::Output;
use super::parameters::{Parameter, Parameters};
use super::spectrum::{self, Purpose};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{SceneError, nearest_defined_name, nearest_name};
use crate::scene::texture::{Texture, TextureReader};

/// The value of a parameter: the same everywhere, or varying over a surface.
#[derive(Clone, Debug)]
pub(super) enum ColorOrTexture {
    Color([f64; 3]),
    /// The id of a texture.
    Texture(String),
}

impl ColorOrTexture {
    /// Whether it is a texture.
    pub(super) fn is_texture(&self) -> bool {
        matches!(self, Self::Texture(_))
    }

    /// Whether it is 1 everywhere.
    pub(super) fn is_one(&self) -> bool {
        matches!(self, Self::Color([1.0, ..]))
    }

    /// Gives it to `draft` as the parameter `name`.
    pub(super) fn put(&self, draft: Draft, name: &str) -> Draft {
        match self {
            Self::Color(rgb) => draft.with_rgb(name, *rgb),
            Self::Texture(id) => draft.with_named_reference(name, id),
        }
    }

    /// The same as a number.
    pub(super) fn put_number(&self, draft: Draft, name: &str) -> Draft {
        match self {
            Self::Color([number, ..]) => draft.with_float(name, *number),
            Self::Texture(id) => draft.with_named_reference(name, id),
        }
    }

    /// `factor` times it.
    pub(super) fn scaled(
        &self,
        factor: [f64; 3],
        parameters: &Parameters,
        output: &mut Output<'_>,
    ) -> Result<Self, SceneError> {
        Ok(match self {
            Self::Color(rgb) => Self::Color(std::array::from_fn(|channel| rgb[channel] * factor[channel])),
            Self::Texture(_) if factor == [1.0; 3] => self.clone(),
            Self::Texture(id) => {
                let draft = Draft::new(PluginClass::Texture, "scale", &parameters.place).with_rgb("scale", factor);
                let scaled = output.define("texture", "scaled", draft.with_reference(id))?;
                if output.bright.contains(id) || factor.iter().any(|channel| *channel > 1.0) {
                    output.bright.insert(scaled.clone());
                }
                Self::Texture(scaled)
            }
        })
    }
}

/// The textures by their names; those of numbers and those of spectra are apart.
#[derive(Default)]
pub(super) struct Textures {
    floats: HashMap<String, ColorOrTexture>,
    spectra: HashMap<String, ColorOrTexture>,
}

const CLASSES: [&str; 12] = [
    "constant",
    "scale",
    "imagemap",
    "checkerboard",
    "mix",
    "directionmix",
    "bilerp",
    "dots",
    "fbm",
    "marble",
    "wrinkled",
    "windy",
];

impl Textures {
    /// The color or texture `name`; a texture is found among those of spectra.
    pub(super) fn color(
        &self,
        parameters: &Parameters,
        name: &str,
        output: &mut Output<'_>,
    ) -> Result<Option<ColorOrTexture>, SceneError> {
        let Some(parameter) = parameters.find(name) else { return Ok(None) };
        if parameter.kind == "texture" {
            return Self::named(&self.spectra, parameter).map(Some);
        }
        spectrum::read(parameter, Purpose::Reflectance, output).map(|rgb| Some(ColorOrTexture::Color(rgb)))
    }

    /// The number or texture `name`.
    pub(super) fn number(&self, parameters: &Parameters, name: &str) -> Result<Option<ColorOrTexture>, SceneError> {
        match parameters.find(name) {
            None => Ok(None),
            Some(parameter) if parameter.kind == "texture" => Self::named(&self.floats, parameter).map(Some),
            Some(parameter) => Ok(Some(ColorOrTexture::Color([parameter.number()?; 3]))),
        }
    }

    fn named(textures: &HashMap<String, ColorOrTexture>, parameter: &Parameter) -> Result<ColorOrTexture, SceneError> {
        let name = parameter.text()?;
        textures.get(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = textures.keys().map(String::as_str).collect();
            let mut known: Vec<&str> = known.into_iter().filter(|name| name.len() < 80).collect();
            known.sort_unstable();
            let problem = format!("there is no texture {} of this type", shown(name));
            parameter.error(problem, &nearest_defined_name(name, &known, "define it with Texture first"))
        })
    }

    /// Follows a `Texture` directive.
    pub(super) fn define(
        &mut self,
        [name, kind, class]: [&str; 3],
        parameters: &Parameters,
        output: &mut Output<'_>,
    ) -> Result<(), SceneError> {
        let is_float = match kind {
            "float" => true,
            "spectrum" | "color" => false,
            _ => {
                let problem = format!("there are no textures of type {}", shown(kind));
                return Err(SceneError::new(&parameters.place, problem, nearest_name(kind, &["float", "spectrum"])));
            }
        };
        let value = self.read(class, is_float, parameters, output)?;
        output.report_unused(&format!("texture {}", shown(class)), parameters)?;
        let textures = if is_float { &mut self.floats } else { &mut self.spectra };
        if textures.insert(name.to_owned(), value).is_none() {
            return Ok(());
        }
        let problem = format!("there are two textures {}", shown(name));
        Err(SceneError::new(&parameters.place, problem, "give each a name of its own"))
    }

    fn read(
        &self,
        class: &str,
        is_float: bool,
        parameters: &Parameters,
        output: &mut Output<'_>,
    ) -> Result<ColorOrTexture, SceneError> {
        let part = |name: &str, default: f64, output: &mut Output<'_>| {
            let given = match is_float {
                true => self.number(parameters, name)?,
                false => self.color(parameters, name, output)?,
            };
            Ok::<ColorOrTexture, SceneError>(given.unwrap_or(ColorOrTexture::Color([default; 3])))
        };
        let replaced = |value: ColorOrTexture, instead: &str, output: &mut Output<'_>| {
            output.approximated(&parameters.place, format!("texture {}", shown(class)), instead);
            Ok(value)
        };
        match class {
            "constant" => part("value", 1.0, output),
            "scale" => {
                let (base, factor) = (part("tex", 1.0, output)?, self.number(parameters, "scale")?);
                match (base, factor.unwrap_or(ColorOrTexture::Color([1.0; 3]))) {
                    (base, ColorOrTexture::Color(factor)) => base.scaled(factor, parameters, output),
                    (ColorOrTexture::Color(factor), base) => base.scaled(factor, parameters, output),
                    (base, _) => replaced(base, "its scale, a texture too, counts as 1", output),
                }
            }
            "imagemap" => image(parameters, output),
            "checkerboard" => {
                let fields = [part("tex1", 1.0, output)?, part("tex2", 0.0, output)?];
                if parameters.integer("dimension")?.unwrap_or(2) != 2 {
                    let [field, _] = fields;
                    return replaced(field, "in three dimensions, its first one takes its place", output);
                }
                checkerboard(fields, parameters, output)
            }
            "mix" | "directionmix" => {
                let (first, second) = (part("tex1", 0.0, output)?, part("tex2", 1.0, output)?);
                let amount = self.number(parameters, "amount")?.unwrap_or(ColorOrTexture::Color([0.5; 3]));
                match (first, second, amount) {
                    (
                        ColorOrTexture::Color(first),
                        ColorOrTexture::Color(second),
                        ColorOrTexture::Color([amount, ..]),
                    ) if class == "mix" => {
                        let mixed = |channel: usize| first[channel] * (1.0 - amount) + second[channel] * amount;
                        Ok(ColorOrTexture::Color(std::array::from_fn(mixed)))
                    }
                    (_, second, ColorOrTexture::Color([amount, ..])) if amount > 0.5 => {
                        replaced(second, "\"tex2\" takes its place", output)
                    }
                    (first, ..) => replaced(first, "\"tex1\" takes its place", output),
                }
            }
            "bilerp" => replaced(part("v00", 0.0, output)?, "its color at (0, 0) takes its place", output),
            "dots" => replaced(part("outside", 0.0, output)?, "its color outside of the dots takes its place", output),
            "fbm" | "marble" | "wrinkled" | "windy" => {
                replaced(ColorOrTexture::Color([0.5; 3]), "grey takes its place", output)
            }
            _ => {
                let problem = format!("there is no texture {}", shown(class));
                Err(SceneError::new(&parameters.place, problem, nearest_name(class, &CLASSES)))
            }
        }
    }
}

/// Scale and offset of texture coordinates: pbrt's (u, v) that a texture looks at are `scale`·(u, v) + `offset`.
fn mapping(parameters: &Parameters, output: &mut Output<'_>) -> Result<[DVec3; 2], SceneError> {
    if let Some(mapping) = parameters.text("mapping")?
        && mapping != "uv"
    {
        let subject = format!("the mapping {} of a texture", shown(mapping));
        output.approximated(&parameters.place, subject, "texture coordinates take its place");
    }
    let pair = |names: [&str; 2], default: f64| -> Result<DVec3, SceneError> {
        let [u, v] = names.map(|name| parameters.float(name));
        Ok(DVec3::new(u?.unwrap_or(default), v?.unwrap_or(default), 0.0))
    };
    Ok([pair(["uscale", "vscale"], 1.0)?, pair(["udelta", "vdelta"], 0.0)?])
}

fn map(scale: DVec3, offset: DVec3) -> DMat4 {
    DMat4::from_translation(offset.with_z(0.0)) * DMat4::from_scale(scale.with_z(1.0))
}

fn image(parameters: &Parameters, output: &mut Output<'_>) -> Result<ColorOrTexture, SceneError> {
    let place = &parameters.place;
    let Some(name) = parameters.text("filename")? else {
        return Err(SceneError::new(place, "an imagemap has no \"filename\"", "name the image"));
    };
    let mut draft = Draft::new(PluginClass::Texture, "bitmap", place).with_text("filename", name);
    match parameters.text("encoding")?.unwrap_or("sRGB") {
        "sRGB" => {}
        "linear" => draft = draft.with_flag("raw", true),
        other => output.approximated(place, format!("the encoding {}", shown(other)), "sRGB takes its place"),
    }
    match parameters.text("wrap")?.unwrap_or("repeat") {
        "repeat" => {}
        "black" => {
            output.approximated(place, "the wrap mode \"black\"", "\"clamp\" takes its place");
            draft = draft.with_text("wrap_mode", "clamp");
        }
        "clamp" => draft = draft.with_text("wrap_mode", "clamp"),
        other => {
            let remedy = nearest_name(other, &["repeat", "black", "clamp"]);
            return Err(SceneError::new(place, format!("there is no wrap mode {}", shown(other)), remedy));
        }
    }
    match parameters.text("filter")?.unwrap_or("bilinear") {
        "point" => draft = draft.with_text("filter_type", "nearest"),
        // They differ from bilinear where texels are smaller than pixels only.
        "bilinear" | "trilinear" | "ewa" | "EWA" => {}
        other => output.approximated(place, format!("the filter {}", shown(other)), "bilinear takes its place"),
    }
    parameters.pass_over(&["maxanisotropy"]);
    // The row is 1 - (scale·(1 - v) + offset) of the v here.
    let [scale, offset] = mapping(parameters, output)?;
    if scale.truncate() != glam::DVec2::ONE || offset != DVec3::ZERO {
        let to_uv = map(scale, DVec3::new(offset.x, 1.0 - scale.y - offset.y, 0.0));
        draft = draft.with("to_uv", Value::Transform(to_uv));
    }
    let factor = parameters.float("scale")?.unwrap_or(1.0);
    let id = output.define("texture", "image", draft)?;
    if is_bright(name) {
        output.bright.insert(id.clone());
    }
    if !parameters.flag("invert")?.unwrap_or(false) {
        return ColorOrTexture::Texture(id).scaled([factor; 3], parameters, output);
    }
    let inverted = Draft::new(PluginClass::Texture, "scale", place).with_float("scale", factor);
    let inverted = inverted.with_flag("invert", true).with_reference(&id);
    Ok(ColorOrTexture::Texture(output.define("texture", "inverted", inverted)?))
}

/// Whether an image file may hold values above 1.
fn is_bright(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    [".exr", ".hdr", ".pfm"].iter().any(|extension| name.ends_with(extension))
}

/// An image over the whole of a shape.
///
/// # Errors
/// When the file is not there.
pub(super) fn plain_image(name: &str, parameters: &Parameters, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    output.bundle.read(name, &parameters.place)?;
    output.includes.push((name.to_owned(), parameters.place.clone()));
    Ok(Draft::new(PluginClass::Texture, "bitmap", &parameters.place).with_text("filename", name))
}

/// A texture, read.
///
/// # Errors
/// When its image cannot be read.
pub(super) fn in_memory(texture: &Draft, output: &Output<'_>) -> Result<Texture, SceneError> {
    let node = Arc::new(resolve(texture, &[])?);
    TextureReader::new(output.bundle).texture(&node)
}

/// The mean color of a texture.
///
/// # Errors
/// When its image cannot be read, or is black.
pub(super) fn mean_color(texture: &Draft, output: &Output<'_>) -> Result<[f64; 3], SceneError> {
    let mean = in_memory(texture, output)?.mean();
    if mean.max_element() > 0.0 {
        return Ok(mean.to_array().map(f64::from));
    }
    Err(SceneError::new(&texture.location, "the image of a light is black", "give an image with light in it"))
}

/// pbrt's fields are 1 wide, photonfarm's 1/2.
fn checkerboard(
    fields: [ColorOrTexture; 2],
    parameters: &Parameters,
    output: &mut Output<'_>,
) -> Result<ColorOrTexture, SceneError> {
    let [scale, offset] = mapping(parameters, output)?;
    let to_uv = map(0.5 * scale * DVec3::new(1.0, -1.0, 1.0), 0.5 * DVec3::new(offset.x, scale.y + offset.y, 0.0));
    let draft = Draft::new(PluginClass::Texture, "checkerboard", &parameters.place).with_transform("to_uv", to_uv);
    let [first, second] = fields;
    let draft = second.put(first.put(draft, "color0"), "color1");
    Ok(ColorOrTexture::Texture(output.define("texture", "checkerboard", draft)?))
}
