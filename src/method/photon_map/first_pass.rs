//! The first pass of `photon_map`: photons are traced and sorted into maps.

use std::sync::atomic::AtomicBool;

use super::TwoPasses;
use super::look_up::LookUp;
use crate::math::random::{PassRandom, Stream};
use crate::method::Pass;
use crate::transport::Counters;
use crate::transport::photon_map::{self as maps, FIRST_SEARCH_CELLS, Grid, OriginPhoton, Photon, PhotonMap};
use crate::transport::photon_tracing::PhotonSettings;

/// The photons of a pass.
pub(super) struct Maps<P> {
    /// For gather rays: all photons. Without them: those that a lobe with a density has scattered.
    pub(super) global: P,
    /// Photons that only mirrors and glass have scattered, at least once.
    pub(super) caustic: P,
}

impl TwoPasses {
    /// First pass: traces and sorts photons.
    pub(super) fn trace_photons(
        &self,
        stream: Stream,
        pass: &Pass<'_>,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let random = PassRandom::independent(self.seed, stream, pass.index);
        let settings = PhotonSettings {
            limits: self.limits,
            first_stored_segment: 1,
            narrow_takes_all: false,
            random: &random,
            paths: self.photons_per_pass,
            guide: pass.guide,
        };
        let (chunks, counters) = maps::trace::<OriginPhoton>(&self.scene, &settings, &self.grid(&self.global), cancel)?;
        let all = PhotonMap::build(&chunks, self.grid(&self.global));
        let caustic = all.select(self.grid(&self.caustic), Photon::is_caustic);
        let global = match self.parameters.final_gather.get() {
            0 => all.select(self.grid(&self.global), Photon::is_scattered),
            _ => all,
        };
        Some((Maps { global, caustic }, counters))
    }

    fn grid(&self, look_up: &LookUp) -> Grid {
        let (low, high) = self.scene.geometry.bounds();
        let cell = look_up.first_radius / FIRST_SEARCH_CELLS;
        Grid::new(low, high, cell, 4 * u64::from(self.photons_per_pass).max(1 << 14))
    }
}
