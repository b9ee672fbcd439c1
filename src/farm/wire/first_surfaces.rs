//! What the pixels of a scene see first.

use super::messages;
use super::{WireError, planes};
use crate::math::{Rgb, Vec3};
use crate::render::first_surface::FirstSurface;

/// Numbers a pixel.
const WORDS: usize = 7;

/// To the message.
pub fn encode(seen: &[FirstSurface]) -> messages::FirstSurfaces {
    let record = |pixel: &FirstSurface| {
        let ([r, g, b], [x, y, z]) = (pixel.albedo.to_array(), pixel.normal.to_array());
        [r, g, b, x, y, z, pixel.depth]
    };
    let records: Vec<[f32; WORDS]> = seen.iter().map(record).collect();
    messages::FirstSurfaces { pixels: planes::compress(&records).into() }
}

/// From the message, for a picture of `pixels` pixels; every number must be finite.
pub fn decode(message: &messages::FirstSurfaces, pixels: usize) -> Result<Vec<FirstSurface>, WireError> {
    let records = planes::decompress::<WORDS>(&message.pixels, pixels)?;
    if let Some(wrong) = records.iter().flatten().find(|value| !value.is_finite()) {
        return Err(WireError::Impossible { field: "first surfaces", problem: format!("a value is {wrong}") });
    }
    let pixel = |[r, g, b, x, y, z, depth]: [f32; WORDS]| FirstSurface {
        albedo: Rgb::new(r, g, b),
        normal: Vec3::new(x, y, z),
        depth,
    };
    Ok(records.into_iter().map(pixel).collect())
}
