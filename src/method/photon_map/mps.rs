//! `mps`: Metropolis photon sampling. Photon maps as those of `photon_map`, but photons are left by Markov chains of whole paths from a light to the camera,
//! where a final gather looks for them; and people may say where light comes from.
//!
//! References: \[F05\] Fan, Chenney & Lai 2005, "Metropolis photon sampling with optional user guidance"; \[V97\] Veach 1997, chapter 11.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | f_eye | `path_space::path::Terms::carried` times `size` | W·sr⁻¹·m⁻² over the unit of the path's density |
//! | f_map | the part of its factors up to the photon | W over the same |
//! | b | mean of f_eye* over the independent samples of a pass, see [`chains`](crate::transport::metropolis::chains) | W·sr⁻¹·m⁻² |
//! | a, T | [F05, eqs. 4 to 7], see [`path_space`](crate::transport::metropolis::path_space) | –, the path's density |
//! | Φ | flux of a photon, see [`photon_paths`](crate::transport::metropolis::photon_paths) | W |
//!
//! Limits: those of `photon_map`. Photons lie at the second surface from the eye that is no mirror, where the first sees it; gather rays that go on at narrow
//! glossy lobes, mirrors or glass find only those photons that other rays find, too.

use std::sync::Arc;

use super::TwoPasses;
use super::parameters::{
    CACHE_ERROR, CACHE_RAYS, CAMERA_PATHS, CAUSTIC_NEIGHBORS, CacheError, CacheRays, CameraPaths, GatherRays,
    LARGEST_RADIUS, NEIGHBORS, Neighbors, Parameters as SecondPass,
};
use super::whole_paths::PhotonPathSettings;
use crate::method::bounded_numbers::bounded;
use crate::method::chain_pass::{CHAINS, ChainCount, LARGE_STEPS, Percent};
use crate::method::parameter_values::{
    Auto, Depth, LightPicks, Passes, PhotonCount, PhotonEmission, Radius, RouletteDepth, Switchable, limits,
};
use crate::method::parameters::{ParameterSet, parameter, parameters, read_method};
use crate::method::shared_parameters::{LIGHT_PICKS, MAX_DEPTH, PASSES, PHOTONS, RR_DEPTH};
use crate::method::visibility_pilot::LightSampling;
use crate::method::whole_paths::{
    BIDIRECTIONAL, CAUSTIC, LENS, LENS_SUBPATH, PHOTON_MAP, Parts, Proposals, USER_PATH, USER_PATHS, UserPaths,
    WholePaths,
};
use crate::method::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod};
use crate::scene::Scene;
use crate::transport::counters::Step;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "mps",
    also_called: &["metropolis_photon_sampling"],
    summary: "Metropolis photon sampling: photon maps of chains of whole paths, which users can guide",
    cannot_sample: "light that gather rays find only behind mirrors, glass or narrow glossy lobes, where no surface that the camera sees sees it; and more \
                    passes do not remove the bias of its estimate",
    reference: "Fan, Chenney & Lai 2005",
    bias: Bias::Stays,
    parameters: Parameters::HELP,
    negative_lobes: false,
    media: false,
    read: read_method::<Parameters>,
};

bounded! {
    /// Gather rays of a camera path.
    struct Rays(u32), [1 to 1024]
}

bounded! {
    /// K, ways from a photon to the eye.
    struct Ways(u32), [1 to 256]
}

parameters! {
    /// Parameters of `mps`.
    struct Parameters {
        photons_per_pass: Auto<PhotonCount> = PHOTONS,
        chains: ChainCount = CHAINS,
        large_steps: Percent = LARGE_STEPS,
        bidirectional: Parts = BIDIRECTIONAL,
        lens_subpath: Parts = LENS_SUBPATH,
        lens: Parts = LENS,
        caustic: Parts = CAUSTIC,
        photon_map: Parts = PHOTON_MAP,
        user_path: Parts = USER_PATH,
        user_paths: UserPaths = USER_PATHS,
        ways: Ways = parameter(
            "ways from a photon to the eye, its own among them, that tell how often it is looked up",
            Ways(8),
            "8",
        ),
        neighbors: Neighbors = NEIGHBORS,
        caustic_neighbors: Neighbors = CAUSTIC_NEIGHBORS,
        largest_radius: Auto<Radius> = LARGEST_RADIUS,
        final_gather: Rays = parameter("gather rays per camera path", Rays(4), "4"),
        cache_error: Switchable<CacheError> = CACHE_ERROR,
        cache_rays: Auto<CacheRays> = CACHE_RAYS,
        camera_paths: CameraPaths = CAMERA_PATHS,
        light_picks: LightPicks = LIGHT_PICKS,
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = RR_DEPTH,
        passes: Passes = PASSES,
    }
}

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        self.photons_per_pass.settle(pixels)
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        Gathering::Nothing
    }

    fn proposals(&self) -> &'static [Step] {
        Proposals::steps(&self.user_paths)
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(LightSampling::gathering(self.light_picks, limits(self.max_depth, self.rr_depth)))
    }

    fn contradiction(&self) -> Option<Contradiction> {
        self.chosen().contradiction(&self.user_paths).or_else(|| self.second_pass().contradiction())
    }

    fn names_places(&self) -> bool {
        !self.user_paths.is_empty()
    }

    fn refuses(&self, scene: &Scene) -> Option<Contradiction> {
        self.user_paths.checked(scene).err()
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        // What the scene refuses is not prepared.
        let user_paths = self.user_paths.checked(&scene).unwrap_or_default();
        let settings = PhotonPathSettings {
            paths: WholePaths { shares: self.chosen().shares(&user_paths), user_paths },
            chains: self.chains.get(),
            large_steps: self.large_steps.get(),
            ways: self.ways.get(),
        };
        Box::new(TwoPasses::new(self.second_pass(), scene, photons_per_pass, seed, Some(settings)))
    }
}

impl Parameters {
    fn chosen(&self) -> Proposals {
        Proposals {
            bidirectional: self.bidirectional,
            lens_subpath: self.lens_subpath,
            lens: self.lens,
            caustic: self.caustic,
            photon_map: self.photon_map,
            user_path: self.user_path,
        }
    }

    /// How photons are looked up.
    fn second_pass(&self) -> SecondPass {
        SecondPass {
            photons_per_pass: self.photons_per_pass,
            emission: PhotonEmission::Power,
            neighbors: self.neighbors,
            caustic_neighbors: self.caustic_neighbors,
            largest_radius: self.largest_radius,
            final_gather: GatherRays::new(self.final_gather.get()).expect("in range"),
            cache_error: self.cache_error,
            cache_rays: self.cache_rays,
            camera_paths: self.camera_paths,
            light_picks: self.light_picks,
            max_depth: self.max_depth,
            rr_depth: self.rr_depth,
            passes: self.passes,
            ..SecondPass::default()
        }
    }
}
