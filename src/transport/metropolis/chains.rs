//! Chains of paths: the samples of a pass of Metropolis light transport, whatever their states are made of.
//!
//! A pass samples some paths independently first, over all lengths and ways. Its chains start at some of them, picked in proportion to f*, so that no chain
//! has a start-up bias however short it is [V97, 11.3.1]. Large steps are independent samples, too. By the balance heuristic what a path brings counts
//! 1/(n_u + n_c·f*/b₀), with n_u independent samples, n_c states of chains and b₀ about the mean of f* [KSAC02, section 5]; states of chains count b/b₀ times
//! as much, b being the mean of f* over the paths that chains start from. Whatever b₀ is that does not depend on them, means are right.
//!
//! References: \[V97\] Veach 1997; \[KSAC02\] Kelemen et al. 2002, "A simple and robust mutation strategy for the Metropolis light transport algorithm".

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::mutation::Source;
use crate::math::discrete::Discrete;
use crate::math::random::PassRandom;
use crate::transport::Counters;
use crate::transport::counters::Step;

/// Beside the mutations of a pass, one path to so many of them is sampled independently; chains start there.
const MUTATIONS_PER_START: u32 = 4;
/// One path more to so many mutations tells b₀.
const MUTATIONS_PER_TRIAL: u32 = 16;
/// b₀ where trials find no light: so small that only states of chains count. Later paths of the pass may find some.
const NOTHING_FOUND: f32 = 1e-20;
/// Probabilities that a path is longer by one more segment, each for a third of all paths. Where light is hardly absorbed long paths
/// bring as much as short ones, and if they were much rarer some would weigh too much.
const LONGER: [f32; 3] = [0.5, 0.8, 0.95];
/// Paths that are sampled one after the other.
const CHUNK: u32 = 256;

/// What chains move through.
pub trait Space: Sync {
    /// A path.
    type State: Default;
    /// What a path brings, scaled by its weight.
    type Brought: Send;

    /// Makes `state` an independent sample.
    fn renew(&self, state: &mut Self::State, source: &mut Source, counters: &mut Counters);

    /// Makes `to` a small change of `from`, which stays as it is.
    fn change(&self, from: &Self::State, to: &mut Self::State, source: &mut Source, counters: &mut Counters) -> Change;

    /// f*: the luminance of what a path brings, over the density with which it is sampled independently.
    fn target(&self, state: &Self::State) -> f32;

    /// Appends `weight` times what a path brings.
    fn show(&self, state: &Self::State, weight: f32, brought: &mut Vec<Self::Brought>);
}

/// A small change that a chain was proposed.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// Of what kind.
    pub step: Step,
    /// a: with what probability it is taken.
    pub acceptance: f32,
}

/// The probability of going from a state to a proposed one, where both are proposed as often. A path that brings nothing is never taken, also from one that
/// brings so little that it counts as nothing, too.
pub fn acceptance(proposed: f32, current: f32) -> f32 {
    if proposed > 0.0 { (proposed / current).min(1.0) } else { 0.0 }
}

/// How many segments paths have.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// The fewest.
    pub shortest: u32,
    /// The most.
    pub longest: Option<u32>,
}

impl Lengths {
    /// Whether a path may have so many.
    pub fn contain(&self, segments: u32) -> bool {
        segments >= self.shortest && self.longest.is_none_or(|longest| segments <= longest)
    }

    /// A length, each less probable than the one before.
    pub fn pick(&self, source: &mut Source) -> u32 {
        let goes_on = LONGER[((source.number() * LONGER.len() as f32) as usize).min(LONGER.len() - 1)];
        let mut segments = self.shortest;
        while self.longest.is_none_or(|longest| segments < longest) && source.number() < goes_on {
            segments += 1;
        }
        segments
    }

    /// The probability of a length.
    pub fn probability(&self, segments: u32) -> f32 {
        let ends = self.longest.is_none_or(|longest| segments < longest);
        let of = |goes_on: f32| {
            let longer = (self.shortest..segments).fold(1.0, |product, _| product * goes_on);
            if ends { longer * (1.0 - goes_on) } else { longer }
        };
        LONGER.map(of).iter().sum::<f32>() / LONGER.len() as f32
    }
}

/// The chains of a pass.
pub struct Chains<'a, S> {
    /// What they move through.
    pub space: &'a S,
    /// The probability of a large step.
    pub large_steps: f32,
    /// Mutations of all chains.
    pub mutations: u32,
    /// How many they are.
    pub chains: u32,
    /// Numbers of the paths that chains start from.
    pub starts: PassRandom,
    /// Numbers of the paths that tell b₀.
    pub trials: PassRandom,
    /// Numbers of mutations.
    pub steps: PassRandom,
}

/// What independent samples or a chain found.
pub struct Found<B> {
    /// What paths bring.
    pub brought: Vec<B>,
    /// What it took.
    pub counters: Counters,
}

impl<B> Default for Found<B> {
    fn default() -> Self {
        Self { brought: Vec::new(), counters: Counters::default() }
    }
}

/// How samples of the pass count.
#[derive(Clone, Copy)]
struct Weights {
    /// n_u.
    independent: f32,
    /// n_c/b₀.
    chained: f32,
    /// b/b₀.
    ratio: f32,
}

impl Weights {
    fn of_independent(&self, target: f32) -> f32 {
        1.0 / (self.independent + self.chained * target)
    }

