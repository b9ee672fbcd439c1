//! What workers return: tallies and pilots.

use std::sync::Arc;

use super::messages;
use super::{WireError, planes, radius};
use crate::estimate::{Declaration, Shard, Tally, TallyError};
use crate::method::{FIRST_RADIUS_SQUARED, PilotField};
use crate::render::Pilot;

/// Fields and counts that a pilot may have.
const PILOT_ENTRIES: usize = 64;
/// Numbers that a pilot's field may have, when the picture has fewer pixels.
const FIELD_VALUES: usize = 1 << 24;

/// To the message.
pub fn encode_tally(tally: &Tally) -> messages::Tally {
    let planes = tally.planes.iter().map(|plane| planes::compress(plane).into()).collect();
    messages::Tally { scalars: tally.scalars.clone(), planes }
}

/// From the message, for the shard that was leased. Values are not judged: see [`Tally::check`].
pub fn decode_tally(
    message: &messages::Tally,
    shard: Shard,
    width: u32,
    declaration: &Arc<Declaration>,
) -> Result<Tally, WireError> {
    let (found, expected) = (message.planes.len(), declaration.planes.len());
    if found != expected {
        return Err(WireError::Impossible { field: "planes", problem: format!("{found} instead of {expected}") });
    }
    let pixels = shard.region.pixel_count(width);
    let planes = message.planes.iter().zip(&declaration.planes);
    let planes = planes.map(|(bytes, declared)| planes::decompress(bytes, declared.channels.saturating_mul(pixels)));
    let (planes, scalars) = (planes.collect::<Result<_, _>>()?, message.scalars.clone());
    Ok(Tally { shard, width, declaration: declaration.clone(), planes, scalars })
}

/// From the message, and checks that every value is possible.
pub fn decode_checked_tally(
    message: &messages::Tally,
    shard: Shard,
    width: u32,
    declaration: &Arc<Declaration>,
) -> Result<Tally, WireError> {
    let impossible = |problem: TallyError| WireError::Impossible { field: "tally", problem: problem.to_string() };
    let tally = decode_tally(message, shard, width, declaration)?;
    tally.check().map_err(impossible)?;
    Ok(tally)
}

/// To the message.
pub fn encode_pilot(pilot: &Pilot) -> messages::Pilot {
    let field = |field: &PilotField| messages::PilotField {
        name: field.name.clone(),
        length: field.values.len() as u64,
        values: planes::compress(&field.values).into(),
    };
    let count = |(name, value): &(String, u64)| messages::PilotCount { name: name.clone(), value: *value };
    messages::Pilot {
        fields: pilot.fields.iter().map(field).collect(),
        counts: pilot.counts.iter().map(count).collect(),
    }
}

/// From the message, for a picture of `pixels` pixels. First radii must come exactly where the method has radii.
pub fn decode_pilot(message: &messages::Pilot, pixels: usize, declaration: &Declaration) -> Result<Pilot, WireError> {
    if message.fields.len().max(message.counts.len()) > PILOT_ENTRIES {
        return Err(impossible_pilot("it has too many fields"));
    }
    let fields = message.fields.iter().map(|field| decode_field(field, pixels)).collect::<Result<_, _>>()?;
    let counts = message.counts.iter().map(|count| (count.name.clone(), count.value)).collect();
    let pilot = Pilot { fields, counts };
    if pilot.cost_per_pass() == 0 {
        return Err(impossible_pilot("a pass costs nothing"));
    }
    let radii = pilot.radius_squared();
    if radii.len() != if declaration.has_radii() { pixels } else { 0 } {
        return Err(impossible_pilot("it has not the radii that the method needs"));
    }
    radius::check_radii(radii)?;
    Ok(pilot)
}

fn decode_field(message: &messages::PilotField, pixels: usize) -> Result<PilotField, WireError> {
    let length = usize::try_from(message.length).unwrap_or(usize::MAX);
    let is_right =
        if message.name == FIRST_RADIUS_SQUARED { length == pixels } else { length <= pixels.max(FIELD_VALUES) };
    if !is_right {
        return Err(impossible_pilot("a field has the wrong size"));
    }
    let values = planes::decompress(&message.values, length)?;
    if !values.iter().all(|value| value.is_finite()) {
        return Err(impossible_pilot("a field holds a number that is not finite"));
    }
    Ok(PilotField { name: message.name.clone(), values })
}

fn impossible_pilot(problem: &str) -> WireError {
    WireError::Impossible { field: "pilot", problem: problem.to_owned() }
}
