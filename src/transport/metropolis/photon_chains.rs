//! Photons of a pass as states of Markov chains over the numbers of their paths, which stay where the picture looks [Hachisuka & Jensen 2011,
//! "Robust adaptive photon tracing using photon path visibility"].
//!
//! The target I of a path is the largest importance of its photons, between a small share and 1. A pass samples some of its paths
//! uniformly: they are photons like any others (`vcm` also connects them), and chains start at some of them, picked in proportion to I, so that no chain has a start-up bias
//! [Veach 1997, 11.3.1]. By the balance heuristic a photon of either kind counts 1/(n_u + n_c·I/b₀), with n_u uniform paths, n_c states of chains, and
//! b₀ about the mean of I; states of chains count b/b₀ times as much, b being the mean of I over the pass's uniform paths. Whatever b₀ is that does
//! not depend on them, means are right, since b and the starting paths belong together.
//!
//! Large steps are the paper's replica exchange: with a uniform target a replica's state is an independent path, which is taken with the probability
//! min(1, I'/I), and uniform paths count as photons, too. How large small steps are is tuned in every pass by chains of their own, and then left as it is.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::mutation::{LARGEST_STEP, Source, moved};
use crate::math::discrete::Discrete;
use crate::math::random::{Numbers, PassRandom, PathRandom, dimension};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::counters::Step;
use crate::transport::importance_map::LEAST_ACCEPTANCE;
use crate::transport::photon_map::{Grid, Photon, PhotonChunk, PhotonRecord, TracedPhoton, trace_chunks};
use crate::transport::photon_tracing::{PhotonSettings, trace_photon_with};

/// One path in so many is sampled uniformly where nothing else asks for more.
const UNIFORM: u32 = 4;
/// Beside the paths of a pass one in so many tells b₀, and as many how large steps should be.
const TRIALS: u32 = 64;
/// So many steps at least has a chain that tunes them, unless there are not as many, …
const TUNING_STEPS: u32 = 64;
/// … and there are so many such chains at most.
const MOST_TUNING_CHAINS: u32 = 16;
/// The share of small steps that should be taken. The paper's 0.234 is that of many dimensions and smooth targets; here it made twice the error in a room
/// whose door leaves a slit (`docs/measured/DEAD-ENDS.md`).
const ACCEPTANCE: f32 = 0.8;
/// How quickly tuning goes.
const GAIN: f32 = 2.0;
/// The largest step is between so many halvings of 1.
const HALVINGS: [f32; 2] = [1.0, 12.0];
/// States of a chain.
const STATES: u32 = 256;
/// The share of mutations that change all of a path's numbers.
const LARGE: f32 = 0.1;
/// Blocks of numbers that small steps move: those of emission, and of scattering at the first four surfaces. What comes behind them changes with them
/// anyway, and every number that is moved costs time.
const MOVED: [usize; 6] = [
    dimension::EMISSION as usize,
    dimension::EMISSION_DIRECTION as usize,
    dimension::scattering(1) as usize,
    dimension::scattering(2) as usize,
    dimension::scattering(3) as usize,
    dimension::scattering(4) as usize,
];
/// Blocks that are kept.
const BLOCKS: usize = MOVED[5] + 1;

/// How photons are made of a path's numbers.
pub(crate) trait PhotonTracer: Sync {
    /// What a path leaves.
    type Photon: PhotonRecord;

    /// Traces path `path` and appends its photons.
    fn trace(&self, path: u32, numbers: &impl Numbers, photons: &mut Vec<Self::Photon>, counters: &mut Counters);
}

/// Photons that are stored as settings say.
pub(crate) struct StoringTracer<'a, R> {
    scene: &'a Scene,
    settings: PhotonSettings<'a>,
    photon: PhantomData<fn() -> R>,
}