    fn of_chained(&self, target: f32) -> f32 {
        self.ratio * self.of_independent(target)
    }
}

/// What independent samples brought, and f* of each.
type Independent<B> = (Vec<Found<B>>, Vec<f64>);

impl<S: Space> Chains<'_, S> {
    /// Makes the pass; `None` when cancelled. All that was found, in an order that does not depend on threads.
    pub fn trace(&self, cancel: &AtomicBool) -> Option<Vec<Found<S::Brought>>> {
        let (mean, counters) = self.expected(cancel)?;
        let count = (self.mutations / MUTATIONS_PER_START).max(self.chains);
        let chained = self.mutations as f32;
        let independent = count as f32 + chained * self.large_steps;
        let mut weights = Weights { independent, chained: chained / mean, ratio: 1.0 };
        let (mut found, targets) = self.independent(&weights, count, cancel)?;
        found.push(Found { counters, ..Found::default() });
        if let Some(starts) = Discrete::new(&targets) {
            weights.ratio = (starts.total() / f64::from(count)) as f32 / mean;
            let chains = (0..self.chains).into_par_iter().map(|chain| self.chain(&weights, &starts, chain, cancel));
            found.extend(chains.collect::<Vec<_>>());
        }
        (!cancel.load(Ordering::Relaxed)).then_some(found)
    }

    /// b₀, and what it took.
    fn expected(&self, cancel: &AtomicBool) -> Option<(f32, Counters)> {
        let count = (self.mutations / MUTATIONS_PER_TRIAL).max(CHUNK);
        let chunks = self.chunks(count, cancel, |paths| {
            let (mut counters, mut state) = (Counters::default(), S::State::default());
            let mut sum = 0.0;
            for path in paths {
                self.space.renew(&mut state, &mut Source::new(self.trials.path(path)), &mut counters);
                sum += f64::from(self.space.target(&state));
            }
            (sum, counters)
        })?;
        let (mut sum, mut total) = (0.0, Counters::default());
        for (of_chunk, counters) in chunks {
            sum += of_chunk;
            total += counters;
        }
        let mean = sum / f64::from(count);
        let is_found = mean > 0.0 && mean.is_finite();
        Some((if is_found { mean as f32 } else { NOTHING_FOUND }, total))
    }

    /// The independent samples that chains start from.
    fn independent(&self, weights: &Weights, count: u32, cancel: &AtomicBool) -> Option<Independent<S::Brought>> {
        let chunks = self.chunks(count, cancel, |paths| {
            let (mut found, mut state) = (Found::default(), S::State::default());
            let mut targets = Vec::with_capacity(paths.len());
            for path in paths {
                let mut source = Source::new(self.starts.path(path));
                self.space.renew(&mut state, &mut source, &mut found.counters);
                let target = self.space.target(&state);
                self.space.show(&state, weights.of_independent(target), &mut found.brought);
                targets.push(f64::from(target));
            }
            (found, targets)
        })?;
        let (found, targets): (Vec<_>, Vec<_>) = chunks.into_iter().unzip();
        Some((found, targets.concat()))
    }

    fn chunks<T: Send>(
        &self,
        count: u32,
        cancel: &AtomicBool,
        trace: impl Fn(Range<u32>) -> T + Sync,
    ) -> Option<Vec<T>> {
        let chunk = |index: u32| {
            let paths = index * CHUNK..count.min((index + 1) * CHUNK);
            (!cancel.load(Ordering::Relaxed)).then(|| trace(paths))
        };
        (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect()
    }

    /// Runs chain `index`.
    fn chain(&self, weights: &Weights, starts: &Discrete, index: u32, cancel: &AtomicBool) -> Found<S::Brought> {
        let space = self.space;
        let mut source = Source::new(self.steps.path(index));
        let (mut found, mut current, mut proposed) = (Found::default(), S::State::default(), S::State::default());
        let (start, _) = starts.pick((index as f32 + source.number()) / self.chains as f32);
        space.renew(&mut current, &mut Source::new(self.starts.path(start as u32)), &mut found.counters);
        let mut target = space.target(&current);
        // A state that stays counts once, with all its weight.
        let mut kept = 0.0;
        let steps = self.mutations / self.chains + u32::from(index < self.mutations % self.chains);
        for _ in 0..steps {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let change = if source.number() < self.large_steps {
                space.renew(&mut proposed, &mut source, &mut found.counters);
                Change { step: Step::Large, acceptance: acceptance(space.target(&proposed), target) }
            } else {
                space.change(&current, &mut proposed, &mut source, &mut found.counters)
            };
            let Change { step, acceptance } = change;
            let proposed_target = space.target(&proposed);
            // Both count by their probability, whichever is taken [V97, 11.4].
            kept += (1.0 - acceptance) * weights.of_chained(target);
            let sampled = if step == Step::Large { weights.of_independent(proposed_target) } else { 0.0 };
            let weight = acceptance * weights.of_chained(proposed_target) + sampled;
            let accepted = source.number() < acceptance;
            found.counters.steps.count(step, accepted);
            if accepted {
                space.show(&current, kept, &mut found.brought);
                std::mem::swap(&mut current, &mut proposed);
                (target, kept) = (proposed_target, weight);
            } else {
                space.show(&proposed, weight, &mut found.brought);
            }
        }
        space.show(&current, kept, &mut found.brought);
        found
    }
}
