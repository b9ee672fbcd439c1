//! Counter-based random numbers: every number is a pure function of its address (seed, stream, pass, path, block).
//!
//! One block gives four numbers; a path vertex uses one or two blocks. They come from Philox4x32 with 7 rounds [Salmon et al. 2011,
//! "Parallel random numbers: as easy as 1, 2, 3"], the fewest that pass BigCrush. The first blocks of a camera path, which decide
//! most, come from a scrambled [`Sequence`] that spreads them evenly over the passes of the pixel. Even and odd passes have
//! sequences of their own, independent of each other: a job's two twins.

mod permutation;
mod recorded;
mod sequence;

pub use permutation::Permutation;
pub use recorded::RecordedNumbers;
use sequence::Sequence;

/// What a family of paths is for; keeps their numbers apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stream {
    /// Camera paths; the path index is the pixel's.
    Camera = 0,
    /// Photon paths.
    Photon = 1,
    /// Camera paths of the pilot.
    PilotCamera = 2,
    /// Photon paths of the pilot.
    PilotPhoton = 3,
    /// Camera rays to the first surface; the path index is the pixel's.
    FirstSurface = 4,
    /// Camera paths at which it is tried which lights are seen.
    Visibility = 5,
    /// Which pixels look at which of a pass's photon maps.
    MapChoice = 6,
    /// Camera paths whose ends tell where photons are looked for; the path index is the pixel's.
    Importance = 9,
    /// Paths of which Markov chains start.
    Bootstrap = 10,
    /// Mutations of Markov chains.
    Chain = 11,
    /// Branches of recorded paths.
    Branch = 12,
    /// Paths that tell chains what to expect.
    Trial = 13,
}

/// As many parts the numbers of a pass have room for.
pub const MOST_PARTS: u32 = 1 << 14;

/// The numbers of a pass.
#[derive(Clone, Copy, Debug)]
pub struct PassRandom {
    key: [u32; 2],
    stream: u32,
    pass: u32,
    /// Which of a pixel's samples.
    sample: u32,
    part: Part,
    is_spread: bool,
}

/// One of a pass's parts.
#[derive(Clone, Copy, Debug)]
struct Part {
    index: u32,
    count: u32,
}

impl Part {
    /// A pass that has no others.
    const WHOLE: Self = Self { index: 0, count: 1 };
}

impl PassRandom {
    /// Pass `pass` of `stream` with one path a pixel: the first blocks of each pixel's passes are spread evenly, independently of other
    /// pixels.
    pub fn of_pixels(seed: u64, stream: Stream, pass: u32) -> Self {
        Self { is_spread: true, ..Self::independent(seed, stream, pass) }
    }

    /// Pass `pass` of `stream` with paths that are independent of each other, as photons must be: many pixels share them, and
    /// evenly spread ones made errors that pixels share too.
    pub fn independent(seed: u64, stream: Stream, pass: u32) -> Self {
        Self {
            key: [seed as u32, (seed >> 32) as u32],
            stream: stream as u32,
            pass,
            sample: 0,
            part: Part::WHOLE,
            is_spread: false,
        }
    }

    /// The numbers of sample `index` of the pass, where pixels have different numbers of samples. Every sample has a sequence of its own, which
    /// goes on through the passes, so that each is evenly spread whether there are others or not. The first is the pass itself.
    pub fn sample(&self, index: u32) -> Self {
        Self { sample: index, ..*self }
    }

    /// The numbers of part `index` of `count` of the pass or sample, at most [`MOST_PARTS`] in all: one of its photon maps, or one of each pixel's
    /// paths. The only part is the pass itself. Parts have blocks of their own in every path's address, so no two of any two passes
    /// share numbers; evenly spread ones go on through the parts of one pass to those of the next.
    pub fn part(&self, index: u32, count: u32) -> Self {
        Self { part: Part { index, count }, ..*self }
    }

