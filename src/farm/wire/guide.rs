//! Where photons start: the emission guide that a pilot learnt.

use super::messages;
use super::{WireError, planes};
use crate::method::MOST_GUIDE_VALUES;

/// To the message; a guide without numbers stands for emission by power.
pub fn encode(values: &[f32]) -> messages::EmissionGuide {
    messages::EmissionGuide { length: values.len() as u64, values: planes::compress(values).into() }
}

/// From the message. Whether the numbers fit the scene's lights is for the renderer to say.
pub fn decode(message: &messages::EmissionGuide) -> Result<Vec<f32>, WireError> {
    let length = usize::try_from(message.length).unwrap_or(usize::MAX);
    if length > MOST_GUIDE_VALUES {
        return Err(WireError::Impossible { field: "emission guide", problem: format!("{length} numbers") });
    }
    planes::decompress(&message.values, length)
}
