//! Evenly spread numbers: the (0, 2)-sequence of Sobol', scrambled, and padded to any number of dimensions.
//!
//! Four numbers of a block are two points of the unit square, the first two and the last two, each of its own randomization of the
//! sequence: index and both numbers are multiplied by random triangular matrices over GF(2) and shifted [Matoušek 1998, "On the L2-discrepancy for
//! anchored boxes"; the variance is that of Owen's scrambling]. Any 2ᵐ samples that start at a multiple of 2ᵐ put exactly
//! one point into every box of area 2⁻ᵐ with sides that are powers of two; each number alone is uniform.

use wide::u32x4;

use super::philox;

/// Blocks that are spread evenly.
pub(super) const BLOCKS: usize = 6;
const BITS: usize = 32;

/// The numbers of a sample.
pub(super) type Sample = [u32x4; BLOCKS];

/// A randomized sequence for each pair of numbers.
#[derive(Clone, Debug)]
pub(super) struct Sequences {
    /// The numbers of sample 0.
    shift: Sample,
    /// By index bit: what the bit changes in the numbers.
    columns: [Sample; BITS],
}

impl Sequences {
    /// The sequences that belong to a key and an address whose third word is free.
    pub(super) fn new(key: [u32; 2], [family, member, _, stream]: [u32; 4]) -> Self {
        let random = |block: usize, number: usize| {
            let words = philox::<7>([family, member, (block * 256 + number) as u32, stream], key);
            u32x4::new(words)
        };
        let mut sequences = Self { shift: [u32x4::ZERO; BLOCKS], columns: [[u32x4::ZERO; BLOCKS]; BITS] };
        for block in 0..BLOCKS {
            sequences.shift[block] = random(block, 0);
            // Digits of the numbers are changed by the more significant ones; lanes have matrices of their own.
            let scramble: Vec<u32x4> = (0..BITS).map(|bit| unit_below(random(block, 1 + bit), bit)).collect();
            for bit in 0..BITS {
                // Bits of the index are changed by higher ones, alike for both numbers of a pair.
                let [first, second, ..] = random(block, 1 + BITS + bit).to_array();
                let [first, second] = [first, second].map(|random| random & ((1 << bit) - 1) | 1 << bit);
                let numbers = [first, binomial(first), second, binomial(second)].map(u32::reverse_bits);
                sequences.columns[bit][block] = product(&scramble, u32x4::new(numbers));
            }
        }
        sequences
    }

    /// Sample `index`. Consecutive ones differ in a single bit of their Gray code, which takes them in another order within any
    /// aligned range.
    #[inline]
    pub(super) fn sample(&self, index: u32) -> Sample {
        let mut sample = self.shift;
        let mut bits = index ^ index >> 1;
        while bits != 0 {
            let column = &self.columns[bits.trailing_zeros() as usize];
            for block in 0..BLOCKS {
                sample[block] ^= column[block];
            }
            bits &= bits - 1;
        }
        sample
    }
}

/// Column `digit` of a matrix with ones on its diagonal and random bits below it, digits counted from the most significant.
fn unit_below(random: u32x4, digit: usize) -> u32x4 {
    let diagonal = 1u32 << (BITS - 1 - digit);
    (random & u32x4::splat(diagonal - 1)) | u32x4::splat(diagonal)
}

/// The product of a matrix for each lane with a vector for each lane.
fn product(columns: &[u32x4], vector: u32x4) -> u32x4 {
    let lanes = vector.to_array();
    columns.iter().enumerate().fold(u32x4::ZERO, |sum, (digit, column)| {
        let taken = lanes.map(|lane| if lane >> (BITS - 1 - digit) & 1 != 0 { u32::MAX } else { 0 });
        sum ^ (*column & u32x4::new(taken))
    })
}

/// The bits of Sobol's second number, reversed, from the sample's index: index bits as the coefficients of a polynomial
/// p(x) over GF(2), those of p(x + 1) are the answer, since the generator matrix is Pascal's triangle modulo 2.
fn binomial(mut x: u32) -> u32 {
    for (shift, mask) in [(16, 0x0000_ffff), (8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        x ^= x >> shift & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::Sequences;

    fn pairs(sequences: &Sequences, index: u32, block: usize) -> [[f64; 2]; 2] {
        let [a, b, c, d] = sequences.sample(index)[block].to_array().map(|bits| f64::from(bits) / 4_294_967_296.0);
        [[a, b], [c, d]]
    }

    /// 2ᵐ samples from a multiple of 2ᵐ put one point into every box of sides 2⁻ᵏ and 2ᵏ⁻ᵐ.
    #[test]
    fn aligned_samples_fill_every_box_once() {
        let sequences = Sequences::new([1, 2], [3, 4, 0, 5]);
        for (start, bits) in [(0u32, 6u32), (64, 6), (1 << 20, 8), (7 << 10, 10)] {
            for (block, pair, k) in (0..3).flat_map(|b| (0..2).flat_map(move |p| (0..=bits).map(move |k| (b, p, k)))) {
                let mut boxes = vec![0; 1 << bits];
                for index in start..start + (1 << bits) {
                    let [x, y] = pairs(&sequences, index, block)[pair];
                    let (column, row) =
                        ((x * f64::from(1u32 << k)) as usize, (y * f64::from(1u32 << (bits - k))) as usize);
                    boxes[(row << k) + column] += 1;
                }
                assert!(boxes.iter().all(|points| *points == 1), "block {block}, pair {pair}, {start} + 2^{bits}, {k}");
            }
        }
    }

    /// Numbers of different pairs have nothing to do with each other: chi-square over 8 × 8 cells of 256 samples of 64 families
    /// together, below the 0.001 % quantile of 63 degrees of freedom (122) for each of 15 pairs of numbers.
    #[test]
    fn pairs_are_independent_of_each_other() {
        let families: Vec<Sequences> = (0..64).map(|family| Sequences::new([1, 2], [family, 0, 0, 0])).collect();
        let numbers = |family: &Sequences, index: u32| -> Vec<f64> {
            (0..3).flat_map(|block| pairs(family, index, block).map(|pair| pair[block % 2])).collect()
        };
        let samples: Vec<Vec<f64>> =
            families.iter().flat_map(|family| (0..256).map(move |index| numbers(family, index))).collect();
        for (first, second) in (0..6).flat_map(|first| (0..first).map(move |second| (first, second))) {
            let mut cells = [0u32; 64];
            for numbers in &samples {
                cells[(numbers[first] * 8.0) as usize * 8 + (numbers[second] * 8.0) as usize] += 1;
            }
            let expected = samples.len() as f64 / 64.0;
            let chi_square: f64 = cells.iter().map(|count| (f64::from(*count) - expected).powi(2) / expected).sum();
            assert!(chi_square < 122.0, "numbers {first} and {second}: {chi_square}");
        }
    }
}