impl<R: TracedPhoton> PhotonTracer for StoringTracer<'_, R> {
    type Photon = R;

    #[inline]
    fn trace(&self, path: u32, numbers: &impl Numbers, photons: &mut Vec<R>, counters: &mut Counters) {
        trace_photon_with(self.scene, &self.settings, path, numbers, photons, counters);
    }
}

/// Makes the photons of a pass by `T`; `I` says how important a photon is to the picture, above 0 and at most 1.
pub(crate) struct PhotonChains<'a, T, I> {
    /// How a path becomes photons.
    pub tracer: T,
    /// How important they are.
    pub importance: I,
    /// n_u.
    pub uniform: u32,
    /// n_c.
    pub chained: u32,
    /// The numbers of uniform paths.
    pub random: &'a PassRandom,
    /// The numbers of mutations.
    pub mutations: PassRandom,
    /// The numbers of paths that tell b₀.
    pub trials: PassRandom,
}

impl<'a, R: TracedPhoton, I> PhotonChains<'a, StoringTracer<'a, R>, I> {
    /// Makes photons as settings say, some of their paths uniform and the others states of chains.
    pub(crate) fn storing(
        scene: &'a Scene,
        settings: PhotonSettings<'a>,
        importance: I,
        mutations: PassRandom,
        trials: PassRandom,
    ) -> Self {
        let uniform = settings.paths.div_ceil(UNIFORM);
        let (chained, random) = (settings.paths - uniform, settings.random);
        let tracer = StoringTracer { scene, settings, photon: PhantomData };
        Self { tracer, importance, uniform, chained, random, mutations, trials }
    }
}

/// The numbers of a path: some that small steps move, and those of an address behind them.
#[derive(Clone, Copy, Debug)]
struct PathNumbers {
    blocks: [[f32; 4]; BLOCKS],
    rest: PathRandom,
}

impl PathNumbers {
    fn new(rest: PathRandom) -> Self {
        Self { blocks: std::array::from_fn(|block| rest.block(block as u32)), rest }
    }

    fn moved(mut self, source: &mut Source, largest: f32) -> Self {
        for block in MOVED {
            self.blocks[block].iter_mut().for_each(|number| *number = moved(*number, source.number(), largest));
        }
        self
    }
}

impl Numbers for PathNumbers {
    #[inline]
    fn block(&self, block: u32) -> [f32; 4] {
        self.blocks.get(block as usize).copied().unwrap_or_else(|| self.rest.block(block))
    }

    fn branch(&self, index: u32) -> PathRandom {
        self.rest.branch(index)
    }
}

/// How photons of a pass count.
#[derive(Clone, Copy, Debug)]
struct Weights {
    /// n_u.
    uniform: f32,
    /// n_c.
    chained: f32,
    /// b₀.
    expected: f32,
    /// b/b₀.
    ratio: f32,
}

impl Weights {
    /// What the flux of a uniform path with this target counts, where all n_u + n_c paths of the pass are averaged.
    fn of_uniform(&self, target: f32) -> f32 {
        (self.uniform + self.chained) / (self.uniform + self.chained * target / self.expected)
    }

    fn of_chained(&self, target: f32) -> f32 {
        self.ratio * self.of_uniform(target)
    }
}

/// What trials told.
pub(crate) struct Tried {
    /// As far as it is known.
    weights: Weights,
    /// The largest step of small changes.
    largest_step: f32,
    /// What they took.
    pub rays: u64,
}

/// The paths that were sampled uniformly.
struct UniformPaths<R> {
    chunks: Vec<PhotonChunk<R>>,
    targets: Vec<f64>,
    counters: Counters,
}

impl Tried {
    /// As many uniform paths leave photons as densely where the picture looks.
    pub(crate) fn visible_paths(&self) -> f32 {
        self.weights.uniform + self.weights.chained / self.weights.expected
    }
}

