//! Numbers that are kept and can be changed: a point of the primary sample space [Kelemen et al. 2002].

use super::{Numbers, PathRandom, Stream};

/// The numbers of one path, kept by block.
#[derive(Clone, Copy, Debug)]
pub struct RecordedNumbers<'a> {
    blocks: &'a [[f32; 4]],
    /// In place of the first two of the first block.
    first: [f32; 2],
}

impl<'a> RecordedNumbers<'a> {
    /// As they are kept.
    pub fn new(blocks: &'a [[f32; 4]]) -> Self {
        let first = blocks.first().map_or([0.5; 2], |block| [block[0], block[1]]);
        Self { blocks, first }
    }

    /// The same with other numbers at first: where on a pixel a path starts, once the pixel has been taken from those that are kept.
    pub fn starting_at(self, first: [f32; 2]) -> Self {
        Self { first, ..self }
    }
}

impl Numbers for RecordedNumbers<'_> {
    /// A path that is longer than it was meant to be has no more numbers: the middle stands for them.
    #[inline]
    fn block(&self, block: u32) -> [f32; 4] {
        let numbers = self.blocks.get(block as usize).copied().unwrap_or([0.5; 4]);
        if block == 0 { [self.first[0], self.first[1], numbers[2], numbers[3]] } else { numbers }
    }

    /// Branches change with every number of the first blocks, wildly.
    fn branch(&self, index: u32) -> PathRandom {
        let bits = self.blocks.iter().take(2).flatten().fold(0u64, |bits, number| {
            (bits ^ u64::from(number.to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31)
        });
        PathRandom::new(bits, Stream::Branch, 0, 0).branch(index)
    }
}
