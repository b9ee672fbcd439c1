//! The first pass of `photon_map`: photons are traced and sorted into maps.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::TwoPasses;
use super::look_up::LookUp;
use super::storage::{Storage, stored};
use crate::math::random::{MOST_PARTS, PassRandom, Stream};
use crate::method::Pass;
use crate::method::parameter_values::PhotonEmission;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::transport::Counters;
use crate::transport::importance_map::ImportanceMap;
use crate::transport::photon_map::{
    self as maps, FIRST_SEARCH_CELLS, Grid, OriginPhoton, Photon, PhotonChunk, PhotonMap,
};
use crate::transport::photon_tracing::{PhotonSettings, trace_photon};

/// One of each kind: the photons of a map that was traced at once, or the maps that pixels look at together.
pub(super) struct Maps<P> {
    /// For gather rays: all photons. Without them: those that a lobe with a density has scattered.
    pub(super) global: P,
    /// Photons that only mirrors and glass have scattered, at least once.
    pub(super) caustic: P,
}

/// The numbers of one of a pass's maps.
pub(super) struct MapNumbers {
    /// Of its photons.
    pub(super) stream: Stream,
    /// Its index among all maps of the pass.
    pub(super) map: u32,
}

impl MapNumbers {
    pub(super) fn of(&self, seed: u64, pass: u32, stream: Stream) -> PassRandom {
        PassRandom::independent(seed, stream, pass).part(self.map, MOST_PARTS)
    }
}

impl TwoPasses {
    /// First pass: traces and sorts the photons of set `set` of the pass's maps, with numbers of its own.
    pub(super) fn trace_photons(
        &self,
        stream: Stream,
        pass: &Pass<'_>,
        set: u32,
        cancel: &AtomicBool,
    ) -> Option<(Maps<Vec<PhotonMap<f32>>>, Counters)> {
        let count = self.parameters.maps.get();
        let mut maps = Maps { global: Vec::new(), caustic: Vec::new() };
        let mut total = Counters::default();
        let importance = match self.parameters.storage {
            Storage::All => None,
            Storage::Importance => self.importance_map(pass.index, &mut total),
        };
        let chained = match self.parameters.emission {
            PhotonEmission::Metropolis => Some(self.photon_importance(pass.index, &mut total)),
            PhotonEmission::Auto | PhotonEmission::Power | PhotonEmission::Guided => None,
        };
        for map in 0..count {
            let photons = self.photons_per_pass / count + u32::from(map < self.photons_per_pass % count);
            let numbers = MapNumbers { stream, map: set * count + map };
            let (found, counters) = match (&chained, &self.whole_paths) {
                (_, Some(whole_paths)) => self.trace_whole_paths(pass, whole_paths, &numbers, photons, cancel)?,
                (Some(chained), None) => self.trace_chains(pass, chained, &numbers, photons, cancel)?,
                (None, None) => {
                    let random = numbers.of(self.seed, pass.index, stream);
                    self.trace_map(&random, photons, pass.guide, importance.as_ref(), cancel)?
                }
            };
            total += counters;
            maps.global.push(found.global);
            maps.caustic.push(found.caustic);
        }
        Some((maps, total))
    }

    /// Traces `photons` photons into a map of each kind.
    fn trace_map(
        &self,
        random: &PassRandom,
        photons: u32,
        guide: Option<&EmissionGuide>,
        importance: Option<&ImportanceMap>,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let settings = self.photon_settings(random, photons, guide);
        match (self.splitting.factor(), importance) {
            (1, None) => self.trace_all(&settings, cancel),
            (_, importance) => self.trace_some(&settings, importance, cancel),
        }
    }

    /// Which photons are traced: all that pixels may look up.
    pub(super) fn photon_settings<'a>(
        &self,
        random: &'a PassRandom,
        paths: u32,
        guide: Option<&'a EmissionGuide>,
    ) -> PhotonSettings<'a> {
        PhotonSettings { limits: self.limits, first_stored_segment: 1, narrow_takes_all: false, random, paths, guide }
    }

    /// Both maps hold the same photons.
    fn trace_all(
        &self,
        settings: &PhotonSettings<'_>,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let (chunks, counters) = maps::trace::<OriginPhoton>(&self.scene, settings, &self.grid(&self.global), cancel)?;
        Some((self.sorted(&chunks), counters))
    }

    /// Maps of all photons.
    pub(super) fn sorted(&self, chunks: &[PhotonChunk<OriginPhoton>]) -> Maps<PhotonMap<f32>> {
        let all = PhotonMap::build(chunks, self.grid(&self.global));
        let caustic = all.select(self.grid(&self.caustic), Photon::is_caustic);
        let global = match self.gathers() {
            false => all.select(self.grid(&self.global), Photon::is_scattered),
            true => all,
        };
        Maps { global, caustic }
    }

    /// The caustic map holds more photons than the global map, or that does not hold all.
    fn trace_some(
        &self,
        settings: &PhotonSettings<'_>,
        importance: Option<&ImportanceMap>,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let grids = [self.grid(&self.global), self.grid(&self.caustic)];
        let (chunks, counters) = maps::trace_chunks(settings.paths, cancel, |paths, counters| {
            let Maps { global, caustic } = self.trace_paths(settings, importance, paths, counters);
            Maps {
                global: PhotonChunk::store(global, &grids[0], counters),
                caustic: PhotonChunk::store(caustic, &grids[1], counters),
            }
        })?;
        let (global, caustic): (Vec<_>, Vec<_>) =
            chunks.into_iter().map(|Maps { global, caustic }| (global, caustic)).unzip();
        let maps = Maps { global: PhotonMap::build(&global, grids[0]), caustic: PhotonMap::build(&caustic, grids[1]) };
        Some((maps, counters))
    }

    /// The photons of some paths for either map.
    fn trace_paths(
        &self,
        settings: &PhotonSettings<'_>,
        importance: Option<&ImportanceMap>,
        paths: Range<u32>,
        counters: &mut Counters,
    ) -> Maps<Vec<OriginPhoton>> {
        let (mut global, mut caustic) = (Vec::with_capacity(4 * paths.len()), Vec::new());
        let mut own = Vec::new();
        for path in paths {
            own.clear();
            trace_photon::<OriginPhoton>(&self.scene, settings, path, &mut own, counters);
            self.splitting.split(&self.scene, settings, path, &own, &mut caustic, counters);
            let wanted = own.iter().filter(|found| self.gathers() || found.photon.is_scattered());
            match importance {
                None => global.extend(wanted),
                Some(importance) => {
                    let random = settings.random.path(path);
                    global.extend(wanted.filter_map(|photon| stored(importance, photon, &random)));
                }
            }
        }
        Maps { global, caustic }
    }

    /// Whether rays gather indirect light.
    fn gathers(&self) -> bool {
        self.parameters.final_gather.get() > 0
    }

    /// Cells for a map that is looked at so.
    pub(super) fn grid(&self, look_up: &LookUp) -> Grid {
        let (low, high) = self.scene.geometry.bounds();
        let cell = look_up.first_radius / FIRST_SEARCH_CELLS;
        Grid::new(low, high, cell, 4 * u64::from(self.photons_per_pass / self.parameters.maps.get()).max(1 << 14))
    }
}