    /// The numbers of a path: the pixel's index, or that of the path in the pass.
    #[inline]
    pub fn path(&self, path: u32) -> PathRandom {
        let Self { key, stream, pass, sample, part, is_spread } = *self;
        let address = [path, sample, 0, SEQUENCES | stream | (pass & 1) << 8];
        // Only after 2³² places the sequence begins again.
        let place = (pass >> 1).wrapping_mul(part.count).wrapping_add(part.index);
        let sequence = is_spread.then(|| Sequence::new(philox::<7>(address, key), place));
        let first_block = (sample * part.count + part.index) * BLOCKS_OF_A_PART;
        PathRandom { key, stream, pass, path, first_block, sequence }
    }
}

/// Blocks that are spread evenly: those of the first two vertices. Later ones decide too little by themselves to pay.
const SPREAD_BLOCKS: u32 = 6;
/// More blocks than a path has: those of 131,072 vertices.
const BLOCKS_OF_A_PART: u32 = u32::MAX / MOST_PARTS + 1;
/// Keeps the keys of sequences apart from the numbers of paths.
const SEQUENCES: u32 = 1 << 31;

/// The random numbers of a path, wherever they come from: addressed ([`PathRandom`]), or recorded ([`RecordedNumbers`]).
pub trait Numbers: Copy + Sync {
    /// Four numbers in [0, 1). The first two are a point of the unit square, and so are the last two.
    fn block(&self, block: u32) -> [f32; 4];

    /// As many more as it takes where the path splits: independent of the path's own, and of other branches.
    fn branch(&self, index: u32) -> PathRandom;
}

/// The numbers of one path.
#[derive(Clone, Copy, Debug)]
pub struct PathRandom {
    key: [u32; 2],
    stream: u32,
    pass: u32,
    path: u32,
    /// Where the blocks of its part of the pass begin.
    first_block: u32,
    /// Of which the first blocks come.
    sequence: Option<Sequence>,
}

impl PathRandom {
    /// Numbers of path `path` of pass `pass` in `stream` that are independent of all others.
    pub fn new(seed: u64, stream: Stream, pass: u32, path: u32) -> Self {
        PassRandom::independent(seed, stream, pass).path(path)
    }

    /// The numbers of branch `index` (below 2²³ - 1) of this path, where it splits. A branch does not split again.
    pub fn branch(&self, index: u32) -> Self {
        Self { stream: self.stream & 0xff | (index + 1) << 8, sequence: None, ..*self }
    }

    /// Four numbers in [0, 1), multiples of 2⁻²⁴. The first two are a point of the unit square that may be spread evenly, and so
    /// are the last two.
    #[inline]
    pub fn block(&self, block: u32) -> [f32; 4] {
        self.bits(block).map(|bits| (bits >> 8) as f32 * (1.0 / 16_777_216.0))
    }

    /// The 32-bit numbers of a block.
    #[inline]
    fn bits(&self, block: u32) -> [u32; 4] {
        match self.sequence {
            Some(sequence) if block < SPREAD_BLOCKS => sequence.block(block),
            _ => philox::<7>([self.path, self.pass, self.first_block.wrapping_add(block), self.stream], self.key),
        }
    }
}

impl Numbers for PathRandom {
    #[inline(always)]
    fn block(&self, block: u32) -> [f32; 4] {
        Self::block(self, block)
    }

    #[inline(always)]
    fn branch(&self, index: u32) -> Self {
        Self::branch(self, index)
    }
}

/// Point `index` of `count` that are spread evenly over the unit square (Hammersley's), all shifted by two numbers in
/// [0, 1) round its borders: with a random shift each alone is uniform.
#[inline]
pub fn spread(shift: [f32; 2], index: u32, count: u32) -> [f32; 2] {
    let wrapped = |value: f32| if value >= 1.0 { value - 1.0 } else { value };
    let radical_inverse = (index.reverse_bits() >> 8) as f32 * (1.0 / 16_777_216.0);
    [wrapped(shift[0] + index as f32 / count as f32), wrapped(shift[1] + radical_inverse)]
}

