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

macro_rules! steps {
    ($($(#[$about:meta])* $kind:ident = $name:literal,)+) => {
        /// What is proposed to a chain.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Step {
            $($(#[$about])* $kind,)+
        }

        impl Step {
            /// All kinds.
            pub const ALL: &'static [Self] = &[$(Self::$kind),+];

            /// What people read.
            pub fn name(self) -> &'static str {
                match self { $(Self::$kind => $name),+ }
            }
        }
    };
}

steps! {
    /// All numbers of its path change by a little.
    Small = "small_step",
    /// A path that does not depend on it.
    Large = "large_step",
    /// Some vertices of its path are replaced, from both ends of the gap.
    Bidirectional = "bidirectional",
    /// Another place of the film, near its own, and all that follows up to the first wide enough surface.
    Lens = "lens_perturbation",
    /// Another place of the film.
    LensSubpath = "lens_subpath",
    /// Another direction into mirrors and glass, near its own.
    Caustic = "caustic_perturbation",
    /// Another direction from the first surface that is no mirror to the second.
    PhotonMap = "photon_map",
    /// A path near one that a user gave.
    User = "user_path",
}

/// Proposals to chains, by kind of step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCounts {
    /// All of them.
    pub proposed: [u64; Step::ALL.len()],
    /// Those that became the chain's next state.
    pub accepted: [u64; Step::ALL.len()],
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
