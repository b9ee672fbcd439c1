//! The spectra of Mitsuba 3: the colors that its RGB mode makes of them. What only its spectral modes can render
//! (`regular`, `irregular`, `blackbody`) becomes the color that those show.
//!
//! | form | color |
//! |---|---|
//! | `value="400:0.1, 500:0.2"`, `filename`, `regular`, `irregular` | of light as it is; of everything else in daylight |
//! | `value="0.5"` | of light that of equal energy, which is not white; of everything else grey |
//! | `blackbody` | of `temperature`, K, from `wavelength_min` to `wavelength_max`, nm |
//! | `d65`, `srgb` | `color`, times `scale` |
//! | `uniform`, `rawconstant` | `value` |

use super::draft::Draft;
use super::mitsuba_old::spectrum::{black_body, interpolate, reflectance_to_rgb, to_rgb};
use super::values::{self, Refusal, shown};
use crate::scene::bundle::text_of;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{SceneError, nearest_name};

/// The plugins that are spectra.
pub(super) const PLUGINS: [&str; 7] = ["blackbody", "d65", "irregular", "rawconstant", "regular", "srgb", "uniform"];

const PAIRS_REMEDY: &str = "write wavelengths in nm and values, for example \"400:0.5, 700:0.8\"";

/// What a spectrum belongs to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Light that is emitted.
    Emission,
    /// A share of light, from 0 to 1.
    Share,
    /// Any other number, for example a refractive index.
    Number,
}

impl Purpose {
    /// That of parameter `name` of a plugin.
    pub(super) fn of(class: PluginClass, name: &str) -> Self {
        let is_share = ["reflectance", "transmittance", "color", "opacity"].iter().any(|part| name.contains(part));
        match class {
            PluginClass::Emitter => Self::Emission,
            _ if is_share => Self::Share,
            _ => Self::Number,
        }
    }
}

/// Whether a spectrum in `parent` stays a texture: of a bumpmap and of textures the texture itself is the part, not a parameter.
pub(super) fn stays_texture(parent: &Draft) -> bool {
    parent.class == PluginClass::Texture || parent.plugin == "bumpmap"
}

/// The color of the points of a spectrum, of increasing wavelength.
fn of_points(points: &[(f64, f64)], purpose: Purpose) -> Result<[f64; 3], Refusal> {
    if points.len() < 2 || !points.windows(2).all(|pair| pair[0].0 < pair[1].0) {
        return Err(("the wavelengths of the spectrum do not increase".to_owned(), PAIRS_REMEDY));
    }
    let spectrum = |wavelength| interpolate(points, wavelength);
    Ok(match purpose {
        Purpose::Emission => to_rgb(spectrum),
        Purpose::Share => reflectance_to_rgb(spectrum).map(|channel| channel.min(1.0)),
        Purpose::Number => reflectance_to_rgb(spectrum),
    })
}

/// The text of a `value`: one number, or pairs of wavelength and value.
pub(super) fn text(text: &str, purpose: Purpose) -> Result<Value, Refusal> {
    if text.contains(':') {
        let parts = text.split(|letter: char| letter == ',' || letter.is_whitespace());
        return pairs(parts, ':', purpose).map(Value::Rgb);
    }
    match values::floats(text)?.as_slice() {
        [number] => Ok(Value::Rgb(of_number(*number, purpose))),
        _ => Err((format!("{} is not a spectrum", shown(text)), PAIRS_REMEDY)),
    }
}

/// The same value at all wavelengths.
pub(super) fn of_number(number: f64, purpose: Purpose) -> [f64; 3] {
    match purpose {
        Purpose::Emission => to_rgb(|_| 1.0).map(|channel| channel * number),
        Purpose::Share | Purpose::Number => [number; 3],
    }
}

/// The content of a spectrum's file: a wavelength and a value on each line.
pub(super) fn file(content: &[u8], purpose: Purpose) -> Result<Value, Refusal> {
    let content = text_of(content);
    let lines = content.lines().map(str::trim).filter(|line| !line.starts_with('#'));
    pairs(lines, ' ', purpose).map(Value::Rgb)
}

/// Pairs of numbers, as they stand in a dictionary.
pub(super) fn of_pairs(numbers: &[f64], purpose: Purpose) -> Result<[f64; 3], Refusal> {
    let points: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    of_points(&points, purpose)
}

