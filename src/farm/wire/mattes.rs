//! How much of a scene's pixels objects and materials cover.

use super::WireError;
use super::messages;
use crate::estimate::picture_files::{Matte, Mattes, RANKS, RAYS_PER_PIXEL};

/// Bytes that all names together may have.
pub const MOST_NAME_BYTES: usize = 16 << 20;
/// Bytes a pixel of both mattes at most: how many things, and of each its name, up to five bytes, and its rays.
pub const MOST_PIXEL_BYTES: usize = 2 * (1 + RANKS * (5 + 1));
/// Bytes that a name takes beside its own.
const NAME_FRAME: usize = 6;

/// To the message; the error says in one sentence why that cannot be.
pub fn encode(mattes: Mattes) -> Result<messages::Mattes, String> {
    let names = || mattes.objects.names.iter().chain(&mattes.materials.names);
    let bytes: usize = names().map(|name| name.len() + NAME_FRAME).sum();
    if bytes > MOST_NAME_BYTES {
        let (count, most) = (names().count(), MOST_NAME_BYTES >> 20);
        return Err(format!(
            "the {count} names of objects and materials take more than {most} MiB; give shorter or fewer ids"
        ));
    }
    Ok(messages::Mattes {
        objects: Some(encode_matte(mattes.objects)),
        materials: Some(encode_matte(mattes.materials)),
    })
}

fn encode_matte(matte: Matte) -> messages::Matte {
    let Matte { names, counts, things, rays } = matte;
    messages::Matte { names, counts: counts.into(), things, rays: rays.into() }
}

/// From the message, for a picture of `pixels` pixels.
pub fn decode(message: messages::Mattes, pixels: usize) -> Result<Mattes, WireError> {
    Ok(Mattes {
        objects: decode_matte(message.objects.ok_or(WireError::Missing("objects"))?, pixels)?,
        materials: decode_matte(message.materials.ok_or(WireError::Missing("materials"))?, pixels)?,
    })
}

fn decode_matte(message: messages::Matte, pixels: usize) -> Result<Matte, WireError> {
    let messages::Matte { names, counts, things, rays } = message;
    let impossible = |problem: &str| Err(WireError::Impossible { field: "mattes", problem: problem.to_owned() });
    let shown: usize = counts.iter().map(|count| usize::from(*count)).sum();
    if counts.len() != pixels || things.len() != shown || rays.len() != shown {
        return impossible("the lists have other lengths than the picture's pixels need");
    }
    if things.iter().any(|thing| *thing as usize >= names.len()) {
        return impossible("a thing has no name");
    }
    let mut met = rays.iter();
    for count in &counts {
        let met: u32 = met.by_ref().take(usize::from(*count)).map(|rays| u32::from(*rays)).sum();
        if usize::from(*count) > RANKS || met > RAYS_PER_PIXEL {
            return impossible("a pixel shows more than it has ranks or rays");
        }
    }
    Ok(Matte { names, counts: counts.into(), things, rays: rays.into() })
}
