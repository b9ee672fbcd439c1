//! What workers return: tallies and pilots.

use super::messages;
use super::{WireError, planes, radius};
use crate::estimate::{Shard, Tally, TallyError};
use crate::render::Pilot;

/// To the message.
pub fn encode_tally(tally: &Tally) -> messages::Tally {
    let records: &[[f32; 8]] = bytemuck::cast_slice(&tally.pixels);
    messages::Tally {
        photons_emitted: tally.photons_emitted,
        photons_stored: tally.photons_stored,
        rays: tally.rays,
        non_finite: tally.non_finite,
        pixels: planes::compress(records).into(),
    }
}

/// From the message, for the shard that was leased. Values are not judged: see [`Tally::check`].
pub fn decode_tally(message: &messages::Tally, shard: Shard, width: u32) -> Result<Tally, WireError> {
    let records = planes::decompress::<8>(&message.pixels, shard.region.pixel_count(width))?;
    Ok(Tally {
        shard,
        width,
        pixels: bytemuck::cast_vec(records),
        photons_emitted: message.photons_emitted,
        photons_stored: message.photons_stored,
        rays: message.rays,
        non_finite: message.non_finite,
    })
}

/// From the message, and checks that every value is possible.
pub fn decode_checked_tally(message: &messages::Tally, shard: Shard, width: u32) -> Result<Tally, WireError> {
    let impossible = |problem: TallyError| WireError::Impossible { field: "tally", problem: problem.to_string() };
    let tally = decode_tally(message, shard, width)?;
    tally.check().map_err(impossible)?;
    Ok(tally)
}

/// To the message.
pub fn encode_pilot(pilot: &Pilot) -> messages::Pilot {
    let radius_squared = radius::encode_radii(&pilot.radius_squared).into();
    messages::Pilot { cost_per_pass: pilot.cost_per_pass, radius_squared }
}

/// From the message, for a picture of `pixels` pixels.
pub fn decode_pilot(message: &messages::Pilot, pixels: usize) -> Result<Pilot, WireError> {
    if message.cost_per_pass == 0 {
        return Err(WireError::Impossible { field: "pilot", problem: "a pass costs nothing".to_owned() });
    }
    let radius_squared = radius::decode_radii(&message.radius_squared, pixels)?;
    Ok(Pilot { radius_squared, cost_per_pass: message.cost_per_pass })
}
