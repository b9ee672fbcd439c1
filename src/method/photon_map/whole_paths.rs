//! Photons of whole paths from a light to the camera. Where the camera sees a caustic only in mirrors, no whole path tells how often: there ordinary photons
//! take their place.

use std::sync::atomic::AtomicBool;

use super::TwoPasses;
use super::first_pass::{MapNumbers, Maps};
use crate::math::Vec3;
use crate::math::random::Stream;
use crate::method::Pass;
use crate::method::chain_pass::MakeSpace;
use crate::method::whole_paths::WholePaths;
use crate::scene::geometry::Ray;
use crate::transport::Counters;
use crate::transport::metropolis::chains::{Chains, Found, Lengths};
use crate::transport::metropolis::eye_subpaths::EyeSubpaths;
use crate::transport::metropolis::photon_paths::PhotonPaths;
use crate::transport::photon_map::{OriginPhoton, Photon, PhotonChunk, PhotonMap, PhotonRecord, trace_chunks};
use crate::transport::photon_tracing::trace_photon;
use crate::transport::visibility::SHADOW_END;

/// Of so many photons one more is an ordinary one, of those caustics that the camera sees only in mirrors.
const PER_ORDINARY: u32 = 4;
/// Paths to the eye that a pass traces for photons to look up.
const EYE_SUBPATHS: u32 = 1 << 14;
/// The fewest segments of a path that leaves a photon.
const SHORTEST: u32 = 3;

/// How photons of whole paths are made.
pub(super) struct PhotonPathSettings {
    /// What chains are proposed.
    pub(super) paths: WholePaths,
    /// Chains of a pass.
    pub(super) chains: u32,
    /// The share of large steps, %.
    pub(super) large_steps: u32,
    /// K, ways to the eye for each photon.
    pub(super) ways: u32,
}

impl TwoPasses {
    /// Traces chains of whole paths with `photons` states into a map of each kind.
    pub(super) fn trace_whole_paths(
        &self,
        pass: &Pass<'_>,
        settings: &PhotonPathSettings,
        numbers: &MapNumbers,
        photons: u32,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let random = |stream| numbers.of(self.seed, pass.index, stream);
        let lengths = Lengths { shortest: SHORTEST, longest: self.limits.max_depth };
        let grids = [self.grid(&self.global), self.grid(&self.caustic)];
        let (mut caustic, mut total) = self.ordinary_caustics(pass, numbers, photons, cancel)?;
        let mut global = Vec::new();
        if lengths.contain(SHORTEST) {
            let mut paths = settings.paths.space(&self.scene, lengths, 0..0);
            let (eye, counters) =
                EyeSubpaths::trace(&self.scene, &paths.window, EYE_SUBPATHS, &random(Stream::Importance), cancel)?;
            total += counters;
            paths.least_importance = eye.usual();
            let space = PhotonPaths { paths, eye: &eye, ways: settings.ways, photons: self.photons_per_pass as f32 };
            let chains = Chains {
                space: &space,
                large_steps: settings.large_steps as f32 / 100.0,
                mutations: photons,
                chains: settings.chains,
                starts: random(Stream::Bootstrap),
                trials: random(Stream::Trial),
                steps: random(Stream::Chain),
            };
            for Found { brought, mut counters } in chains.trace(cancel)? {
                let (caustics, others) =
                    brought.into_iter().partition(|found: &OriginPhoton| found.photon.is_caustic());
                global.push(PhotonChunk::store(others, &grids[0], &mut counters));
                caustic.push(PhotonChunk::store(caustics, &grids[1], &mut counters));
                total += counters;
            }
        }
        total.photons_emitted = u64::from(photons);
        let maps = Maps { global: PhotonMap::build(&global, grids[0]), caustic: PhotonMap::build(&caustic, grids[1]) };
        Some((maps, total))
    }

    /// Caustic photons at places that the camera does not see itself.
    fn ordinary_caustics(
        &self,
        pass: &Pass<'_>,
        numbers: &MapNumbers,
        photons: u32,
        cancel: &AtomicBool,
    ) -> Option<(Vec<PhotonChunk<OriginPhoton>>, Counters)> {
        let random = numbers.of(self.seed, pass.index, numbers.stream);
        let count = photons.div_ceil(PER_ORDINARY);
        let settings = self.photon_settings(&random, count, pass.guide);
        let grid = self.grid(&self.caustic);
        let flux = photons as f32 / count as f32;
        trace_chunks(count, cancel, |paths, counters| {
            let mut found: Vec<OriginPhoton> = Vec::new();
            for path in paths {
                trace_photon(&self.scene, &settings, path, &mut found, counters);
            }
            found.retain(|found| found.photon.is_caustic() && !self.is_seen(&found.photon, counters));
            let found = found.into_iter().map(|photon| photon.scaled(flux)).collect();
            PhotonChunk::store(found, &grid, counters)
        })
    }

    /// Whether the camera sees a photon without mirrors, from the middle of its lens.
    fn is_seen(&self, photon: &Photon, counters: &mut Counters) -> bool {
        let scene = &self.scene;
        let position = Vec3::from_array(photon.position);
        let Some(seen) = scene.camera.look_at(position, [0.5; 2]).filter(|seen| scene.film.reaches(seen.film)) else {
            return false;
        };
        counters.rays += 1;
        let origin = position + photon.normal() * scene.geometry.bounding_sphere().1 * OFF_SURFACE;
        let length = seen.visible_distance * SHADOW_END;
        seen.direction.dot(photon.normal()) > 0.0
            && !scene.is_hidden_from_camera(&Ray { origin, direction: seen.direction, length })
    }
}

/// Rays start off a photon's surface by this share of the scene's radius.
const OFF_SURFACE: f32 = 1e-5;
