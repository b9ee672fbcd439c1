//! Changes of recorded numbers [Kelemen et al. 2002]: all of them anew, or each by a little.

use crate::math::random::PathRandom;
use crate::math::trigonometry::sin_cos_turn;
use crate::math::{Frame, Vec3};

/// The largest step of a small change, unless something else is known to be better.
pub const LARGEST_STEP: f32 = 1.0 / 64.0;
/// How often steps are halved from the largest to the smallest.
const HALVINGS: f32 = 6.0;

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
    pub fn number(&mut self) -> f32 {
        if self.used == 4 {
            self.rest = self.random.block(self.block);
            self.block = self.block.wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.rest[self.used - 1]
    }

    /// `direction`, a unit vector, turned by an angle between the two of `range`, radians; angles of all orders of size are about as frequent. By solid
    /// angle the density is the same both ways.
    pub fn turned(&mut self, direction: Vec3, [smallest, largest]: [f32; 2]) -> Vec3 {
        let angle = largest * libm::powf(smallest / largest, self.number());
        self.turned_by(direction, angle)
    }

    /// `direction` turned by an angle of which all up to `largest`, radians, are as frequent.
    pub fn turned_evenly(&mut self, direction: Vec3, largest: f32) -> Vec3 {
        let angle = largest * self.number();
        self.turned_by(direction, angle)
    }

    fn turned_by(&mut self, direction: Vec3, angle: f32) -> Vec3 {
        let (sine, cosine) = libm::sincosf(angle);
        let (y, x) = sin_cos_turn(self.number());
        Frame::from_normal(direction).to_world(Vec3::new(x * sine, y * sine, cosine)).normalize()
    }
}

/// `number` moved by a small step to either side, round the borders of [0, 1); `largest`, at most 1/2, is the largest step, and the smallest 2⁻⁶ of it. It is
/// as likely to come back. Steps of all orders of size are about as frequent.
#[inline]
pub fn moved(number: f32, u: f32, largest: f32) -> f32 {
    let (side, u) = if u < 0.5 { (1.0, 2.0 * u) } else { (-1.0, 2.0 * u - 1.0) };
    let moved = number + side * largest * halved(HALVINGS * u);
    let wrapped = if moved < 0.0 { moved + 1.0 } else { moved };
    if wrapped >= 1.0 { wrapped - 1.0 } else { wrapped }
}

/// 2^−`times` for whole numbers in [0, 127), straight lines between them.
#[inline]
fn halved(times: f32) -> f32 {
    let whole = times as u32;
    let power = f32::from_bits((127 - whole) << 23);
    power * (1.0 - 0.5 * (times - whole as f32))
}
