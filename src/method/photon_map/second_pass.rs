//! The second pass of `photon_map`: which pixels look at which maps.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::TwoPasses;
use super::first_pass::Maps;
use super::local_pass::LocalPass;
use super::parameters::Structure;
use crate::estimate::PixelTally;
use crate::math::random::{PassRandom, Stream};
use crate::method::Pass;
use crate::method::photon_pass::add_to_tally;
use crate::transport::Counters;
use crate::transport::photon_map::{Gathered, KdTree, Nearest, OriginLookup};

impl TwoPasses {
    /// Both passes, with random numbers of `streams` for photons and camera.
    pub(super) fn trace(
        &self,
        streams: [Stream; 2],
        pass: &Pass<'_>,
        pixels: &mut [PixelTally],
        cancel: &AtomicBool,
    ) -> Option<Counters> {
        let (maps, mut total) = self.trace_photons(streams[0], pass, cancel)?;
        total += match self.parameters.structure {
            Structure::Grid => self.look_at_pixels(&maps, streams[1], pass, pixels, cancel),
            Structure::KdTree => {
                let maps = Maps { global: KdTree::from(maps.global), caustic: KdTree::from(maps.caustic) };
                self.look_at_pixels(&maps, streams[1], pass, pixels, cancel)
            }
        };
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    /// Second pass, with random numbers of `stream`.
    fn look_at_pixels<P: OriginLookup>(
        &self,
        maps: &Maps<P>,
        stream: Stream,
        pass: &Pass<'_>,
        pixels: &mut [PixelTally],
        cancel: &AtomicBool,
    ) -> Counters {
        let width = self.scene.width as usize;
        let random = PassRandom::of_pixels(self.seed, stream, pass.index);
        let trace_row = |(row, tallies): (usize, &mut [PixelTally])| {
            let mut gathering = LocalPass { method: self, maps, found: Nearest::default() };
            let mut counters = Counters::default();
            if cancel.load(Ordering::Relaxed) {
                return counters;
            }
            let y = pass.region.row_start + row as u32;
            for (x, tally) in (0..).zip(tallies) {
                let random = random.path(y * self.scene.width + x);
                let radiance = gathering.pixel([x, y], &random, &mut counters);
                add_to_tally(tally, pass, radiance, &Gathered::default(), &mut counters);
            }
            counters
        };
        let counters: Vec<Counters> = pixels.par_chunks_mut(width).enumerate().map(trace_row).collect();
        let mut total = Counters::default();
        counters.into_iter().for_each(|counters| total += counters);
        total
    }
}
