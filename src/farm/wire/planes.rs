//! Numbers as byte planes: all first bytes, then all second bytes, …, compressed with LZ4.
//!
//! Neighboring pixels agree in sign, exponent and leading digits, so planes of equal byte position compress where the
//! numbers themselves do not. Nothing is rounded.

use super::WireError;

/// Records that are split at a time; their words stay in the first-level cache.
const BLOCK: usize = 1024;

/// Splits records of `WORDS` little-endian `f32` into `4·WORDS` byte planes and compresses them.
pub fn compress<const WORDS: usize>(records: &[[f32; WORDS]]) -> Vec<u8> {
    lz4_flex::block::compress(&split(records))
}

/// The inverse of [`compress`] for exactly `count` records. Allocates for `count` records, never for what the bytes claim.
pub fn decompress<const WORDS: usize>(bytes: &[u8], count: usize) -> Result<Vec<[f32; WORDS]>, WireError> {
    let expected = count * WORDS * 4;
    // LZ4 cannot shrink more than 255 times: a short message is refused before it costs memory.
    if bytes.len().saturating_mul(256) < expected {
        return Err(wrong_length(bytes.len() * 256, expected));
    }
    let mut planes = vec![0; expected];
    match lz4_flex::block::decompress_into(bytes, &mut planes) {
        Ok(length) if length == expected => Ok(join(&planes, count)),
        Ok(length) => Err(wrong_length(length, expected)),
        Err(problem) => Err(WireError::Impossible { field: "planes", problem: problem.to_string() }),
    }
}

fn wrong_length(found: usize, expected: usize) -> WireError {
    WireError::Impossible { field: "planes", problem: format!("at most {found} bytes where {expected} are expected") }
}

/// Records to byte planes.
pub fn split<const WORDS: usize>(records: &[[f32; WORDS]]) -> Vec<u8> {
    let count = records.len();
    let mut planes = vec![0u8; count * WORDS * 4];
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
    planes
}

/// Byte planes to records.
pub fn join<const WORDS: usize>(planes: &[u8], count: usize) -> Vec<[f32; WORDS]> {
    let mut records = vec![[0.0f32; WORDS]; count];
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
    records
}