/// Point `index` of a row of which every run is spread evenly over the unit square, shifted by two numbers in [0, 1) round its borders
/// [Roberts 2018, R2].
#[inline]
pub fn spread_row(shift: [f32; 2], index: u32) -> [f32; 2] {
    // 2³² over the plastic number, and over its square.
    const STEPS: [u32; 2] = [3_242_174_889, 2_447_445_414];
    let wrapped = |value: f32| if value >= 1.0 { value - 1.0 } else { value };
    [0, 1].map(|axis| {
        let step = (index.wrapping_mul(STEPS[axis]) >> 8) as f32 * (1.0 / 16_777_216.0);
        wrapped(shift[axis] + step)
    })
}

/// Which block of a path's numbers decides what. A vertex owns two blocks: scattering and light sampling.
pub mod dimension {
    /// Pixel position (2 numbers) and lens position (2).
    pub const CAMERA: u32 = 0;
    /// Emission position (2) and light choice (1).
    pub const EMISSION: u32 = 0;
    /// Emission direction (2).
    pub const EMISSION_DIRECTION: u32 = 1;

    /// Scattering at path vertex `vertex`: two for the direction, lobe, roulette.
    pub const fn scattering(vertex: u32) -> u32 {
        2 * vertex
    }

    /// Light sampling at path vertex `vertex`: two for the position, light choice.
    pub const fn light(vertex: u32) -> u32 {
        1 + 2 * vertex
    }

    /// Light sampling at path vertex `vertex` with picks of another kind: two for the position, light choice.
    pub const fn guided_light(vertex: u32) -> u32 {
        (1 << 20) + vertex
    }

    /// Whether the photon at vertex `vertex` of a light path is stored (1).
    pub const fn storing(vertex: u32) -> u32 {
        1 << 30 | vertex
    }

    /// How mutation `mutation` of a photon path changes its emission (4).
    pub const fn mutation(mutation: u32) -> u32 {
        1 << 31 | mutation
    }

    /// As many flights through media a joint may have.
    pub const FLIGHTS: u32 = 64;

    /// The branch of the flight through a medium at step `step` of a path, below 65536.
    pub const fn flight(step: u32) -> u32 {
        2 * FLIGHTS * step
    }

    /// The branch of flight `flight`, below [`FLIGHTS`], of the joint at step `step`.
    pub const fn joint(step: u32, flight: u32) -> u32 {
        2 * FLIGHTS * step + FLIGHTS + flight
    }
}

/// Philox4x32 with `ROUNDS` rounds.
#[inline]
fn philox<const ROUNDS: usize>(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..ROUNDS {
        let first = u64::from(counter[0]) * 0xD251_1F53;
        let second = u64::from(counter[2]) * 0xCD9E_8D57;
        counter = [
            (second >> 32) as u32 ^ counter[1] ^ key[0],
            second as u32,
            (first >> 32) as u32 ^ counter[3] ^ key[1],
            first as u32,
        ];
        key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::philox;

    /// Known answers published with Random123 (`kat_vectors`), philox4x32 with 7 and with 10 rounds.
    #[test]
    fn analytic_philox_gives_the_published_answers() {
        let pi = ([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]);
        assert_eq!(philox::<7>([0; 4], [0; 2]), [0x5f6f_b709, 0x0d89_3f64, 0x4f12_1f81, 0x4f73_0a48]);
        assert_eq!(philox::<7>([u32::MAX; 4], [u32::MAX; 2]), [0x5207_ddc2, 0x4516_5e59, 0x4d8e_e751, 0x8c52_f662]);
        assert_eq!(philox::<7>(pi.0, pi.1), [0x4dfc_caba, 0x190a_87f0, 0xc473_62ba, 0xb6b5_242a]);
        assert_eq!(philox::<10>([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox::<10>([u32::MAX; 4], [u32::MAX; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        assert_eq!(philox::<10>(pi.0, pi.1), [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]);
    }
}
