//! `mlt`: Metropolis light transport. Markov chains of whole paths go where much light is; a mutation changes some of a path's vertices. Emission that is
//! seen and direct light are sampled as by `bdpt`. A pass starts its chains anew, from paths that it samples first, so that it has no start-up bias and
//! depends on nothing but its index.
//!
//! Reference: \[V97\] Veach 1997, chapter 11.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | f | `path_space::path::Terms::carried` times `size` | W·sr⁻¹·m⁻² over the unit of the path's density |
//! | T | densities in `path_space::proposals` | the path's density |
//! | b, b₀ | means of f* over the independent samples of a pass, see [`chains`](crate::transport::metropolis::chains) | W·sr⁻¹·m⁻² |
//! | a | min(1, f*(y) T(y → x) / f*(x) T(x → y)) [V97, eq. 11.4] | – |
//!
//! Limits: those of `mmlt`.

use std::sync::Arc;

use super::bidirectional_settings::blind_without_merging;
use super::chain_pass::{
    CHAINS, ChainCount, ChainMethod, ChainSettings, LARGE_STEPS, MUTATIONS, Mutations, Percent, direct,
};
use super::parameter_values::{Depth, LightPicks, Passes, one_per_pixel};
use super::parameters::{ParameterSet, parameters, read_method};
use super::shared_parameters::{LIGHT_PICKS, MAX_DEPTH, PASSES};
use super::visibility_pilot::LightSampling;
use super::whole_paths::{
    BIDIRECTIONAL, CAUSTIC, LENS, LENS_SUBPATH, PHOTON_MAP, Parts, Proposals, USER_PATH, USER_PATHS, UserPaths,
    WholePaths,
};
use super::{Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, SceneTraits};
use crate::scene::Scene;
use crate::transport::counters::Step;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "mlt",
    also_called: &["metropolis"],
    summary: "Metropolis light transport: chains of whole paths whose vertices change a few at a time",
    cannot_sample: "light of point, spot and directional lights through glass onto what glass or mirrors show",
    reference: "Veach & Guibas 1997",
    bias: Bias::None,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `mlt`.
    struct Parameters {
        chains: ChainCount = CHAINS,
        mutations: Mutations = MUTATIONS,
        large_steps: Percent = LARGE_STEPS,
        bidirectional: Parts = BIDIRECTIONAL,
        lens_subpath: Parts = LENS_SUBPATH,
        lens: Parts = LENS,
        caustic: Parts = CAUSTIC,
        photon_map: Parts = PHOTON_MAP,
        user_path: Parts = USER_PATH,
        user_paths: UserPaths = USER_PATHS,
        light_picks: LightPicks = LIGHT_PICKS,
        max_depth: Depth = MAX_DEPTH,
        passes: Passes = PASSES,
    }
}

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        one_per_pixel(pixels)
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        Gathering::Nothing
    }

    fn blind_to(&self, traits: SceneTraits) -> Option<&'static str> {
        blind_without_merging(traits)
    }

    fn proposals(&self) -> &'static [Step] {
        Proposals::steps(&self.user_paths)
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(direct(self.max_depth).light_sampling(self.light_picks))
    }

    fn contradiction(&self) -> Option<Contradiction> {
        self.chosen().contradiction(&self.user_paths)
    }

    fn names_places(&self) -> bool {
        !self.user_paths.is_empty()
    }

    fn refuses(&self, scene: &Scene) -> Option<Contradiction> {
        self.user_paths.checked(scene).err()
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        let settings = ChainSettings {
            chains: self.chains.get(),
            mutations: self.mutations.get(),
            large_steps: self.large_steps.get(),
            max_depth: self.max_depth,
        };
        // What the scene refuses is not prepared.
        let user_paths = self.user_paths.checked(&scene).unwrap_or_default();
        let space = WholePaths { shares: self.chosen().shares(&user_paths), user_paths };
        Box::new(ChainMethod::new(scene, settings, photons_per_pass, seed, space))
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
}
