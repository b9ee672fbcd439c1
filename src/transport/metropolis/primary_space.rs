//! Multiplexed paths as points of a cube of random numbers: small changes move all numbers by a little [Kelemen et al. 2002].

use std::ops::Range;

use super::chains::{Change, Lengths, Space, acceptance};
use super::mutation::{LARGEST_STEP, Source, moved};
use super::sample::{PathSampler, PrimarySample, Splat, blocks};
use crate::math::color::luminance;
use crate::transport::Counters;
use crate::transport::counters::Step;

/// Multiplexed paths.
pub(crate) struct PrimarySpace<'a> {
    /// Makes paths.
    pub sampler: PathSampler<'a>,
    /// How long they are.
    pub lengths: Lengths,
    /// Pixels of which anything is wanted.
    pub pixels: Range<u32>,
}

/// A path, and what it brings over the probability of its length.
#[derive(Default)]
pub(crate) struct PrimaryState {
    segments: u32,
    /// One over the probability of its length.
    scale: f32,
    numbers: PrimarySample,
    splats: Vec<Splat>,
    /// f*: their luminance.
    target: f32,
}

impl Space for PrimarySpace<'_> {
    type State = PrimaryState;
    type Brought = Splat;

    fn renew(&self, state: &mut PrimaryState, source: &mut Source, counters: &mut Counters) {
        state.segments = self.lengths.pick(source);
        state.scale = 1.0 / self.lengths.probability(state.segments);
        state.numbers.renew(state.segments, || source.number());
        self.remake(state, counters);
    }

    /// All numbers that the ways before and after look at, moved by a little: as likely to lead back.
    fn change(
        &self,
        from: &PrimaryState,
        to: &mut PrimaryState,
        source: &mut Source,
        counters: &mut Counters,
    ) -> Change {
        let segments = from.segments;
        (to.segments, to.scale) = (segments, from.scale);
        to.numbers.clone_from(&from.numbers);
        to.numbers.way = moved(from.numbers.way, source.number(), LARGEST_STEP);
        let (before, after) = (from.numbers.way(segments), to.numbers.way(segments));
        let light = blocks(before.light.max(after.light));
        let camera = blocks(before.camera.max(after.camera));
        for block in to.numbers.light.iter_mut().take(light).chain(to.numbers.camera.iter_mut().take(camera)) {
            block.iter_mut().for_each(|number| *number = moved(*number, source.number(), LARGEST_STEP));
        }
        self.remake(to, counters);
        Change { step: Step::Small, acceptance: acceptance(to.target, from.target) }
    }

    fn target(&self, state: &PrimaryState) -> f32 {
        state.target
    }

    fn show(&self, state: &PrimaryState, weight: f32, splats: &mut Vec<Splat>) {
        show(&state.splats, weight, &self.pixels, splats);
    }
}

/// Appends `weight` times those of `brought` that lie within `pixels`, which are counted from their first one.
pub(super) fn show(brought: &[Splat], weight: f32, pixels: &Range<u32>, splats: &mut Vec<Splat>) {
    if weight > 0.0 {
        let within = brought.iter().filter(|splat| pixels.contains(&splat.pixel));
        let counted = |splat: &Splat| Splat { pixel: splat.pixel - pixels.start, radiance: splat.radiance * weight };
        splats.extend(within.map(counted));
    }
}

impl PrimarySpace<'_> {
    /// Makes the path of a state's numbers.
    fn remake(&self, state: &mut PrimaryState, counters: &mut Counters) {
        state.splats.clear();
        self.sampler.trace(state.segments, &state.numbers, &mut state.splats, counters);
        state.target = 0.0;
        for splat in &mut state.splats {
            splat.radiance *= state.scale;
            state.target += luminance(splat.radiance.abs());
        }
    }
}
