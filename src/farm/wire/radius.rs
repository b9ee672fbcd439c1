//! Radius fields and radii.

use super::messages;
use super::{WireError, planes};
use crate::estimate::RadiusField;

/// To the message.
pub fn encode(field: &RadiusField) -> messages::RadiusField {
    messages::RadiusField {
        base_pass: field.base_pass,
        typical_radius_squared: field.typical_radius_squared,
        radius_squared: encode_radii(&field.radius_squared).into(),
    }
}

/// From the message, for a region of `pixels` pixels.
pub fn decode(message: &messages::RadiusField, pixels: usize) -> Result<RadiusField, WireError> {
    Ok(RadiusField {
        radius_squared: decode_radii(&message.radius_squared, pixels)?,
        base_pass: message.base_pass,
        typical_radius_squared: positive(message.typical_radius_squared)?,
    })
}

/// One radius² per pixel, as planes.
pub fn encode_radii(radius_squared: &[f32]) -> Vec<u8> {
    planes::compress(radius_squared)
}

/// The inverse of [`encode_radii`]; every radius must be positive and finite.
pub fn decode_radii(bytes: &[u8], pixels: usize) -> Result<Vec<f32>, WireError> {
    let radii = planes::decompress(bytes, pixels)?;
    check_radii(&radii)?;
    Ok(radii)
}

/// Every radius² must be positive and finite.
pub(super) fn check_radii(radius_squared: &[f32]) -> Result<(), WireError> {
    radius_squared.iter().try_for_each(|radius_squared| positive(*radius_squared).map(|_| ()))
}

fn positive(value: f32) -> Result<f32, WireError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(WireError::Impossible { field: "radius", problem: format!("radius² is {value}") })
}
