//! Random permutations whose every entry is found by itself, without a table.

use super::PathRandom;

/// A random order of the numbers below a length.
#[derive(Clone, Copy, Debug)]
pub struct Permutation {
    key: u32,
    length: u32,
    /// The least number of the form 2ⁿ − 1 that is not below `length` − 1.
    mask: u32,
}

impl Permutation {
    /// An order of `length` numbers, at least 1, that belongs to the path's numbers.
    pub fn new(random: &PathRandom, length: u32) -> Self {
        let [key, ..] = random.bits(0);
        let mask = u32::MAX.checked_shr((length - 1).leading_zeros()).unwrap_or(0);
        Self { key, length, mask }
    }

    /// Where number `index` comes in the order. A hash permutes the numbers up to the mask; what it puts out of range is hashed again
    /// [Kensler 2013, section 5].
    pub fn place(&self, index: u32) -> u32 {
        let Self { key, length, mask } = *self;
        let mut place = self.hashed(index);
        while place >= length {
            place = self.hashed(place);
        }
        debug_assert!(place <= mask);
        ((u64::from(place) + u64::from(key)) % u64::from(length)) as u32
    }

    /// One round. Every step is a bijection of the bits of the mask: a higher bit never flows into a lower one but by a shift within the
    /// mask.
    fn hashed(&self, mut i: u32) -> u32 {
        let Self { key, mask, .. } = *self;
        i = (i ^ key).wrapping_mul(0xe170_893d);
        i ^= key >> 16;
        i ^= (i & mask) >> 4;
        i = (i ^ key >> 8).wrapping_mul(0x0929_eb3f);
        i ^= key >> 23;
        i ^= (i & mask) >> 1;
        i = i.wrapping_mul(1 | key >> 27);
        i = i.wrapping_mul(0x6935_fa69);
        i ^= (i & mask) >> 11;
        i = i.wrapping_mul(0x74dc_b303);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0x9e50_1cc3);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0xc860_a3df) & mask;
        i ^ i >> 5
    }
}

#[cfg(test)]
mod tests {
    use super::Permutation;
    use crate::math::random::{PathRandom, Stream};

    #[test]
    fn every_number_comes_once() {
        for length in [1, 2, 3, 5, 64, 65, 1000, 129 * 97] {
            let permutation = Permutation::new(&PathRandom::new(3, Stream::MapChoice, length, 0), length);
            let mut seen = vec![false; length as usize];
            (0..length).for_each(|index| seen[permutation.place(index) as usize] = true);
            assert!(seen.into_iter().all(|seen| seen), "{length} numbers");
        }
    }

    /// Classes of the places of neighbors, modulo 16, have nothing to do with each other: chi-square over 16 × 16 pairs, below the 0.01 %
    /// quantile of 255 degrees of freedom (336), for neighbors in a row and neighbors in a column.
    #[test]
    fn neighbors_come_anywhere() {
        const WIDTH: u32 = 257;
        for (pass, step) in (0..8).flat_map(|pass| [(pass, 1), (pass, WIDTH)]) {
            let permutation = Permutation::new(&PathRandom::new(3, Stream::MapChoice, pass, 0), WIDTH * WIDTH);
            let mut pairs = [0u32; 256];
            let count = WIDTH * (WIDTH - 1) / 2;
            for index in 0..count {
                // Pairs that do not overlap.
                let first = index / step * 2 * step + index % step;
                if first + step >= WIDTH * WIDTH {
                    continue;
                }
                let class = |index: u32| (permutation.place(index) % 16) as usize;
                pairs[class(first) * 16 + class(first + step)] += 1;
            }
            let expected = f64::from(pairs.iter().sum::<u32>()) / 256.0;
            let chi_square: f64 = pairs.iter().map(|count| (f64::from(*count) - expected).powi(2) / expected).sum();
            assert!(chi_square < 336.0, "pass {pass}, neighbors {step} apart: {chi_square}");
        }
    }
}
