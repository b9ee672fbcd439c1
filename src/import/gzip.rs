//! Files that are compressed with gzip.

use std::io::Read;
use std::sync::Arc;

use flate2::read::MultiGzDecoder;

use super::values::shown;
use crate::scene::error::{Location, SceneError};

/// The most bytes that a file may unpack to.
const MOST_BYTES: u64 = 1 << 30;

/// The unpacked content of file `name`, which is named at `place`.
///
/// # Errors
/// When it is damaged, or unpacks to more than 1 GiB.
pub(super) fn unpacked(bytes: &[u8], name: &str, place: &Location) -> Result<Arc<[u8]>, SceneError> {
    let mut content = Vec::new();
    let read = MultiGzDecoder::new(bytes).take(MOST_BYTES + 1).read_to_end(&mut content);
    read.map_err(|error| {
        SceneError::new(place, format!("file {} cannot be unpacked: {error}", shown(name)), "compress it again")
    })?;
    if content.len() as u64 > MOST_BYTES {
        return Err(SceneError::new(place, format!("file {} unpacks to more than 1 GiB", shown(name)), "split it"));
    }
    Ok(content.into())
}
