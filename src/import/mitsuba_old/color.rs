//! The colors of old scenes: `<rgb>`, `<srgb>`, `<spectrum>` and `<blackbody>`, all as Mitsuba's RGB mode reads them.

use std::sync::Arc;

use super::super::values::{self, Refusal, shown};
use super::super::xml_element::Attributes;
use super::spectrum;
use crate::scene::bundle::text_of;
use crate::scene::error::{Location, SceneError, shown_number};

/// The tags of colors.
pub(in super::super) const TAGS: [&str; 4] = ["rgb", "srgb", "spectrum", "blackbody"];

/// The attributes that a color may have beside its name.
pub(in super::super) fn attributes(tag: &str) -> &'static [&'static str] {
    match tag {
        "rgb" => &["value", "intent"],
        "srgb" => &["value"],
        "spectrum" => &["value", "filename", "intent"],
        _ => &["temperature", "scale", "multiplier"],
    }
}

/// A color, and whether it stands for a spectrum.
pub(in super::super) struct Color {
    pub rgb: [f64; 3],
    pub from_spectrum: bool,
}

/// Reads a color. `file` gives the content of the file that a `<spectrum>` names.
///
/// # Errors
/// When the text is no color; whatever `file` fails with.
pub(in super::super) fn read(
    tag: &str,
    attributes: &Attributes<'_>,
    place: &Location,
    file: impl FnOnce(&str) -> Result<Arc<[u8]>, SceneError>,
) -> Result<Color, SceneError> {
    let refused = |(problem, remedy): Refusal| SceneError::new(place, format!("<{tag}>: {problem}"), remedy);
    let plain = |rgb| Color { rgb, from_spectrum: false };
    match (tag, attributes.get("value"), attributes.get("filename")) {
        ("rgb", Some(text), _) => rgb(text).map(plain).map_err(refused),
        ("srgb", Some(text), _) => rgb(text).map(|rgb| plain(rgb.map(values::linear_from_srgb))).map_err(refused),
        ("spectrum", Some(text), None) if text.contains(':') => points(text.split([' ', ','])).map_err(refused),
        ("spectrum", Some(text), None) => rgb(text).map(plain).map_err(refused),
        ("spectrum", None, Some(name)) => {
            let content = file(name)?;
            let text = text_of(&content);
            let lines = text.lines().filter(|line| !line.trim_start().starts_with('#'));
            points(lines).map_err(refused)
        }
        ("spectrum", ..) => Err(refused(("give either a value or a filename".to_owned(), ""))),
        ("blackbody", ..) => black_body(attributes).map_err(refused),
        _ => Err(refused(("there is no value".to_owned(), "write value=\"red, green, blue\""))),
    }
}

/// Three numbers, one for grey, or `#rrggbb`; the digits are not decoded here.
fn rgb(text: &str) -> Result<[f64; 3], Refusal> {
    let remedy = "write \"red, green, blue\", one number for grey, or #rrggbb";
    let refusal = || (format!("{} is not a color", shown(text)), remedy);
    match text.trim().strip_prefix('#') {
        None => values::spread(&values::floats(text)?).ok_or_else(refusal),
        Some(digits) if digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()) => {
            let code = u32::from_str_radix(digits, 16).map_err(|_| refusal())?;
            Ok([16, 8, 0].map(|shift| f64::from(code >> shift & 0xff) / 255.0))
        }
        Some(_) => Err(refusal()),
    }
}

/// A spectrum of points such as `400:0.5` or `400 0.5`.
fn points<'a>(parts: impl Iterator<Item = &'a str>) -> Result<Color, Refusal> {
    let remedy = "write wavelengths in nm and values, for example \"400:0.5, 700:0.8\"";
    let mut points = Vec::new();
    for part in parts.map(str::trim).filter(|part| !part.is_empty()) {
        let numbers: Vec<&str> = part.split([':', ' ', '\t']).filter(|number| !number.is_empty()).collect();
        let [wavelength, value] = numbers.as_slice() else {
            return Err((format!("{} is not a point of a spectrum", shown(part)), remedy));
        };
        points.push((values::float(wavelength)?, values::float(value)?));
    }
    if points.is_empty() || !points.windows(2).all(|pair| pair[0].0 < pair[1].0) {
        return Err(("the wavelengths of the spectrum do not increase".to_owned(), remedy));
    }
    let rgb = spectrum::to_rgb(|wavelength| spectrum::interpolate(&points, wavelength));
    Ok(Color { rgb, from_spectrum: true })
}

fn black_body(attributes: &Attributes<'_>) -> Result<Color, Refusal> {
    let remedy = "write temperature=\"5000K\"";
    let Some(text) = attributes.get("temperature") else {
        return Err(("there is no temperature".to_owned(), remedy));
    };
    let temperature = values::float(text.trim().trim_end_matches(['k', 'K']))?;
    if !(temperature > 0.0 && temperature.is_finite()) {
        return Err((format!("the temperature is {} K", shown_number(temperature)), remedy));
    }
    let scale = attributes.get("scale").or_else(|| attributes.get("multiplier")).map_or(Ok(1.0), values::float)?;
    let rgb = spectrum::to_rgb(|wavelength| spectrum::black_body(wavelength, temperature));
    Ok(Color { rgb: rgb.map(|channel| channel * scale), from_spectrum: true })
}
