//! Chains of multiplexed paths: the samples of a pass of Metropolis light transport.
//!
//! A pass samples some paths uniformly first, over all lengths and ways. Its chains start at some of them, picked in proportion to f*, so that no chain has a
//! start-up bias however short it is [V97, 11.3.1]. Large steps are uniform samples, too. By the balance heuristic what a path brings counts
//! 1/(n_u + n_c·f*/b₀), with n_u uniform samples, n_c states of chains and b₀ about the mean of f* [KSAC02, section 5]; states of chains count b/b₀ times
//! as much, b being the mean of f* over the paths that chains start from. Whatever b₀ is that does not depend on them, means are right.
//!
//! References: [V97] Veach 1997; [KSAC02] Kelemen et al. 2002, "A simple and robust mutation strategy for the Metropolis light transport algorithm".

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::mutation::{Source, moved};
use super::sample::{PathSampler, PrimarySample, Splat, blocks};
use crate::math::color::luminance;
use crate::math::discrete::Discrete;
use crate::math::random::PassRandom;
use crate::transport::Counters;
use crate::transport::counters::Step;

/// Beside the mutations of a pass, one path to so many of them is sampled uniformly; chains start there.
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

/// The chains of a pass.
pub struct PathChains<'a> {
    /// Makes paths.
    pub sampler: PathSampler<'a>,
    /// The fewest segments of a path.
    pub shortest: u32,
    /// The most.
    pub longest: Option<u32>,
    /// The probability of a large step.
    pub large_steps: f32,
    /// Mutations of all chains.
    pub mutations: u32,
    /// How many they are.
    pub chains: u32,
    /// Pixels of which anything is wanted.
    pub pixels: Range<u32>,
    /// Numbers of the paths that chains start from.
    pub starts: PassRandom,
    /// Numbers of the paths that tell b₀.
    pub trials: PassRandom,
    /// Numbers of mutations.
    pub steps: PassRandom,
}

/// What uniform samples or a chain found.
#[derive(Default)]
pub struct Found {
    /// What paths bring to pixels of the pass.
    pub splats: Vec<Splat>,
    /// What it took.
    pub counters: Counters,
}

/// A path, and what it brings over the probability of its length.
#[derive(Default)]
struct State {
    segments: u32,
    /// One over the probability of its length.
    scale: f32,
    numbers: PrimarySample,
    splats: Vec<Splat>,
    /// f*: their luminance.
    target: f32,
}

/// How samples of the pass count.
#[derive(Clone, Copy)]
struct Weights {
    /// n_u.
    uniform: f32,
    /// n_c/b₀.
    chained: f32,
    /// b/b₀.
    ratio: f32,
}

impl Weights {
    fn of_uniform(&self, target: f32) -> f32 {
        1.0 / (self.uniform + self.chained * target)
    }

    fn of_chained(&self, target: f32) -> f32 {
        self.ratio * self.of_uniform(target)
    }
}

