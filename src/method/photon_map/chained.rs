//! Photons of chains of whole paths, which stay where the picture looks photons up: caustics where the camera sees a surface, all others where gather
//! rays end. [Fan et al. 2005] store photons at the same places.

use std::sync::atomic::AtomicBool;

use super::TwoPasses;
use super::first_pass::{MapNumbers, Maps};
use crate::math::random::Stream;
use crate::method::Pass;
use crate::transport::Counters;
use crate::transport::importance_map::{ImportanceMap, LEAST_ACCEPTANCE};
use crate::transport::metropolis::photon_chains::{PhotonChains, StoringTracer};
use crate::transport::photon_map::{OriginPhoton, Photon, PhotonMap};

/// How important photons are to a pass.
pub(super) struct PhotonImportance {
    /// Where gather rays end.
    global: Option<ImportanceMap>,
    /// Where the camera looks, for caustic photons.
    caustic: Option<ImportanceMap>,
}

impl PhotonImportance {
    fn of(&self, photon: &Photon) -> f32 {
        let caustic = self.caustic.as_ref().filter(|_| photon.is_caustic());
        let maps = [self.global.as_ref(), caustic];
        maps.into_iter().flatten().map(|map| map.of(photon)).fold(LEAST_ACCEPTANCE, f32::max)
    }
}

impl TwoPasses {
    /// What chains of a pass are to know.
    pub(super) fn photon_importance(&self, pass: u32, counters: &mut Counters) -> PhotonImportance {
        let global = self.importance_map(pass, counters);
        PhotonImportance { global, caustic: self.caustic_importance(pass, counters) }
    }

    /// Traces `photons` photons by chains into a map of each kind.
    pub(super) fn trace_chains(
        &self,
        pass: &Pass<'_>,
        importance: &PhotonImportance,
        numbers: &MapNumbers,
        photons: u32,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let random = numbers.of(self.seed, pass.index, numbers.stream);
        let settings = self.photon_settings(&random, photons, pass.guide);
        let importance = |photon: &Photon| importance.of(photon);
        let [mutations, trials] =
            [Stream::Chain, Stream::Trial].map(|stream| numbers.of(self.seed, pass.index, stream));
        let chains: PhotonChains<'_, StoringTracer<'_, OriginPhoton>, _> =
            PhotonChains::storing(&self.scene, settings, importance, mutations, trials);
        let (chunks, counters) = chains.trace(&self.grid(&self.global), cancel)?;
        Some((self.sorted(&chunks), counters))
    }
}
