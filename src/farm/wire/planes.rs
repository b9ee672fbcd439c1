//! Numbers as byte planes: all first bytes, then all second bytes, …, compressed with LZ4.
//!
//! Neighboring pixels agree in sign, exponent and leading digits, so planes of equal byte position compress where the
//! numbers themselves do not. Nothing is rounded.
//!
//! Numbers go in chunks of 65536, each as its compressed length (little-endian `u32`) and one LZ4 block of its planes.
//! A chunk stays in the second-level cache, and no second copy of the whole picture is made: on fresh memory the page
//! faults alone cost more than the splitting.

use super::WireError;

/// Numbers that are compressed together.
const CHUNK: usize = 65_536;

/// Splits little-endian `f32` into byte planes and compresses them.
pub fn compress(values: &[f32]) -> Vec<u8> {
    let mut planes = vec![0; values.len().min(CHUNK) * 4];
    let mut packed = vec![0; lz4_flex::block::get_maximum_output_size(planes.len())];
    let mut bytes = Vec::new();
    for chunk in values.chunks(CHUNK) {
        let planes = &mut planes[..chunk.len() * 4];
        split(chunk, planes);
        let Ok(length) = lz4_flex::block::compress_into(planes, &mut packed) else {
            unreachable!("the buffer has the maximum size of a compressed chunk");
        };
        bytes.extend_from_slice(&(length as u32).to_le_bytes());
        bytes.extend_from_slice(&packed[..length]);
    }
    bytes
}

/// The inverse of [`compress`] for exactly `count` numbers. Allocates for `count` numbers, never for what the bytes claim.
pub fn decompress(mut bytes: &[u8], count: usize) -> Result<Vec<f32>, WireError> {
    // LZ4 cannot shrink more than 255 times: a short message is refused before it costs memory.
    if bytes.len().saturating_mul(256) < count.saturating_mul(4) {
        return Err(impossible(format!("{} bytes cannot hold {count} numbers", bytes.len())));
    }
    let mut values = vec![0.0; count];
    let mut planes = vec![0; count.min(CHUNK) * 4];
    for chunk in values.chunks_mut(CHUNK) {
        let packed = take_chunk(&mut bytes).ok_or_else(|| impossible("a chunk is cut off".to_owned()))?;
        let planes = &mut planes[..chunk.len() * 4];
        match lz4_flex::block::decompress_into(packed, planes) {
            Ok(length) if length == planes.len() => join(planes, chunk),
            Ok(length) => return Err(impossible(format!("a chunk of {length} bytes where {} belong", planes.len()))),
            Err(problem) => return Err(impossible(problem.to_string())),
        }
    }
    if bytes.is_empty() { Ok(values) } else { Err(impossible(format!("{} bytes too many", bytes.len()))) }
}

/// Takes the next chunk's compressed planes off the front of `bytes`.
fn take_chunk<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    let (packed, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    *bytes = rest;
    Some(packed)
}

fn impossible(problem: String) -> WireError {
    WireError::Impossible { field: "planes", problem }
}

/// Numbers to byte planes.
fn split(values: &[f32], planes: &mut [u8]) {
    for (byte, plane) in planes.chunks_exact_mut(values.len()).enumerate() {
        for (output, value) in plane.iter_mut().zip(values) {
            *output = (value.to_bits() >> (8 * byte)) as u8;
        }
    }
}

/// Byte planes to numbers.
fn join(planes: &[u8], values: &mut [f32]) {
    let (low, high) = planes.split_at(2 * values.len());
    let (first, second) = low.split_at(values.len());
    let (third, fourth) = high.split_at(values.len());
    let bytes = first.iter().zip(second).zip(third).zip(fourth);
    for (value, (((first, second), third), fourth)) in values.iter_mut().zip(bytes) {
        *value = f32::from_le_bytes([*first, *second, *third, *fourth]);
    }
}
