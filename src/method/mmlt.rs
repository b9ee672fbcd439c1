//! `mmlt`: multiplexed Metropolis light transport. Markov chains over the random numbers of bidirectional paths of three segments and more go where
//! much light is; emission that is seen and direct light are sampled as by `bdpt`. A pass starts its chains anew, from paths that it samples
//! first, so that it has no start-up bias and depends on nothing but its index.
//!
//! References: \[V97\] Veach 1997, 11.3.1 (start-up without bias); \[KSAC02\] Kelemen et al. 2002, "A simple and robust mutation strategy for the
//! Metropolis light transport algorithm"; \[HKD14\] Hachisuka, Kaplanyan & Dachsbacher 2014, "Multiplexed Metropolis light transport".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | f* | luminance of `PathSampler::trace`, over the probability of the path's length | W·sr⁻¹·m⁻² |
//! | b, b₀ | means of f* over the uniform samples of a pass, see [`chains`](crate::transport::metropolis::chains) | W·sr⁻¹·m⁻² |
//! | a | min(1, f*(y)/f*(x)) | – |
//!
//! Each pass is right on average and has a b of its own, whose error shrinks with the passes of the job.
//!
//! Limits: a chain that found something bright stays there for a while, so that errors of pixels are not independent. Media that scatter light
//! are not rendered.

use std::ops::Range;
use std::sync::Arc;

use super::bidirectional_settings::blind_without_merging;
use super::chain_pass::{
    CHAINS, ChainCount, ChainMethod, ChainSettings, LARGE_STEPS, MUTATIONS, MakeSpace, Mutations, Percent, direct,
};
use super::parameter_values::{Depth, LightPicks, Passes, one_per_pixel};
use super::parameters::{ParameterSet, parameters, read_method};
use super::shared_parameters::{LIGHT_PICKS, MAX_DEPTH, PASSES};
use super::visibility_pilot::LightSampling;
use super::{Bias, Gathering, MethodEntry, ParameterizedMethod, PreparedMethod, SceneTraits};
use crate::scene::Scene;
use crate::transport::bidirectional::{Heuristic, Measure, Techniques, Weighting};
use crate::transport::counters::Step;
use crate::transport::metropolis::chains::Lengths;
use crate::transport::metropolis::primary_space::PrimarySpace;
use crate::transport::metropolis::sample::PathSampler;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "mmlt",
    also_called: &["pssmlt", "multiplexed"],
    summary: "Metropolis light transport: chains of bidirectional paths that stay where much light is",
    cannot_sample: "light of point, spot and directional lights through glass onto what glass or mirrors show",
    reference: "Hachisuka, Kaplanyan & Dachsbacher 2014",
    bias: Bias::None,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `mmlt`.
    struct Parameters {
        chains: ChainCount = CHAINS,
        mutations: Mutations = MUTATIONS,
        large_steps: Percent = LARGE_STEPS,
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
        &[Step::Small, Step::Large]
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(direct(self.max_depth).light_sampling(self.light_picks))
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        let weighting = Weighting {
            techniques: Techniques::ALL_CONNECTIONS,
            heuristic: Heuristic::Balance,
            measure: Measure::Area,
            light_paths: scene.pixel_count() as f32,
        };
        let settings = ChainSettings {
            chains: self.chains.get(),
            mutations: self.mutations.get(),
            large_steps: self.large_steps.get(),
            max_depth: self.max_depth,
        };
        Box::new(ChainMethod::new(scene, settings, photons_per_pass, seed, Multiplexed { weighting }))
    }
}

/// Random numbers of bidirectional paths.
struct Multiplexed {
    weighting: Weighting,
}

impl MakeSpace for Multiplexed {
    type Space<'a> = PrimarySpace<'a>;

    fn space<'a>(&'a self, scene: &'a Scene, lengths: Lengths, pixels: Range<u32>) -> PrimarySpace<'a> {
        PrimarySpace { sampler: PathSampler { scene, weighting: self.weighting }, lengths, pixels }
    }
}
