//! Which photons of the global map are stored: all, or by the importance of where they are [Wald 1999, section 4.7].

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::TwoPasses;
use crate::math::Vec3;
use crate::math::color::luminance;
use crate::math::random::{PassRandom, PathRandom, Stream, dimension};
use crate::method::gather_ends::GatherEnds;
use crate::method::pilot::PilotView;
use crate::transport::Counters;
use crate::transport::camera_walk::GatherPoint;
use crate::transport::importance_map::{ImportanceMap, Importon};
use crate::transport::photon_map::{OriginPhoton, PhotonRecord};

/// Which photons of the global map are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Storage {
    /// All of them.
    All,
    /// With a probability by importance, and with their flux over it.
    Importance,
}

/// One camera path in so many pixels along each side looks for importons.
const PIXELS_APART: u32 = 4;

impl TwoPasses {
    /// The importance of the global map's photons in a pass, by camera paths of its own over the whole picture, whatever the pass's region; `None`
    /// where the picture looks at no photons.
    pub(super) fn importance_map(&self, pass: u32, counters: &mut Counters) -> Option<ImportanceMap> {
        self.importance_where(pass, |at| !at.goes_on, counters)
    }

    /// The same of caustic photons.
    pub(super) fn caustic_importance(&self, pass: u32, counters: &mut Counters) -> Option<ImportanceMap> {
        self.importance_where(pass, |at| at.goes_on, counters)
    }

    fn importance_where(
        &self,
        pass: u32,
        counts: impl Fn(&GatherPoint) -> bool + Sync,
        counters: &mut Counters,
    ) -> Option<ImportanceMap> {
        let [width, height] = [self.scene.width, self.scene.height];
        let ends = GatherEnds {
            scene: &self.scene,
            limits: self.limits,
            gathers: self.parameters.final_gather.get() > 0,
            random: PassRandom::independent(self.seed, Stream::Importance, pass),
        };
        // Each pass looks through another pixel of each block.
        let shift = [pass % PIXELS_APART, pass / PIXELS_APART % PIXELS_APART];
        let of_row = |block: u32| {
            let mut counters = Counters::default();
            let mut importons = Vec::new();
            let y = (block * PIXELS_APART + shift[1]).min(height - 1);
            for x in (0..width).step_by(PIXELS_APART as usize) {
                let pixel = y * width + (x + shift[0]).min(width - 1);
                ends.visit(pixel as usize, &mut counters, &mut |at, _, _| {
                    if counts(at) {
                        let importance = luminance(at.throughput);
                        importons.push(Importon { position: at.hit.position, importance });
                    }
                });
            }
            (importons, counters)
        };
        let rows: Vec<(Vec<Importon>, Counters)> =
            (0..height.div_ceil(PIXELS_APART)).into_par_iter().map(of_row).collect();
        rows.iter().for_each(|(_, counted)| *counters += *counted);
        let importons: Vec<Importon> = rows.into_iter().flat_map(|(importons, _)| importons).collect();
        ImportanceMap::new(self.scene.geometry.bounds(), &importons)
    }
}

/// The photon as it is stored, if it is; `random` has the numbers of its path.
pub(super) fn stored(importance: &ImportanceMap, photon: &OriginPhoton, random: &PathRandom) -> Option<OriginPhoton> {
    let acceptance = importance.acceptance(Vec3::from_array(photon.photon.position));
    let [u, ..] = random.block(dimension::storing(photon.photon.segments()));
    (u < acceptance).then(|| photon.scaled(1.0 / acceptance))
}
