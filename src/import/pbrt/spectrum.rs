//! Colors: `rgb`, `blackbody`, and spectra, as linear Rec. 709.

use super::super::mitsuba_old::spectrum::{black_body, interpolate, to_rgb};
use super::super::values::shown;
use super::output::Output;
use super::parameters::{Parameter, Values};
use crate::scene::bundle::text_of;
use crate::scene::error::{SceneError, shown_number};
use crate::scene::material::measured_metals::METALS;

/// What a spectrum is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Purpose {
    /// A share of light; 1 everywhere is white.
    Reflectance,
    /// Light. pbrt gives emitted spectra a luminance of 1 before it scales them, and rgb the white D65.
    Emission,
    /// An index of refraction.
    Index,
}

/// The yellow line of helium, at which single indices of refraction are given, nm.
const HELIUM_LINE: f64 = 587.56;

/// Brass, which Mitsuba has not among its metals: eta, k.
const BRASS: [[f64; 3]; 2] = [[0.444, 0.527, 1.094], [3.695, 2.765, 1.829]];

/// pbrt's glasses by their index of refraction at [`HELIUM_LINE`].
const GLASSES: [(&str, f64); 10] = [
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.6700),
    ("glass-FK51A", 1.4866),
    ("glass-LASF9", 1.8503),
    ("glass-F5", 1.6727),
    ("glass-SF5", 1.6727),
    ("glass-F10", 1.7283),
    ("glass-SF10", 1.7283),
    ("glass-F11", 1.7847),
    ("glass-SF11", 1.7847),
];

/// Reads a color.
///
/// # Errors
/// When it is malformed, negative, or a file that cannot be read.
pub(super) fn read(parameter: &Parameter, purpose: Purpose, output: &mut Output<'_>) -> Result<[f64; 3], SceneError> {
    let color = match (parameter.kind.as_str(), &parameter.values) {
        ("rgb" | "color", _) => parameter.triple()?,
        ("float" | "integer", _) => [parameter.number()?; 3],
        ("blackbody", _) => {
            let temperature = parameter.number()?;
            if temperature.is_nan() || temperature <= 0.0 {
                return Err(parameter
                    .error(format!("a black body of {} K", shown_number(temperature)), "give a temperature in K"));
            }
            match purpose {
                Purpose::Emission => of_luminance_1(to_rgb(|wavelength| black_body(wavelength, temperature))),
                // pbrt's black bodies have a largest value of 1 [Wien's displacement law].
                Purpose::Reflectance | Purpose::Index => {
                    let peak = black_body(2.897_771_955e6 / temperature, temperature);
                    relative_to_white(|wavelength| black_body(wavelength, temperature) / peak)
                }
            }
        }
        ("spectrum", Values::Numbers(_)) => points(parameter, parameter.numbers(2)?, purpose, output)?,
        ("spectrum", Values::Texts(_)) => named(parameter, parameter.text()?, purpose, output)?,
        (kind, _) => return Err(parameter.error(format!("{kind} is no type of a color"), "write \"rgb\" and its name")),
    };
    match color.into_iter().find(|channel| !(0.0..1e30).contains(channel)) {
        None => Ok(color),
        Some(channel) => {
            let problem = format!("a channel of the color is {channel:e}");
            Err(parameter.error(problem, "give numbers of at least 0 and below 1e30"))
        }
    }
}

/// The luminance of linear Rec. 709.
pub(super) fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// Colors outside of Rec. 709, as of cool black bodies, are the nearest of its surface.
fn of_luminance_1(rgb: [f64; 3]) -> [f64; 3] {
    let rgb = rgb.map(|channel| channel.max(0.0));
    let luminance = luminance(rgb);
    if luminance > 0.0 { rgb.map(|channel| channel / luminance) } else { [0.0; 3] }
}

/// The color of a reflectance under white light.
fn relative_to_white(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let (color, white) = (to_rgb(spectrum), to_rgb(|_| 1.0));
    std::array::from_fn(|channel| (color[channel] / white[channel]).clamp(0.0, 1.0))
}

/// A spectrum of wavelengths in nm and values.
fn points(
    parameter: &Parameter,
    numbers: &[f64],
    purpose: Purpose,
    output: &mut Output<'_>,
) -> Result<[f64; 3], SceneError> {
    let points: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    if !points.windows(2).all(|pair| pair[0].0 < pair[1].0) {
        return Err(parameter.error("the wavelengths do not increase", "write wavelengths in nm and values in turn"));
    }
    let subject = format!("the spectrum {}", shown(&parameter.name));
    output.approximated(&parameter.place, subject, "a color takes its place");
    Ok(match purpose {
        Purpose::Emission => of_luminance_1(to_rgb(|wavelength| interpolate(&points, wavelength))),
        Purpose::Reflectance => relative_to_white(|wavelength| interpolate(&points, wavelength)),
        Purpose::Index => [interpolate(&points, HELIUM_LINE); 3],
    })
}

/// One of pbrt's own spectra, or a file of points.
fn named(parameter: &Parameter, name: &str, purpose: Purpose, output: &mut Output<'_>) -> Result<[f64; 3], SceneError> {
    if let Some((metal, part)) = name.strip_prefix("metal-").and_then(|rest| rest.rsplit_once('-'))
        && let Some(part) = ["eta", "k"].iter().position(|known| *known == part)
    {
        let measured = METALS.iter().find(|(known, ..)| *known == metal);
        let measured = measured.map(|(_, eta, k)| [eta, k][part].map(f64::from));
        let brass = (metal == "CuZn").then_some(BRASS[part]);
        return measured.or(brass).ok_or_else(|| {
            parameter.error(format!("there is no metal {}", shown(metal)), "give eta and k as \"rgb\"")
        });
    }
    if let Some((_, index)) = GLASSES.iter().find(|(known, _)| *known == name) {
        output.approximated(&parameter.place, format!("the glass {}", shown(name)), "it has no dispersion");
        return Ok([*index; 3]);
    }
    if name.starts_with("stdillum-") || name.starts_with("illum-") {
        output.approximated(&parameter.place, format!("the spectrum {}", shown(name)), "white takes its place");
        return Ok([1.0; 3]);
    }
    let content = output.read(name, &parameter.place)?;
    output.includes.push((name.to_owned(), parameter.place.clone()));
    let text = text_of(&content);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let numbers: Result<Vec<f64>, _> = lines.flat_map(str::split_whitespace).map(str::parse::<f64>).collect();
    match numbers {
        Ok(numbers) if numbers.len() >= 2 && numbers.len().is_multiple_of(2) => {
            points(parameter, &numbers, purpose, output)
        }
        _ => Err(parameter.error(format!("file {} is no spectrum", shown(name)), "write wavelengths and values")),
    }
}
