//! Evenly spread numbers: the (0, 2)-sequence of Sobol' with Owen's scrambling, padded to any number of dimensions.
//!
//! Four numbers of a block are two points of the unit square, the first two and the last two, each of its own scrambled and shuffled sequence
//! [Burley 2020, "Practical hash-based Owen scrambling"]. Any 2ᵐ samples that start at a multiple of 2ᵐ put exactly one
//! point into every box of area 2⁻ᵐ with sides that are powers of two; each number alone is uniform, and points of different blocks are
//! independent.

use wide::u32x4;

/// A sample of a family of scrambled sequences.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sequence {
    /// What the scrambling of each lane comes from.
    key: u32x4,
    /// The sample's index, its bits reversed.
    reversed: u32,
}

impl Sequence {
    /// Sample `index` of the family with this key.
    #[inline]
    pub(super) fn new(key: [u32; 4], index: u32) -> Self {
        Self { key: u32x4::new(key), reversed: index.reverse_bits() }
    }

    /// The 32-bit numbers of a block.
    #[inline]
    pub(super) fn block(&self, block: u32) -> [u32; 4] {
        let key = mixed(self.key + u32x4::splat(block.wrapping_mul(0x9e37_79b9)));
        let [a, b, ..] = mixed(key ^ u32x4::splat(0x68bc_21eb)).to_array();
        let shuffled = reverse(scrambled(u32x4::splat(self.reversed), u32x4::new([a, a, b, b])));
        let second = binomial(shuffled);
        let lanes = u32x4::new([u32::MAX, 0, u32::MAX, 0]);
        reverse(scrambled((shuffled & lanes) | (second & !lanes), key)).to_array()
    }
}

/// A bijection that spreads every bit over the word [Mueller's hash32, as "lowbias32" by Wellons 2018].
#[inline(always)]
fn mixed(mut x: u32x4) -> u32x4 {
    x = (x ^ (x >> 16)) * u32x4::splat(0x7feb_352d);
    x = (x ^ (x >> 15)) * u32x4::splat(0x846c_a68b);
    x ^ (x >> 16)
}

/// Owen's scrambling of a number whose bits are reversed: each bit is flipped by a hash of the lower ones
/// [Laine & Karras 2011; constants of Vegdahl 2021].
#[inline(always)]
fn scrambled(mut x: u32x4, key: u32x4) -> u32x4 {
    x ^= x * u32x4::splat(0x3d20_adea);
    x += key;
    x *= (key >> 16) | u32x4::splat(1);
    x ^= x * u32x4::splat(0x0552_6c56);
    x ^ (x * u32x4::splat(0x53a2_2864))
}

/// The bits of Sobol's second number, reversed, from the sample's index: index bits as the coefficients of a polynomial
/// p(x) over GF(2), those of p(x + 1) are the answer, since the generator matrix is Pascal's triangle modulo 2.
#[inline(always)]
fn binomial(mut x: u32x4) -> u32x4 {
    x ^= (x >> 16) & u32x4::splat(0x0000_ffff);
    x ^= (x >> 8) & u32x4::splat(0x00ff_00ff);
    x ^= (x >> 4) & u32x4::splat(0x0f0f_0f0f);
    x ^= (x >> 2) & u32x4::splat(0x3333_3333);
    x ^ ((x >> 1) & u32x4::splat(0x5555_5555))
}

/// All bits in reversed order.
#[inline(always)]
fn reverse(mut x: u32x4) -> u32x4 {
    x = ((x >> 1) & u32x4::splat(0x5555_5555)) | ((x & u32x4::splat(0x5555_5555)) << 1);
    x = ((x >> 2) & u32x4::splat(0x3333_3333)) | ((x & u32x4::splat(0x3333_3333)) << 2);
    x = ((x >> 4) & u32x4::splat(0x0f0f_0f0f)) | ((x & u32x4::splat(0x0f0f_0f0f)) << 4);
    x = ((x >> 8) & u32x4::splat(0x00ff_00ff)) | ((x & u32x4::splat(0x00ff_00ff)) << 8);
    (x >> 16) | (x << 16)
}

#[cfg(test)]
mod tests {
    use super::Sequence;

    const KEY: [u32; 4] = [1, 20, 300, 4000];

    fn pairs(index: u32, block: u32) -> [[f64; 2]; 2] {
        let [a, b, c, d] = Sequence::new(KEY, index).block(block).map(|bits| f64::from(bits) / 4_294_967_296.0);
        [[a, b], [c, d]]
    }

    /// 2ᵐ samples from a multiple of 2ᵐ put one point into every box of sides 2⁻ᵏ and 2ᵏ⁻ᵐ.
    #[test]
    fn aligned_samples_fill_every_box_once() {
        for (start, bits) in [(0u32, 6u32), (64, 6), (1 << 20, 8), (7 << 10, 10)] {
            for (block, pair, k) in (0..3).flat_map(|b| (0..2).flat_map(move |p| (0..=bits).map(move |k| (b, p, k)))) {
                let mut boxes = vec![0; 1 << bits];
                for index in start..start + (1 << bits) {
                    let [x, y] = pairs(index, block)[pair];
                    let (column, row) =
                        ((x * f64::from(1u32 << k)) as usize, (y * f64::from(1u32 << (bits - k))) as usize);
                    boxes[(row << k) + column] += 1;
                }
                assert!(boxes.iter().all(|points| *points == 1), "block {block}, pair {pair}, {start} + 2^{bits}, {k}");
            }
        }
    }

    /// Numbers of different pairs and blocks have nothing to do with each other: chi-square over 16 × 16 cells of 16,384 samples,
    /// below the 0.01 % quantile of 255 degrees of freedom (336) for each of 15 pairs of numbers.
    #[test]
    fn pairs_are_independent_of_each_other() {
        const SAMPLES: u32 = 1 << 14;
        let numbers = |index: u32| -> Vec<f64> {
            (0..3).flat_map(|block| pairs(index, 7 * block).map(|pair| pair[(block % 2) as usize])).collect()
        };
        let samples: Vec<Vec<f64>> = (0..SAMPLES).map(numbers).collect();
        for (first, second) in (0..6).flat_map(|first| (0..first).map(move |second| (first, second))) {
            let mut cells = [0u32; 256];
            for numbers in &samples {
                cells[(numbers[first] * 16.0) as usize * 16 + (numbers[second] * 16.0) as usize] += 1;
            }
            let expected = f64::from(SAMPLES) / 256.0;
            let chi_square: f64 = cells.iter().map(|count| (f64::from(*count) - expected).powi(2) / expected).sum();
            assert!(chi_square < 336.0, "numbers {first} and {second}: {chi_square}");
        }
    }
}
