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
    /// What chains were proposed.
    pub steps: StepCounts,
}

/// What is proposed to a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// All numbers of its path change by a little.
    Small,
    /// All are new.
    Large,
}

/// Proposals to chains, by kind of step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCounts {
    /// All of them.
    pub proposed: [u64; Step::COUNT],
    /// Those that became the chain's next state.
    pub accepted: [u64; Step::COUNT],
}

impl Step {
    /// How many kinds there are.
    pub const COUNT: usize = 2;
    /// Their names, in the order of the kinds.
    pub const NAMES: [&str; Self::COUNT] = ["small_step", "large_step"];
}

impl StepCounts {
    /// Counts a proposal.
    #[inline]
    pub fn count(&mut self, step: Step, accepted: bool) {
        self.proposed[step as usize] += 1;
        self.accepted[step as usize] += u64::from(accepted);
    }
}

impl AddAssign for StepCounts {
    fn add_assign(&mut self, other: Self) {
        let add = |sums: &mut [u64], counts: &[u64]| sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        add(&mut self.proposed, &other.proposed);
        add(&mut self.accepted, &other.accepted);
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.photons_emitted += other.photons_emitted;
        self.photons_stored += other.photons_stored;
        self.non_finite += other.non_finite;
        self.steps += other.steps;
    }
}
