//! What the pixels of a scene see first.

use super::messages;
use super::{WireError, planes};
use crate::math::{Rgb, Vec3};
use crate::render::first_surface::FirstSurface;

/// Numbers a pixel.
const WORDS: usize = 10;

/// To the message.
pub fn encode(seen: &[FirstSurface]) -> messages::FirstSurfaces {
    let channel = |channel: usize| seen.iter().map(move |pixel| record(pixel)[channel]);
    let values: Vec<f32> = (0..WORDS).flat_map(channel).collect();
    messages::FirstSurfaces { pixels: planes::compress(&values).into() }
}

fn record(pixel: &FirstSurface) -> [f32; WORDS] {
    let FirstSurface { albedo, normal, depth, position } = pixel;
    [albedo.x, albedo.y, albedo.z, normal.x, normal.y, normal.z, *depth, position.x, position.y, position.z]
}

/// From the message, for a picture of `pixels` pixels; every number must be finite.
pub fn decode(message: &messages::FirstSurfaces, pixels: usize) -> Result<Vec<FirstSurface>, WireError> {
    let values = planes::decompress(&message.pixels, pixels.saturating_mul(WORDS))?;
    if let Some(wrong) = values.iter().find(|value| !value.is_finite()) {
        return Err(WireError::Impossible { field: "first surfaces", problem: format!("a value is {wrong}") });
    }
    let pixel = |pixel: usize| {
        let value = |channel: usize| values[channel * pixels + pixel];
        let vector = |first: usize| Vec3::new(value(first), value(first + 1), value(first + 2));
        FirstSurface {
            albedo: Rgb::new(value(0), value(1), value(2)),
            normal: vector(3),
            depth: value(6),
            position: vector(7),
        }
    };
    Ok((0..pixels).map(pixel).collect())
}
