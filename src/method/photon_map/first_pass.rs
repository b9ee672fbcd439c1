//! The first pass of `photon_map`: photons are traced and sorted into maps.

use std::sync::atomic::AtomicBool;

use super::TwoPasses;
use super::look_up::LookUp;
use crate::math::random::{MOST_PARTS, PassRandom, Stream};
use crate::method::Pass;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::transport::Counters;
use crate::transport::photon_map::{self, FIRST_SEARCH_CELLS, Grid, OriginPhoton, Photon, PhotonMap};
use crate::transport::photon_tracing::PhotonSettings;

/// The photons that pixels look at together: one map or several that were traced independently of each other.
pub(super) struct Maps<P> {
    /// For gather rays: all photons. Without them: those that a lobe with a density has scattered.
    pub(super) global: Vec<P>,
    /// Photons that only mirrors and glass have scattered, at least once.
    pub(super) caustic: Vec<P>,
}

impl TwoPasses {
    /// First pass: traces and sorts the photons of set `set` of the pass's maps, with numbers of its own.
    pub(super) fn trace_photons(
        &self,
        stream: Stream,
        pass: &Pass<'_>,
        set: u32,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let random = PassRandom::independent(self.seed, stream, pass.index);
        let count = self.parameters.maps.get();
        let mut maps = Maps { global: Vec::new(), caustic: Vec::new() };
        let mut total = Counters::default();
        for map in 0..count {
            let photons = self.photons_per_pass / count + u32::from(map < self.photons_per_pass % count);
            let random = random.part(set * count + map, MOST_PARTS);
            total += self.trace_map(&random, photons, pass.guide, &mut maps, cancel)?;
        }
        Some((maps, total))
    }

    /// Traces `photons` photons into a map of each kind, which are added to `maps`.
    fn trace_map(
        &self,
        random: &PassRandom,
        photons: u32,
        guide: Option<&EmissionGuide>,
        maps: &mut Maps<PhotonMap<f32>>,
        cancel: &AtomicBool,
    ) -> Option<Counters> {
        let settings = PhotonSettings {
            limits: self.limits,
            first_stored_segment: 1,
            narrow_takes_all: false,
            random,
            paths: photons,
            guide,
        };
        let (chunks, counters) =
            photon_map::trace::<OriginPhoton>(&self.scene, &settings, &self.grid(&self.global), cancel)?;
        let all = PhotonMap::build(&chunks, self.grid(&self.global));
        maps.caustic.push(all.select(self.grid(&self.caustic), Photon::is_caustic));
        maps.global.push(match self.parameters.final_gather.get() {
            0 => all.select(self.grid(&self.global), Photon::is_scattered),
            _ => all,
        });
        Some(counters)
    }

    fn grid(&self, look_up: &LookUp) -> Grid {
        let (low, high) = self.scene.geometry.bounds();
        let cell = look_up.first_radius / FIRST_SEARCH_CELLS;
        Grid::new(low, high, cell, 4 * u64::from(self.photons_per_pass / self.parameters.maps.get()).max(1 << 14))
    }
}