impl<T: PhotonTracer, I: Fn(&Photon) -> f32 + Sync> PhotonChains<'_, T, I> {
    /// The photons of the pass, in the order of their paths; `None` when cancelled.
    pub(crate) fn trace(&self, grid: &Grid, cancel: &AtomicBool) -> Option<(Vec<PhotonChunk<T::Photon>>, Counters)> {
        let tried = self.tried(cancel)?;
        let UniformPaths { mut chunks, targets, mut counters } = self.uniform(&tried, grid, cancel)?;
        let (chained, found) = self.from(&tried, &targets, grid, cancel)?;
        chunks.extend(chained);
        counters += found;
        counters.rays += tried.rays;
        counters.photons_emitted = self.paths();
        Some((chunks, counters))
    }

    /// n_u + n_c, over which photons are averaged.
    pub(crate) fn paths(&self) -> u64 {
        u64::from(self.uniform) + u64::from(self.chained)
    }

    /// Traces paths that are nothing else; `None` when cancelled.
    pub(crate) fn tried(&self, cancel: &AtomicBool) -> Option<Tried> {
        let count = (self.uniform + self.chained).div_ceil(TRIALS);
        let (targets, mut counters) = trace_chunks(count, cancel, |paths, counters| {
            let mut photons = Vec::new();
            let mut target = |path: u32| {
                photons.clear();
                f64::from(self.photons(path, &self.trials.path(path), &mut photons, counters))
            };
            paths.map(&mut target).collect::<Vec<f64>>()
        })?;
        let targets = targets.concat();
        let expected = (targets.iter().sum::<f64>() / f64::from(count)) as f32;
        let mut largest_step = LARGEST_STEP;
        if let Some(starts) = Discrete::new(&targets) {
            let chains = (count / TUNING_STEPS).clamp(1, MOST_TUNING_CHAINS);
            let tune = |chain: u32| self.tuned(&starts, (chain as f32 + 0.5) / chains as f32, chain, count / chains);
            let tuned: Vec<(f32, Counters)> = (0..chains).into_par_iter().map(tune).collect();
            let mut sum = 0.0;
            for (halvings, counted) in tuned {
                sum += halvings;
                counters += counted;
            }
            largest_step = libm::exp2f(-sum / chains as f32);
        }
        let weights = Weights { uniform: self.uniform as f32, chained: self.chained as f32, expected, ratio: 1.0 };
        Some(Tried { weights, largest_step, rays: counters.rays })
    }

    /// Makes the photons of a uniform path count as they should; its target.
    pub(crate) fn weigh(&self, tried: &Tried, photons: &mut [T::Photon]) -> f64 {
        let target = self.target(photons);
        let weight = tried.weights.of_uniform(target);
        photons.iter_mut().for_each(|photon| *photon = photon.scaled(weight));
        f64::from(target)
    }

    /// The photons of chains that start at uniform paths with these targets; `None` when cancelled.
    pub(crate) fn from(
        &self,
        tried: &Tried,
        targets: &[f64],
        grid: &Grid,
        cancel: &AtomicBool,
    ) -> Option<(Vec<PhotonChunk<T::Photon>>, Counters)> {
        // Every target is above 0.
        let Some(starts) = Discrete::new(targets) else { return Some(Default::default()) };
        let mut weights = tried.weights;
        weights.ratio = (starts.total() / targets.len() as f64) as f32 / weights.expected;
        trace_chunks(self.chained, cancel, |states, counters| {
            let mut photons = Vec::new();
            for first in states.clone().step_by(STATES as usize) {
                let states = first..states.end.min(first + STATES);
                self.chain(&weights, &starts, tried.largest_step, states, &mut photons, counters);
            }
            PhotonChunk::store(photons, grid, counters)
        })
    }

    /// Runs a chain whose steps grow and shrink until [`ACCEPTANCE`] of them are taken [Hachisuka & Jensen 2011]; how often its largest step is
    /// half of 1.
    fn tuned(&self, starts: &Discrete, start: f32, chain: u32, steps: u32) -> (f32, Counters) {
        let mut counters = Counters::default();
        let mut source = Source::new(self.trials.path(LARGE_STEPS | chain));
        let start = starts.pick(start).0 as u32;
        let mut numbers = PathNumbers::new(self.trials.path(start));
        let mut photons = Vec::new();
        let mut target = self.photons(start, &numbers, &mut photons, &mut counters);
        let mut halvings = -libm::log2f(LARGEST_STEP);
        for step in 1..=steps {
            let next = numbers.moved(&mut source, libm::exp2f(-halvings));
            photons.clear();
            let next_target = self.photons(start, &next, &mut photons, &mut counters);
            let acceptance = (next_target / target).min(1.0);
            halvings -= (acceptance - ACCEPTANCE) * GAIN / (step as f32).sqrt();
            halvings = halvings.clamp(HALVINGS[0], HALVINGS[1]);
            if source.number() < acceptance {
                (numbers, target) = (next, next_target);
            }
        }
        (halvings, counters)
    }

    fn uniform(&self, tried: &Tried, grid: &Grid, cancel: &AtomicBool) -> Option<UniformPaths<T::Photon>> {
        let (found, counters) = trace_chunks(self.uniform, cancel, |paths, counters| {
            let (mut photons, mut targets) = (Vec::new(), Vec::with_capacity(paths.len()));
            for path in paths {
                let first = photons.len();
                self.tracer.trace(path, &self.random.path(path), &mut photons, counters);
                targets.push(self.weigh(tried, &mut photons[first..]));
            }
            (PhotonChunk::store(photons, grid, counters), targets)
        })?;
        let (chunks, targets): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        Some(UniformPaths { chunks, targets: targets.concat(), counters })
    }

    /// Runs a chain through `states` and appends their photons; those of a state that stays are stored once.
    fn chain(
        &self,
        weights: &Weights,
        starts: &Discrete,
        largest_step: f32,
        states: Range<u32>,
        stored: &mut Vec<T::Photon>,
        counters: &mut Counters,
    ) {
        let mut source = Source::new(self.mutations.path(states.start));
        let start = starts.pick(source.number()).0 as u32;
        let mut numbers = PathNumbers::new(self.random.path(start));
        let (mut photons, mut proposed) = (Vec::new(), Vec::new());
        let mut target = self.photons(start, &numbers, &mut photons, counters);
        let mut times = 0;
        for state in states {
            let (step, next) = match source.number() < LARGE {
                true => (Step::Large, PathNumbers::new(self.mutations.path(LARGE_STEPS | state))),
                false => (Step::Small, numbers.moved(&mut source, largest_step)),
            };
            proposed.clear();
            let next_target = self.photons(start, &next, &mut proposed, counters);
            let accepted = source.number() * target < next_target;
            counters.steps.count(step, accepted);
            if accepted {
                store(&photons, times, weights.of_chained(target), stored);
                (numbers, target, times) = (next, next_target, 0);
                std::mem::swap(&mut photons, &mut proposed);
            }
            times += 1;
        }
        store(&photons, times, weights.of_chained(target), stored);
    }

    /// Traces a path and appends its photons; its target.
    fn photons(&self, path: u32, numbers: &impl Numbers, photons: &mut Vec<T::Photon>, counters: &mut Counters) -> f32 {
        let first = photons.len();
        self.tracer.trace(path, numbers, photons, counters);
        self.target(&photons[first..])
    }

    /// I of a path with these photons.
    fn target(&self, photons: &[T::Photon]) -> f32 {
        photons.iter().map(|photon| (self.importance)(photon.photon())).fold(LEAST_ACCEPTANCE, f32::max)
    }
}

/// Keeps the numbers of large steps apart from those of mutations.
const LARGE_STEPS: u32 = 1 << 31;

fn store<R: PhotonRecord>(photons: &[R], times: u32, weight: f32, stored: &mut Vec<R>) {
    if times > 0 {
        stored.extend(photons.iter().map(|photon| photon.scaled(weight * times as f32)));
    }
}
