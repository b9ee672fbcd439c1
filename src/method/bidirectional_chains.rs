//! Photons of chains for methods that also connect light subpaths.
//!
//! A chain makes runs of alike subpaths: connected with the camera subpaths of a run of pixels they would give all of them the same noise. So
//! uniform light subpaths stay as they are, and are connected, seen and merged; chains that start at them add as many photons again, which are
//! only merged. The weights of techniques count all of them as merged light subpaths. These weights add up to 1 whatever number they are told, so means do not
//! depend on how densely chains visit a place; the flux of photons knows that.

use super::Pass;
use super::bidirectional_pass::BidirectionalPasses;
use crate::math::random::{Numbers, PassRandom, Stream};
use crate::transport::Counters;
use crate::transport::bidirectional::{LightWalk, MergePhoton};
use crate::transport::importance_map::ImportanceMap;
use crate::transport::metropolis::photon_chains::{PhotonChains, PhotonTracer};
use crate::transport::photon_map::Photon;

/// Light subpaths as photons to merge with.
pub(super) struct SubpathTracer<'a>(LightWalk<'a>);

impl PhotonTracer for SubpathTracer<'_> {
    type Photon = MergePhoton;

    #[inline]
    fn trace(&self, _: u32, numbers: &impl Numbers, photons: &mut Vec<MergePhoton>, counters: &mut Counters) {
        self.0.trace_with(numbers, counters, |vertex, _, _| photons.extend(MergePhoton::new(vertex)));
    }
}

impl BidirectionalPasses {
    /// The chains of a pass whose uniform light subpaths have the numbers of `random`.
    pub(super) fn chains<'a>(
        &'a self,
        pass: &Pass<'_>,
        random: &'a PassRandom,
        importance: &'a ImportanceMap,
    ) -> PhotonChains<'a, SubpathTracer<'a>, impl Fn(&Photon) -> f32 + Sync> {
        let numbers = |stream| PassRandom::independent(self.seed, stream, pass.index);
        PhotonChains {
            tracer: SubpathTracer(self.light_walk(random)),
            importance: |photon: &Photon| importance.of(photon),
            uniform: self.light_paths,
            chained: self.light_paths,
            random,
            mutations: numbers(Stream::Chain),
            trials: numbers(Stream::Trial),
        }
    }
}
