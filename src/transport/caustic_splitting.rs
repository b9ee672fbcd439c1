//! Splitting of caustic photons: S times as many of them as of all others, each with 1/S of its flux [Wald 1999, section 4.6].
//!
//! Photons that only mirrors and glass scattered make caustics, which no final gather can smooth; so they should lie denser than the rest.
//! All ways keep the paths of the pass for the other photons, bit for bit, and only add to their caustic photons.
//!
//! - *Brute force* (4.6.1). The thesis traces S times as many paths and keeps others than caustic photons with probability 1/S. Which paths
//!   are kept can be decided before they are traced: 1 in S, those that the pass has anyway. The other S − 1 of each then end at the
//!   first surface that is not specular, mostly after one ray. Expectations are the same, and the others are not thinned at random.
//! - *Projection* [Jensen & Christensen 1995]. Of these added paths, those that meet no specular surface first are not traced.
//!   The caustic photons are those of brute force, bit for bit. It helps caustics whose chain starts at the light, as all in the caustic
//!   map do.
//! - *Metropolis* (4.6.2). Where a path begins with a chain that leaves caustic photons, S − 1 mutations of it are tried. A mutation
//!   changes the random numbers that the photon started with, place and direction alike, by exponentially distributed steps to either
//!   side, round the borders of [0, 1); the numbers of its scattering stay. It becomes the chain if its characteristic is the same; else
//!   the chain counts once more. The path that the pass found is uniform over all numbers with its characteristic, and symmetric steps
//!   that stay among these keep it so: each of the S is as good as the first, and the flux that each brings makes an unbiased estimate.
//!   But they are near each other: where few chains were found, caustics are made of bright spots.

use serde::{Deserialize, Serialize};

use super::counters::Counters;
use super::light_path::emission_point;
use super::photon_map::{PhotonRecord, PhotonWith, TracedPhoton};
use super::photon_tracing::PhotonSettings;
use super::projection::SpecularBoxes;
use super::specular_chain::ChainTracer;
use crate::math::discrete::ONE_MINUS_EPSILON;
use crate::math::random::{PathRandom, dimension};
use crate::scene::Scene;

/// How more caustic photons are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Splitting {
    /// By more paths.
    #[default]
    Brute,
    /// By mutations of those found.
    Metropolis,
    /// By more paths of photons that may meet a specular surface first.
    Projection,
}

/// The mean step of a mutation in each of the four numbers of an emission.
const MEAN_STEP: f32 = 1.0 / 64.0;

/// How the caustic photons of a scene are split.
pub(crate) struct CausticSplitting {
    /// S, at least 1.
    factor: u32,
    way: Way,
}

enum Way {
    Brute,
    Metropolis,
    Projection(SpecularBoxes),
}

impl CausticSplitting {
    /// Splits into `factor`, at least 1.
    pub(crate) fn new(factor: u32, splitting: Splitting, scene: &Scene) -> Self {
        let way = match splitting {
            Splitting::Brute => Way::Brute,
            Splitting::Metropolis => Way::Metropolis,
            Splitting::Projection => Way::Projection(SpecularBoxes::new(scene)),
        };
        Self { factor, way }
    }

    /// S.
    pub(crate) fn factor(&self) -> u32 {
        self.factor
    }

    /// Appends the caustic photons that stand for path `path`, which stored the photons `own`.
    pub(crate) fn split<E>(
        &self,
        scene: &Scene,
        settings: &PhotonSettings<'_>,
        path: u32,
        own: &[PhotonWith<E>],
        caustic: &mut Vec<PhotonWith<E>>,
        counters: &mut Counters,
    ) where
        PhotonWith<E>: TracedPhoton,
    {
        let own = own.iter().filter(|found| found.photon.is_caustic());
        let boxes = match &self.way {
            Way::Metropolis => {
                if own.count() > 0 {
                    let tracer = ChainTracer { scene, settings, boxes: None };
                    self.mutate(&tracer, path, caustic, counters);
                }
                return;
            }
            Way::Brute => None,
            Way::Projection(boxes) => Some(boxes),
        };
        let tracer = ChainTracer { scene, settings, boxes };
        let first = caustic.len();
        caustic.extend(own);
        let added = settings.paths + path * (self.factor - 1);
        for path in added..added + self.factor - 1 {
            let random = settings.random.path(path);
            let start = emission_point(scene, settings.guide, &random);
            tracer.trace(&start, path, &random, caustic, counters);
        }
        let share = 1.0 / self.factor as f32;
        caustic[first..].iter_mut().for_each(|photon| *photon = photon.scaled(share));
    }

    /// The chain of a path, and S − 1 mutations.
    fn mutate<E>(&self, tracer: &ChainTracer<'_>, path: u32, caustic: &mut Vec<PhotonWith<E>>, counters: &mut Counters)
    where
        PhotonWith<E>: TracedPhoton,
    {
        let ChainTracer { scene, settings, .. } = *tracer;
        let random = settings.random.path(path);
        let mut numbers = EmissionNumbers::of(&random);
        let (mut chain, mut proposed) = (Vec::new(), Vec::new());
        let mut trace = |numbers: &EmissionNumbers, photons: &mut Vec<PhotonWith<E>>| {
            let start = scene.lights.emission_point(settings.guide, numbers.place(), numbers.direction());
            tracer.trace(&start, path, &random, photons, counters)
        };
        let characteristic = trace(&numbers, &mut chain);
        let share = 1.0 / self.factor as f32;
        let mut count = 1;
        for mutation in 1..self.factor {
            let mutated = numbers.mutated(random.block(dimension::mutation(mutation)));
            proposed.clear();
            if trace(&mutated, &mut proposed) == characteristic {
                caustic.extend(chain.iter().map(|photon| photon.scaled(count as f32 * share)));
                std::mem::swap(&mut chain, &mut proposed);
                (numbers, count) = (mutated, 1);
            } else {
                count += 1;
            }
        }
        caustic.extend(chain.iter().map(|photon| photon.scaled(count as f32 * share)));
    }
}

/// The random numbers that a photon starts with.
#[derive(Clone, Copy)]
struct EmissionNumbers {
    /// Place (2) and direction (2).
    numbers: [f32; 4],
    /// Picks the light, or the cell of a guide.
    pick: f32,
}

impl EmissionNumbers {
    fn of(random: &PathRandom) -> Self {
        let [x, y, pick, _] = random.block(dimension::EMISSION);
        let [u, v, ..] = random.block(dimension::EMISSION_DIRECTION);
        Self { numbers: [x, y, u, v], pick }
    }

    fn place(&self) -> [f32; 3] {
        [self.numbers[0], self.numbers[1], self.pick]
    }

    fn direction(&self) -> [f32; 2] {
        [self.numbers[2], self.numbers[3]]
    }

    /// Moved by steps that four numbers in [0, 1) tell: in half of the cases up, with density exp(−step/mean)/mean.
    fn mutated(&self, by: [f32; 4]) -> Self {
        let moved = |axis: usize| {
            let rest = (2.0 * by[axis]).fract();
            let step = -MEAN_STEP * libm::logf(1.0 - rest);
            let side = if by[axis] < 0.5 { step } else { -step };
            (self.numbers[axis] + side).rem_euclid(1.0).min(ONE_MINUS_EPSILON)
        };
        Self { numbers: [0, 1, 2, 3].map(moved), ..*self }
    }
}
