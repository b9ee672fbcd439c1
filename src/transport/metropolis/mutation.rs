//! Changes of recorded numbers [Kelemen et al. 2002]: all of them anew, or each by a little.

use crate::math::random::{Numbers, PathRandom};

/// The smallest and the largest step of a small change.
const STEPS: [f32; 2] = [1.0 / 1024.0, 1.0 / 64.0];

/// As many independent numbers as it takes, one after the other.
pub struct Source {
    random: PathRandom,
    block: u32,
    rest: [f32; 4],
    used: usize,
}

impl Source {
    /// Those of `random` from its first block on.
    pub fn new(random: PathRandom) -> Self {
        Self { random, block: 0, rest: [0.0; 4], used: 4 }
    }

    /// The next number in [0, 1).
    #[inline]
    pub fn next(&mut self) -> f32 {
        if self.used == 4 {
            self.rest = Numbers::block(&self.random, self.block);
            self.block = self.block.wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.rest[self.used - 1]
    }
}

/// `number` moved by a small step to either side, round the borders of [0, 1). It is as likely to come back.
#[inline]
pub fn moved(number: f32, u: f32) -> f32 {
    let [smallest, largest] = STEPS;
    let (side, u) = if u < 0.5 { (1.0, 2.0 * u) } else { (-1.0, 2.0 * u - 1.0) };
    let step = largest * libm::expf(-(largest / smallest).ln() * u);
    let moved = number + side * step;
    let wrapped = if moved < 0.0 { moved + 1.0 } else { moved };
    if wrapped >= 1.0 { wrapped - 1.0 } else { wrapped }
}
