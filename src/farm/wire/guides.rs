//! What a pilot learnt that passes need: where photons start, and which lights are seen where.

use super::messages;
use super::{WireError, planes};
use crate::method::{MOST_GUIDE_VALUES, MOST_VISIBILITY_VALUES};
use crate::render::Guides;

/// To the message.
pub fn encode(guides: &Guides) -> messages::Guides {
    let Guides { emission, visibility } = guides;
    messages::Guides {
        emission_length: emission.len() as u64,
        emission: planes::compress(emission).into(),
        visibility_length: visibility.len() as u64,
        visibility: planes::compress(visibility).into(),
    }
}

/// From the message. Whether the numbers fit the scene's lights is for the renderer to say.
pub fn decode(message: &messages::Guides) -> Result<Guides, WireError> {
    let messages::Guides { emission_length, emission, visibility_length, visibility } = message;
    Ok(Guides {
        emission: numbers("emission guide", *emission_length, emission, MOST_GUIDE_VALUES)?,
        visibility: numbers("visibility of lights", *visibility_length, visibility, MOST_VISIBILITY_VALUES)?,
    })
}

fn numbers(field: &'static str, length: u64, bytes: &[u8], most: usize) -> Result<Vec<f32>, WireError> {
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    if length > most {
        return Err(WireError::Impossible { field, problem: format!("{length} numbers") });
    }
    planes::decompress(bytes, length)
}
