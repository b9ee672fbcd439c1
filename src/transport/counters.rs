//! What passes count: the same everywhere, so that cost can be planned without a clock.

use std::ops::AddAssign;

/// Counts of a pass or of a part of one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Rays traced, of all kinds.
    pub rays: u64,
    /// Photons emitted.
    pub photons_emitted: u64,
    /// Photons stored.
    pub photons_stored: u64,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.photons_emitted += other.photons_emitted;
        self.photons_stored += other.photons_stored;
        self.non_finite += other.non_finite;
    }
}