fn pairs<'a>(parts: impl Iterator<Item = &'a str>, separator: char, purpose: Purpose) -> Result<[f64; 3], Refusal> {
    let mut points = Vec::new();
    for part in parts.filter(|part| !part.is_empty()) {
        let is_separator = |letter: char| letter == separator || (separator == ' ' && [',', '\t'].contains(&letter));
        let numbers: Vec<&str> = part.split(is_separator).filter(|number| !number.is_empty()).collect();
        let [wavelength, value] = numbers.as_slice() else {
            return Err((format!("{} is not a point of a spectrum", shown(part)), PAIRS_REMEDY));
        };
        points.push((values::float(wavelength)?, values::float(value)?));
    }
    of_points(&points, purpose)
}

/// The color of a plugin of [`PLUGINS`].
///
/// # Errors
/// On parameters that it does not have, lacks, or that make no spectrum.
pub(super) fn of_plugin(draft: &Draft, purpose: Purpose) -> Result<[f64; 3], SceneError> {
    let known: &[&str] = match draft.plugin.as_str() {
        "blackbody" => &["temperature", "wavelength_min", "wavelength_max"],
        "d65" => &["scale", "color", "value"],
        "irregular" => &["wavelengths", "values"],
        "regular" => &["wavelength_min", "wavelength_max", "values"],
        "srgb" => &["color", "value", "unbounded"],
        _ => &["value", "wavelength_min", "wavelength_max"],
    };
    if let Some(other) = draft.parameters.iter().find(|parameter| !known.contains(&parameter.name.as_str())) {
        let problem = format!("spectrum \"{}\" has no parameter \"{}\"", draft.plugin, other.name);
        return Err(SceneError::new(&other.location, problem, nearest_name(&other.name, known)));
    }
    let refused = |(problem, remedy): Refusal| SceneError::new(&draft.location, problem, remedy);
    let lacks = |name: &str| {
        let problem = format!("spectrum \"{}\" has no \"{name}\"", draft.plugin);
        SceneError::new(&draft.location, problem, "give it")
    };
    let get = |name: &str| draft.parameters.iter().find(|parameter| parameter.name == name).map(|found| &found.value);
    let number = |name: &str| match get(name) {
        Some(Value::Float(number)) => Some(*number),
        Some(Value::Integer(number)) => Some(*number as f64),
        _ => None,
    };
    let color = |name: &str| match get(name) {
        Some(Value::Rgb(rgb) | Value::Vector(rgb)) => Some(*rgb),
        _ => number(name).map(|grey| [grey; 3]),
    };
    let list = |name: &str| match get(name) {
        Some(Value::String(text)) => values::floats(text).map_err(refused),
        _ => Err(lacks(name)),
    };
    match draft.plugin.as_str() {
        "blackbody" => {
            let temperature =
                number("temperature").filter(|kelvin| *kelvin > 0.0).ok_or_else(|| lacks("temperature"))?;
            let first = number("wavelength_min").unwrap_or(0.0);
            let last = number("wavelength_max").unwrap_or(f64::INFINITY);
            Ok(to_rgb(|wavelength| match (first..=last).contains(&wavelength) {
                true => black_body(wavelength, temperature),
                false => 0.0,
            }))
        }
        "d65" => {
            let color = color("color").or_else(|| color("value")).unwrap_or([1.0; 3]);
            Ok(color.map(|channel| channel * number("scale").unwrap_or(1.0)))
        }
        "irregular" => {
            let points: Vec<(f64, f64)> = list("wavelengths")?.into_iter().zip(list("values")?).collect();
            of_points(&points, purpose).map_err(refused)
        }
        "regular" => {
            let first = number("wavelength_min").ok_or_else(|| lacks("wavelength_min"))?;
            let last = number("wavelength_max").ok_or_else(|| lacks("wavelength_max"))?;
            let values = list("values")?;
            let step = (last - first) / (values.len().max(2) - 1) as f64;
            let points: Vec<(f64, f64)> =
                values.iter().enumerate().map(|(index, value)| (first + step * index as f64, *value)).collect();
            of_points(&points, purpose).map_err(refused)
        }
        "srgb" => color("color").or_else(|| color("value")).ok_or_else(|| lacks("color")),
        _ => Ok(color("value").unwrap_or([1.0; 3])),
    }
}