impl PathChains<'_> {
    /// Makes the pass; `None` when cancelled. All that was found, in an order that does not depend on threads.
    pub fn trace(&self, cancel: &AtomicBool) -> Option<Vec<Found>> {
        let (mean, counters) = self.expected(cancel)?;
        let count = (self.mutations / MUTATIONS_PER_START).max(self.chains);
        let chained = self.mutations as f32;
        let uniform = count as f32 + chained * self.large_steps;
        let mut weights = Weights { uniform, chained: chained / mean, ratio: 1.0 };
        let (mut found, targets) = self.uniform(&weights, count, cancel)?;
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
            let (mut counters, mut state) = (Counters::default(), State::default());
            let mut sum = 0.0;
            for path in paths {
                self.renew(&mut state, &mut Source::new(self.trials.path(path)), &mut counters);
                sum += f64::from(state.target);
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

    /// The uniform samples that chains start from, and f* of each.
    fn uniform(&self, weights: &Weights, count: u32, cancel: &AtomicBool) -> Option<(Vec<Found>, Vec<f64>)> {
        let chunks = self.chunks(count, cancel, |paths| {
            let (mut found, mut state) = (Found::default(), State::default());
            let mut targets = Vec::with_capacity(paths.len());
            for path in paths {
                let mut source = Source::new(self.starts.path(path));
                self.renew(&mut state, &mut source, &mut found.counters);
                self.show(&state, weights.of_uniform(state.target), &mut found.splats);
                targets.push(f64::from(state.target));
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
    fn chain(&self, weights: &Weights, starts: &Discrete, index: u32, cancel: &AtomicBool) -> Found {
        let mut source = Source::new(self.steps.path(index));
        let (mut found, mut current, mut proposed) = (Found::default(), State::default(), State::default());
        let (start, _) = starts.pick((index as f32 + source.number()) / self.chains as f32);
        let mut first = Source::new(self.starts.path(start as u32));
        self.renew(&mut current, &mut first, &mut found.counters);
        let steps = self.mutations / self.chains + u32::from(index < self.mutations % self.chains);
        for _ in 0..steps {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let step = if source.number() < self.large_steps { Step::Large } else { Step::Small };
            match step {
                Step::Large => self.renew(&mut proposed, &mut source, &mut found.counters),
                Step::Small => self.move_little(&current, &mut proposed, &mut source, &mut found.counters),
            }
            let acceptance = (proposed.target / current.target).min(1.0);
            // Both count by their probability, whichever is taken [V97, 11.4].
            self.show(&current, (1.0 - acceptance) * weights.of_chained(current.target), &mut found.splats);
            let sampled = if step == Step::Large { weights.of_uniform(proposed.target) } else { 0.0 };
            let weight = acceptance * weights.of_chained(proposed.target) + sampled;
            self.show(&proposed, weight, &mut found.splats);
            let accepted = source.number() < acceptance;
            found.counters.steps.count(step, accepted);
            if accepted {
                std::mem::swap(&mut current, &mut proposed);
            }
        }
        found
    }

    /// A path of new numbers.
    fn renew(&self, state: &mut State, source: &mut Source, counters: &mut Counters) {
        self.begin(state, source);
        self.remake(state, counters);
    }

    /// New numbers: first those of a length, each less probable than the one before, then the rest.
    fn begin(&self, state: &mut State, source: &mut Source) {
        let goes_on = LONGER[((source.number() * LONGER.len() as f32) as usize).min(LONGER.len() - 1)];
        let mut segments = self.shortest;
        while self.longest.is_none_or(|longest| segments < longest) && source.number() < goes_on {
            segments += 1;
        }
        (state.segments, state.scale) = (segments, 1.0 / self.probability(segments));
        state.numbers.renew(segments, || source.number());
    }

    /// The probability of a length.
    fn probability(&self, segments: u32) -> f32 {
        let ends = self.longest.is_none_or(|longest| segments < longest);
        let of = |goes_on: f32| {
            let longer = (self.shortest..segments).fold(1.0, |product, _| product * goes_on);
            if ends { longer * (1.0 - goes_on) } else { longer }
        };
        LONGER.map(of).iter().sum::<f32>() / LONGER.len() as f32
    }

    /// All numbers that the ways before and after look at, moved by a little: as likely to lead back.
    fn move_little(&self, from: &State, to: &mut State, source: &mut Source, counters: &mut Counters) {
        let segments = from.segments;
        (to.segments, to.scale) = (segments, from.scale);
        to.numbers.clone_from(&from.numbers);
        to.numbers.way = moved(from.numbers.way, source.number());
        let (before, after) = (from.numbers.way(segments), to.numbers.way(segments));
        let light = blocks(before.light.max(after.light));
        let camera = blocks(before.camera.max(after.camera));
        for block in to.numbers.light.iter_mut().take(light).chain(to.numbers.camera.iter_mut().take(camera)) {
            block.iter_mut().for_each(|number| *number = moved(*number, source.number()));
        }
        self.remake(to, counters);
    }

    /// Makes the path of a state's numbers.
    fn remake(&self, state: &mut State, counters: &mut Counters) {
        state.splats.clear();
        self.sampler.trace(state.segments, &state.numbers, &mut state.splats, counters);
        state.target = 0.0;
        for splat in &mut state.splats {
            splat.radiance *= state.scale;
            state.target += luminance(splat.radiance.abs());
        }
    }

    fn show(&self, state: &State, weight: f32, splats: &mut Vec<Splat>) {
        if weight > 0.0 {
            let within = state.splats.iter().filter(|splat| self.pixels.contains(&splat.pixel));
            let counted =
                |splat: &Splat| Splat { pixel: splat.pixel - self.pixels.start, radiance: splat.radiance * weight };
            splats.extend(within.map(counted));
        }
    }
}
