//! Numbers as byte planes: all first bytes, then all second bytes, …, compressed with LZ4.
//!
//! Neighboring pixels agree in sign, exponent and leading digits, so planes of equal byte position compress where the
//! numbers themselves do not. Nothing is rounded.
//!
//! Records go in chunks of 16384, each as its compressed length (little-endian `u32`) and one LZ4 block of its planes.
//! A chunk stays in the second-level cache, and no second copy of the whole picture is made: on fresh memory the page
//! faults alone cost more than the splitting.

use super::WireError;

/// Records that are compressed together.
const CHUNK: usize = 16_384;
/// Records that are split at a time; their words stay in the first-level cache.
const BLOCK: usize = 1024;

/// Splits records of `WORDS` little-endian `f32` into byte planes and compresses them.
pub fn compress<const WORDS: usize>(records: &[[f32; WORDS]]) -> Vec<u8> {
    let mut planes = vec![0; records.len().min(CHUNK) * WORDS * 4];
    let mut packed = vec![0; lz4_flex::block::get_maximum_output_size(planes.len())];
    let mut bytes = Vec::new();
    for chunk in records.chunks(CHUNK) {
        let planes = &mut planes[..chunk.len() * WORDS * 4];
        split(chunk, planes);
        let Ok(length) = lz4_flex::block::compress_into(planes, &mut packed) else {
            unreachable!("the buffer has the maximum size of a compressed chunk");
        };
        bytes.extend_from_slice(&(length as u32).to_le_bytes());
        bytes.extend_from_slice(&packed[..length]);
    }
    bytes
}

/// The inverse of [`compress`] for exactly `count` records. Allocates for `count` records, never for what the bytes claim.
pub fn decompress<const WORDS: usize>(mut bytes: &[u8], count: usize) -> Result<Vec<[f32; WORDS]>, WireError> {
    let expected = count.saturating_mul(WORDS * 4);
    // LZ4 cannot shrink more than 255 times: a short message is refused before it costs memory.
    if bytes.len().saturating_mul(256) < expected {
        return Err(impossible(format!("{} bytes cannot hold {count} records", bytes.len())));
    }
    let mut records = vec![[0.0; WORDS]; count];
    let mut planes = vec![0; count.min(CHUNK) * WORDS * 4];
    for chunk in records.chunks_mut(CHUNK) {
        let packed = take_chunk(&mut bytes).ok_or_else(|| impossible("a chunk is cut off".to_owned()))?;
        let planes = &mut planes[..chunk.len() * WORDS * 4];
        match lz4_flex::block::decompress_into(packed, planes) {
            Ok(length) if length == planes.len() => join(planes, chunk),
            Ok(length) => return Err(impossible(format!("a chunk of {length} bytes where {} belong", planes.len()))),
            Err(problem) => return Err(impossible(problem.to_string())),
        }
    }
    if bytes.is_empty() { Ok(records) } else { Err(impossible(format!("{} bytes too many", bytes.len()))) }
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

/// Records to byte planes.
fn split<const WORDS: usize>(records: &[[f32; WORDS]], planes: &mut [u8]) {
    let count = records.len();
    let mut words = [0u32; BLOCK];
    for (block, records) in records.chunks(BLOCK).enumerate() {
        let words = &mut words[..records.len()];
        for word in 0..WORDS {
            for (bits, record) in words.iter_mut().zip(records) {
                *bits = record[word].to_bits();
            }
            for byte in 0..4 {
                let start = (word * 4 + byte) * count + block * BLOCK;
                for (output, bits) in planes[start..start + words.len()].iter_mut().zip(words.iter()) {
                    *output = (bits >> (8 * byte)) as u8;
                }
            }
        }
    }
}

/// Byte planes to records.
fn join<const WORDS: usize>(planes: &[u8], records: &mut [[f32; WORDS]]) {
    let count = records.len();
    let mut words = [0u32; BLOCK];
    for (block, records) in records.chunks_mut(BLOCK).enumerate() {
        let words = &mut words[..records.len()];
        for word in 0..WORDS {
            words.fill(0);
            for byte in 0..4 {
                let start = (word * 4 + byte) * count + block * BLOCK;
                for (bits, input) in words.iter_mut().zip(&planes[start..start + records.len()]) {
                    *bits |= u32::from(*input) << (8 * byte);
                }
            }
            for (record, bits) in records.iter_mut().zip(words.iter()) {
                record[word] = f32::from_bits(*bits);
            }
        }
    }
}
