//! What the pixels of a scene see first.

use super::messages;
use super::{WireError, planes};
use crate::math::{Rgb, Vec3};
use crate::render::first_surface::FirstSurface;

/// Numbers a pixel.
const WORDS: usize = 7;

/// To the message.
pub fn encode(seen: &[FirstSurface]) -> messages::FirstSurfaces {
    let channel = |channel: usize| seen.iter().map(move |pixel| record(pixel)[channel]);
    let values: Vec<f32> = (0..WORDS).flat_map(channel).collect();
    messages::FirstSurfaces { pixels: planes::compress(&values).into() }
}

fn record(pixel: &FirstSurface) -> [f32; WORDS] {
    let ([r, g, b], [x, y, z]) = (pixel.albedo.to_array(), pixel.normal.to_array());
    [r, g, b, x, y, z, pixel.depth]
}

/// From the message, for a picture of `pixels` pixels; every number must be finite.
pub fn decode(message: &messages::FirstSurfaces, pixels: usize) -> Result<Vec<FirstSurface>, WireError> {
    let values = planes::decompress(&message.pixels, pixels.saturating_mul(WORDS))?;
    if let Some(wrong) = values.iter().find(|value| !value.is_finite()) {
        return Err(WireError::Impossible { field: "first surfaces", problem: format!("a value is {wrong}") });
    }
    let pixel = |pixel: usize| {
        let [r, g, b, x, y, z, depth] = std::array::from_fn(|channel| values[channel * pixels + pixel]);
        FirstSurface { albedo: Rgb::new(r, g, b), normal: Vec3::new(x, y, z), depth }
    };
    Ok((0..pixels).map(pixel).collect())
}
