//! Cryptomatte 1.2.0, the specification that Psyop published: which objects or materials cover how much of each pixel, as 32-bit channels
//! of an EXR file that compositors select by name.
//!
//! A name's id is its hash, as a float. A pixel holds pairs of id and coverage, those of most coverage first.

use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Pairs of id and coverage that a pixel holds.
pub const RANKS: usize = 6;
/// Rays by which a pixel looks at first surfaces: coverage is counted in them.
pub const RAYS_PER_PIXEL: u32 = 16;
/// The seed of the hash, 0 in the specification.
const SEED: u32 = 0;

/// What covers the pixels of a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Matte {
    /// The names of the things, each once; also of those that are not seen.
    pub names: Vec<String>,
    /// How many things each pixel shows, at most [`RANKS`]: row-major, top row first.
    pub counts: Vec<u8>,
    /// Those things, indices of names, one pixel after the other; in a pixel, those of most rays first.
    pub things: Vec<u32>,
    /// How many of a pixel's rays meet each.
    pub rays: Vec<u8>,
}

/// The mattes of a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mattes {
    /// Of shapes and instances.
    pub objects: Matte,
    /// Of materials.
    pub materials: Matte,
}

/// What the header of a file says of a matte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MatteHeader {
    /// What the channels' names begin with, for example `CryptoObject`.
    pub name: &'static str,
    /// The names and their ids, JSON.
    pub manifest: String,
}

impl Matte {
    /// Appends a pixel by the things that its rays meet. Of more than [`RANKS`] things those of most rays are kept; of as many rays, the first in
    /// the order of the scene.
    pub fn push_pixel(&mut self, met: &mut [u32]) {
        met.sort_unstable();
        let mut ranked: Vec<&[u32]> = met.chunk_by(|a, b| a == b).collect();
        // A stable sort: things of as many rays stay in their order.
        ranked.sort_by_key(|same| Reverse(same.len()));
        ranked.truncate(RANKS);
        self.counts.push(ranked.len() as u8);
        self.things.extend(ranked.iter().map(|same| same[0]));
        self.rays.extend(ranked.iter().map(|same| same.len() as u8));
    }

    /// Appends the pixels of another part of the same picture.
    pub fn append(&mut self, other: &Self) {
        self.counts.extend_from_slice(&other.counts);
        self.things.extend_from_slice(&other.things);
        self.rays.extend_from_slice(&other.rays);
    }

    /// The values of the channels in the order of the ranks: id and coverage of the first, of the second, and so on. Where there are fewer things
    /// than ranks, id and coverage are 0.
    pub fn channels(&self) -> Vec<Vec<f32>> {
        let ids: Vec<f32> = self.names.iter().map(|name| name_id(name)).collect();
        let mut channels = vec![vec![0.0; self.counts.len()]; 2 * RANKS];
        let mut found = self.things.iter().zip(&self.rays);
        for (pixel, count) in self.counts.iter().enumerate() {
            for (rank, (thing, met)) in found.by_ref().take(usize::from(*count)).enumerate() {
                channels[2 * rank][pixel] = ids[*thing as usize];
                channels[2 * rank + 1][pixel] = f32::from(*met) / RAYS_PER_PIXEL as f32;
            }
        }
        channels
    }

    /// What the header says of it; `name` is what its channels' names begin with.
    pub fn header(&self, name: &'static str) -> MatteHeader {
        let id = |name: &String| format!("{:08x}", name_id(name).to_bits());
        let ids: BTreeMap<&str, String> = self.names.iter().map(|name| (name.as_str(), id(name))).collect();
        let manifest = serde_json::json!(ids).to_string();
        MatteHeader { name, manifest }
    }
}

impl MatteHeader {
    /// The attributes of the header, names and values.
    pub(super) fn attributes(&self) -> [(String, String); 4] {
        // The key is to be the same in all files.
        let key = &format!("{:08x}", murmur3(self.name.as_bytes(), SEED))[..7];
        let attribute = |what: &str, value: &str| (format!("cryptomatte/{key}/{what}"), value.to_owned());
        [
            attribute("name", self.name),
            attribute("hash", "MurmurHash3_32"),
            attribute("conversion", "uint32_to_float32"),
            attribute("manifest", &self.manifest),
        ]
    }
}

/// The id of a name: the bits of its hash as a float. Exponents that mean infinity, NaN or less than full precision are changed in their last bit.
pub fn name_id(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes(), SEED);
    let exponent = hash >> 23 & 0xff;
    f32::from_bits(if exponent == 0 || exponent == 0xff { hash ^ 1 << 23 } else { hash })
}

/// MurmurHash3 of 32 bits (x86 variant, Austin Appleby, public domain).
pub fn murmur3(bytes: &[u8], seed: u32) -> u32 {
    let scramble = |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let blocks = bytes.chunks_exact(4);
    let rest = blocks.remainder();
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
    let mixed = blocks.fold(seed, |hash, block| {
        (hash ^ scramble(word(block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mut hash = mixed ^ scramble(word(rest)) ^ bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}
