//! All channels of an EXR file by name.

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::prelude::{ReadChannels, ReadLayers, read};

/// The values of every channel, top row first.
pub(crate) fn exr_channels(bytes: &[u8]) -> BTreeMap<String, Vec<f32>> {
    let file = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = file.from_buffered(Cursor::new(bytes)).expect("an EXR");
    let channels = image.layer_data.channel_data.list.into_iter();
    channels.map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect())).collect()
}
