//! Which channels of a picture 16-bit floats hold: those of colors and directions. Distances, places, counts and errors are for computing,
//! and stay at 32 bits.

use exr::prelude::{FlatSamples, f16};

use super::layers::LayerRow;

/// The layers of a picture whose channels 16 bits hold, by name; the picture's own colors are called "". A layer with a number beyond 65504,
/// which would become infinite, is not among them.
pub(super) fn half_layers(channels: &[(String, Vec<f32>)]) -> Vec<String> {
    let mut layers: Vec<&str> = channels.iter().map(|(channel, _)| layer_of(channel)).collect();
    layers.dedup();
    let fits = |layer: &str| {
        let mut own = channels.iter().filter(|(channel, _)| layer_of(channel) == layer);
        own.all(|(_, values)| values.iter().all(|value| !value.is_finite() || f16::from_f32(*value).is_finite()))
    };
    let allows = |layer: &str| layer.is_empty() || LayerRow::named(layer).is_some_and(|row| row.allows_half);
    layers.into_iter().filter(|layer| allows(layer) && fits(layer)).map(str::to_owned).collect()
}

/// The layer that a channel belongs to.
pub(super) fn layer_of(channel: &str) -> &str {
    channel.rsplit_once('.').map_or("", |(layer, _)| layer)
}

/// Rounded to 16 bits.
pub(super) fn half_samples(values: &[f32]) -> FlatSamples {
    FlatSamples::F16(values.iter().map(|value| f16::from_f32(*value)).collect())
}
