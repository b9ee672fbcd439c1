//! `mmlt`: multiplexed Metropolis light transport. Markov chains over the random numbers of bidirectional paths of three segments and more go where
//! much light is; emission that is seen and direct light are sampled as by `bdpt`. A pass starts its chains anew, from paths that it samples
//! first, so that it has no start-up bias and depends on nothing but its index.
//!
//! References: [V97] Veach 1997, 11.3.1 (start-up without bias); [KSAC02] Kelemen et al. 2002, "A simple and robust mutation strategy for the
//! Metropolis light transport algorithm"; [HKD14] Hachisuka, Kaplanyan & Dachsbacher 2014, "Multiplexed Metropolis light transport".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | f* | luminance of `PathSampler::trace`, over the probability of the path's length | W·sr⁻¹·m⁻² |
//! | b, b₀ | means of f* over the uniform samples of a pass, see `path_chains` | W·sr⁻¹·m⁻² |
//! | a | min(1, f*(y)/f*(x)) | – |
//!
//! Each pass is right on average and has a b of its own, whose error shrinks with the passes of the job.
//!
//! Limits: a chain that found something bright stays there for a while, so that errors of pixels are not independent. Media that scatter light
//! are not rendered.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::bidirectional_settings::{PassSettings, Paths, blind_without_merging};
use super::bounded_numbers::bounded;
use super::parameter_values::{All, Depth, LightPicks, Passes, RouletteDepth, one_per_pixel};
use super::parameters::{ParameterSet, parameter, parameters, read_method};
use super::photon_pass::add_to_tally;
use super::shared_parameters::{LIGHT_PICKS, MAX_DEPTH, PASSES};
use super::visibility_pilot::LightSampling;
use super::{Bias, Gathering, MethodEntry, ParameterizedMethod, Pass, PilotPass, PreparedMethod, SceneTraits};
use crate::estimate::ShardSums;
use crate::math::random::{PassRandom, Stream};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::bidirectional::{Heuristic, Measure, Show, Techniques, Weighting};
use crate::transport::counters::Step;
use crate::transport::metropolis::path_chains::{Found, PathChains};
use crate::transport::metropolis::sample::PathSampler;
use crate::transport::photon_map::Gathered;

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: "mmlt",
    also_called: &["mlt", "pssmlt", "metropolis"],
    summary: "Metropolis light transport: chains of bidirectional paths that stay where much light is",
    cannot_sample: "light of point, spot and directional lights through glass onto what glass or mirrors show",
    reference: "Hachisuka, Kaplanyan & Dachsbacher 2014",
    bias: Bias::None,
    parameters: Parameters::HELP,
    negative_lobes: true,
    media: false,
    read: read_method::<Parameters>,
};

bounded! {
    /// Chains of a pass.
    struct Chains(u32), [1 to 65536]
}

bounded! {
    /// Mutations of a pass for each pixel.
    struct Mutations(u32), [1 to 1024]
}

bounded! {
    /// The share of mutations that change all numbers, %.
    struct LargeSteps(u32), [1 to 100]
}

parameters! {
    /// Parameters of `mmlt`.
    struct Parameters {
        chains: Chains = parameter("chains of a pass", Chains(64), "64"),
        mutations: Mutations = parameter("mutations of a pass for each pixel", Mutations(1), "1"),
        large_steps: LargeSteps =
            parameter("the share of mutations that change all of a path's numbers, %", LargeSteps(30), "30"),
        light_picks: LightPicks = LIGHT_PICKS,
        max_depth: Depth = MAX_DEPTH,
        passes: Passes = PASSES,
    }
}

/// Paths up to this length are not left to chains.
const SAMPLED: u32 = 2;

impl Parameters {
    /// How emission that is seen and direct light are found.
    fn direct(&self) -> PassSettings {
        let rr_depth = RouletteDepth::new(SAMPLED + 1).expect("in range");
        let paths =
            Paths { max_depth: self.max_depth, rr_depth, length: All::All, strategy: All::All, show: Show::Radiance };
        let mut settings = PassSettings::new(Techniques::ALL_CONNECTIONS, &paths);
        settings.limits.max_depth = Some(settings.limits.max_depth.unwrap_or(SAMPLED).min(SAMPLED));
        settings
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

    fn proposals(&self) -> &'static [&'static str] {
        &Step::NAMES
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(self.direct().light_sampling(self.light_picks))
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        let weighting = Weighting {
            techniques: Techniques::ALL_CONNECTIONS,
            heuristic: Heuristic::Balance,
            measure: Measure::Area,
            light_paths: scene.pixel_count() as f32,
        };
        let longest = u32::try_from(self.max_depth.get()).ok();
        let direct = self.direct().prepare(scene.clone(), photons_per_pass, seed);
        let mutations = one_per_pixel(scene.pixel_count() as u64).saturating_mul(self.mutations.get());
        Box::new(Mmlt { scene, seed, weighting, longest, mutations, parameters: self.clone(), direct })
    }
}

struct Mmlt {
    scene: Arc<Scene>,
    seed: u64,
    weighting: Weighting,
    /// The longest paths, in segments.
    longest: Option<u32>,
    /// Of a pass.
    mutations: u32,
    parameters: Parameters,
    direct: Box<dyn PreparedMethod>,
}

impl Mmlt {
    fn chains(&self, pass: &Pass<'_>) -> PathChains<'_> {
        let numbers = |stream| PassRandom::independent(self.seed, stream, pass.index);
        let width = self.scene.width;
        PathChains {
            sampler: PathSampler { scene: &self.scene, weighting: self.weighting },
            shortest: SAMPLED + 1,
            longest: self.longest,
            large_steps: self.parameters.large_steps.get() as f32 / 100.0,
            mutations: self.mutations,
            chains: self.parameters.chains.get(),
            pixels: pass.region.row_start * width..pass.region.row_end * width,
            starts: numbers(Stream::Bootstrap),
            trials: numbers(Stream::Trial),
            steps: numbers(Stream::Chain),
        }
    }
}

impl PreparedMethod for Mmlt {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        let mut total = self.direct.trace_pass(pass, sums, cancel)?;
        if self.longest.is_some_and(|longest| longest <= SAMPLED) {
            return Some(total);
        }
        for Found { splats, counters } in self.chains(pass).trace(cancel)? {
            total += counters;
            for splat in splats {
                let pixel = &mut sums.tallies[splat.pixel as usize];
                add_to_tally(pixel, pass, splat.radiance, &Gathered::default(), &mut total);
            }
        }
        Some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        PilotPass::of_a_pass(self, &self.scene, cancel)
    }
}
