//! Changes of paths, one file each and one row in `proposals!`.
//!
//! Each keeps some vertices at both ends, makes a path, and tells with what density it would have made it: forth, and back from the new one.

mod bidirectional;
mod caustic;
mod lens;
mod photon_map;
mod user_path;

use super::extension::Tracer;
use super::path::Terms;
use super::{Path, PathSpace, PathState};
use crate::transport::Counters;
use crate::transport::counters::Step;
use crate::transport::metropolis::mutation::Source;

/// Numbers of vertices at the ends of a path that a change keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    /// From x₀ on.
    pub light: usize,
    /// From x_k back; at least 1.
    pub camera: usize,
}

/// What is to come between them.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// What is kept.
    pub kept: Kept,
    /// New vertices of the light subpath.
    pub light: usize,
    /// New vertices of the camera subpath.
    pub camera: usize,
}

/// A new path before anything is known of it.
#[derive(Clone, Copy, Debug)]
pub struct Draft {
    /// What it has from the path before.
    pub kept: Kept,
    /// The index of the first vertex behind the segment that joins its subpaths; 0 where a camera subpath hit a light.
    pub connection: usize,
}

/// A path with all its factors.
#[derive(Clone, Copy)]
struct Known<'a> {
    path: &'a Path,
    terms: &'a Terms,
}

macro_rules! proposals {
    ($($kind:ident = $module:ident, $step:ident;)+) => {
        /// A kind of change.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Proposal { $(#[doc = concat!("See `", stringify!($module), "`.")] $kind),+ }

        impl Proposal {
            /// All kinds.
            pub const ALL: &'static [Self] = &[$(Self::$kind),+];

            /// What it is counted as.
            pub fn step(self) -> Step {
                match self { $(Self::$kind => Step::$step),+ }
            }
        }
    };
}

// Table of proposals: name, file, step.
proposals! {
    Bidirectional = bidirectional, Bidirectional;
    LensSubpath = lens, LensSubpath;
    Lens = lens, Lens;
    Caustic = caustic, Caustic;
    PhotonMap = photon_map, PhotonMap;
    User = user_path, User;
}

/// How often each kind is proposed.
#[derive(Clone, Debug)]
pub struct Shares([f32; Proposal::ALL.len()]);

impl Shares {
    /// Parts of all for each kind, in the order of [`Proposal::ALL`].
    pub fn new(parts: [f32; Proposal::ALL.len()]) -> Self {
        Self(parts)
    }

    /// That of a kind, in parts of all.
    pub fn of(&self, kind: Proposal) -> f64 {
        f64::from(self.0[kind as usize])
    }

    /// The kind that `u` in [0, 1) picks.
    pub fn pick(&self, u: f32) -> Proposal {
        let mut rest = u * self.0.iter().sum::<f32>();
        for (share, kind) in self.0.iter().zip(Proposal::ALL) {
            rest -= share;
            if rest < 0.0 {
                return *kind;
            }
        }
        Proposal::Bidirectional
    }
}

impl PathSpace<'_> {
    /// Makes `to` of `from`; the probability with which it is to be taken.
    pub(super) fn propose(
        &self,
        kind: Proposal,
        from: &PathState,
        to: &mut PathState,
        source: &mut Source,
        counters: &mut Counters,
    ) -> Option<f32> {
        let before = Known { path: &from.path, terms: &from.terms };
        let PathState { path, chain, .. } = &mut *to;
        let mut tracer = Tracer { scene: self.scene, counters, chain };
        let draft = match kind {
            Proposal::Bidirectional => {
                let gap = self.gap(from.path.segments(), source)?;
                let connection = self.fill(&from.path, &gap, to, source, counters)?;
                Draft { kept: gap.kept, connection }
            }
            Proposal::LensSubpath => self.move_film(before, path, lens::Move::Anywhere, &mut tracer, source)?,
            Proposal::Lens => self.move_film(before, path, lens::Move::Near, &mut tracer, source)?,
            Proposal::Caustic => self.turn_into_specular(before, path, &mut tracer, source)?,
            Proposal::PhotonMap => self.turn_at_first_smooth(before, path, &mut tracer, source)?,
            Proposal::User => self.follow_user(before, path, &mut tracer, source)?,
        };
        if !self.lengths.contain(to.path.segments() as u32) {
            return None;
        }
        self.finish(to, draft.connection, counters)?;
        let after = Known { path: &to.path, terms: &to.terms };
        let [forth, back] =
            [(before, after), (after, before)].map(|(from, to)| self.density(kind, draft.kept, from, to));
        let [before, after] = [before, after].map(|known| self.sought(known.path, known.terms));
        let ratio = after * back / (before * forth);
        (ratio > 0.0).then_some(ratio.min(1.0) as f32)
    }

    /// T: the density with which `from` becomes `to`, but for what is the same both ways.
    fn density(&self, kind: Proposal, kept: Kept, from: Known<'_>, to: Known<'_>) -> f64 {
        match kind {
            Proposal::Bidirectional | Proposal::User => self.hybrid_density(kept, from, to),
            Proposal::LensSubpath | Proposal::Lens => self.film_density(kept, to),
            Proposal::Caustic => caustic_density(kept, to),
            Proposal::PhotonMap => first_smooth_density(kept, to),
        }
    }
}

use caustic::caustic_density;
use photon_map::first_smooth_density;
