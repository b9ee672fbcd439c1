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
    planes::compress::<1>(bytemuck::cast_slice(radius_squared))
}

/// The inverse of [`encode_radii`]; every radius must be positive and finite.
pub fn decode_radii(bytes: &[u8], pixels: usize) -> Result<Vec<f32>, WireError> {
    let radii: Vec<f32> = bytemuck::cast_vec(planes::decompress::<1>(bytes, pixels)?);
    match radii.iter().find(|radius_squared| positive(**radius_squared).is_err()) {
        None => Ok(radii),
        Some(wrong) => positive(*wrong).map(|_| Vec::new()),
    }
}

fn positive(value: f32) -> Result<f32, WireError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(WireError::Impossible { field: "radius", problem: format!("radius² is {value}") })
}
