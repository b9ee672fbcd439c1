//! `mmlt`: multiplexed Metropolis light transport. Markov chains over the random numbers of bidirectional paths of three segments and more go where
//! much light is; emission that is seen and direct light are sampled as by `path`. A pass starts its chains anew, from paths that it samples
//! first, so that it has no start-up bias and depends on nothing but its index.
//!
//! References: [V97] Veach 1997, 11.3.1 (start-up without bias); [KSAC02] Kelemen et al. 2002, "A simple and robust mutation strategy for the
//! Metropolis light transport algorithm"; [HKD14] Hachisuka, Kaplanyan & Dachsbacher 2014, "Multiplexed Metropolis light transport".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | f* | luminance of `PathSampler::trace`, over the probability of the path's length | W·sr⁻¹·m⁻² |
//! | b | `Bootstrap::mean`, of every pass its own | W·sr⁻¹·m⁻² |
//! | a | `Chain::step`, min(1, f*(y)/f*(x)) | – |
//!
//! A chain's samples count b·f/f*, over all mutations of the pass. As the starting paths are picked in proportion to f*, the mean of every pass is right
//! [V97, 11.3.1], and so is that of a job: the error of b shrinks with its passes.
//!
//! Limits: a chain that found something bright stays there for a while, so that errors of pixels are not independent. Media that scatter light
//! are not rendered.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::bidirectional_settings::{PassSettings, Paths};
use super::bounded_numbers::bounded;
use super::parameter_values::{All, Depth, LightPicks, Passes, RouletteDepth, one_per_pixel};
use super::parameters::{ParameterSet, parameter, parameters, read_method};
use super::photon_pass::add_to_tally;
use super::shared_parameters::{LIGHT_PICKS, MAX_DEPTH, PASSES};
use super::visibility_pilot::LightSampling;
use super::{Bias, Gathering, MethodEntry, ParameterizedMethod, Pass, PilotPass, PreparedMethod, SceneTraits};
use crate::estimate::{Region, ShardSums};
use crate::math::discrete::Discrete;
use crate::math::random::{PassRandom, Stream};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::bidirectional::{Heuristic, Measure, Show, Techniques, Weighting};
use crate::transport::metropolis::mutation::{Source, moved};
use crate::transport::metropolis::sample::{Numbers, PathSampler, Splat, blocks};
use crate::transport::photon_map::Gathered;

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: "mmlt",
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

/// Paths that start chains are sampled for each so many mutations.
const MUTATIONS_PER_START: u32 = 4;
/// Paths up to this length are not left to chains.
const SAMPLED: u32 = 2;
/// The probability that a chain's paths are longer by one more segment.
const LONGER: f32 = 2.0 / 3.0;

impl Parameters {
    /// How emission that is seen and direct light are found.
    fn direct(&self) -> PassSettings {
        let techniques = Techniques::HIT.with(Techniques::DIRECT, true);
        let rr_depth = RouletteDepth::new(SAMPLED + 1).expect("in range");
        let paths =
            Paths { max_depth: self.max_depth, rr_depth, length: All::All, strategy: All::All, show: Show::Radiance };
        let mut settings = PassSettings::new(techniques, &paths);
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
        (traits.point_lights && traits.specular).then_some(
            "light that mirrors and glass throw from point, spot and directional lights, where it is seen in mirrors or through \
             glass; sppm and vcm do",
        )
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

/// Paths of which chains start.
struct Bootstrap {
    /// By index, in proportion to f*.
    picks: Discrete,
    /// b, the mean of f*.
    mean: f32,
}

/// A chain's paths.
struct State {
    numbers: Numbers,
    splats: Vec<Splat>,
    /// f*, without the probability of the length, which is that of all of a chain's paths.
    brought: f32,
}

/// The length of a starting path, and its probability.
struct Length {
    segments: u32,
    probability: f32,
}

impl Mmlt {
    fn sampler(&self) -> PathSampler<'_> {
        PathSampler { scene: &self.scene, weighting: self.weighting }
    }

    /// A length from 3 segments on, each less probable than the one before.
    fn length(&self, mut u: f32) -> Length {
        let (mut segments, mut probability) = (SAMPLED + 1, 1.0);
        while self.longest.is_none_or(|longest| segments < longest) {
            if u >= LONGER {
                return Length { segments, probability: probability * (1.0 - LONGER) };
            }
            u /= LONGER;
            probability *= LONGER;
            segments += 1;
        }
        Length { segments, probability }
    }

    /// The numbers of starting path `index` and its length.
    fn start(&self, pass: u32, index: u32) -> (Length, Numbers) {
        let mut source = Source::new(PassRandom::independent(self.seed, Stream::Bootstrap, pass).path(index));
        let length = self.length(source.next());
        let numbers = Numbers::fresh(length.segments, || source.next());
        (length, numbers)
    }

    /// Samples the paths that chains may start from; `None` when cancelled, the inner one where no light was found.
    fn bootstrap(&self, pass: u32, counters: &mut Counters, cancel: &AtomicBool) -> Option<Option<Bootstrap>> {
        const CHUNK: u32 = 256;
        let count = (self.mutations / MUTATIONS_PER_START).max(self.parameters.chains.get());
        let chunks: Vec<(Vec<f64>, Counters)> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut counters = Counters::default();
                let mut splats = Vec::new();
                let sampler = self.sampler();
                let paths = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
                let brought = |index: u32| {
                    splats.clear();
                    if cancel.load(Ordering::Relaxed) {
                        return 0.0;
                    }
                    let (length, numbers) = self.start(pass, index);
                    let brought = sampler.trace(length.segments, &numbers, &mut splats, &mut counters);
                    f64::from(brought / length.probability)
                };
                let weights = paths.map(brought).collect();
                (weights, counters)
            })
            .collect();
        let mut weights = Vec::with_capacity(count as usize);
        for (of_chunk, found) in chunks {
            weights.extend(of_chunk);
            *counters += found;
        }
        let bootstrap = Discrete::new(&weights).map(|picks| {
            let mean = (picks.total() / f64::from(count)) as f32;
            Bootstrap { picks, mean }
        });
        (!cancel.load(Ordering::Relaxed)).then_some(bootstrap)
    }

    /// Runs chain `index` of a pass: what it brings to pixels of the region.
    fn chain(&self, pass: &Pass<'_>, index: u32, bootstrap: &Bootstrap, cancel: &AtomicBool) -> (Vec<Splat>, Counters) {
        let chains = self.parameters.chains.get();
        let mut source = Source::new(PassRandom::independent(self.seed, Stream::Chain, pass.index).path(index));
        let mut counters = Counters::default();
        let (start, _) = bootstrap.picks.pick((index as f32 + source.next()) / chains as f32);
        let (length, numbers) = self.start(pass.index, start as u32);
        let segments = length.segments;
        let sampler = self.sampler();
        let mut splats = Vec::new();
        let brought = sampler.trace(segments, &numbers, &mut splats, &mut counters);
        let mut current = State { numbers, splats, brought };
        let steps = self.mutations / chains + u32::from(index < self.mutations % chains);
        let weight = bootstrap.mean / self.mutations as f32;
        let (mut found, first, end) = (Vec::new(), self.first_pixel(pass.region), self.end_pixel(pass.region));
        let mut show = |state: &State, share: f32| {
            if share > 0.0 {
                let scale = weight * share / state.brought;
                let within = state.splats.iter().filter(|splat| (first..end).contains(&splat.pixel));
                found
                    .extend(within.map(|splat| Splat { pixel: splat.pixel - first, radiance: splat.radiance * scale }));
            }
        };
        let mut spare = Vec::new();
        for _ in 0..steps {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let numbers = self.mutated(&current.numbers, segments, &mut source);
            let mut splats = std::mem::take(&mut spare);
            splats.clear();
            let brought = sampler.trace(segments, &numbers, &mut splats, &mut counters);
            let proposed = State { numbers, splats, brought };
            let acceptance = (proposed.brought / current.brought).min(1.0);
            // Both count by their probability, whichever is taken [V97, 11.4].
            show(&current, 1.0 - acceptance);
            if proposed.brought > 0.0 {
                show(&proposed, acceptance);
            }
            if source.next() < acceptance {
                spare = std::mem::replace(&mut current, proposed).splats;
            } else {
                spare = proposed.splats;
            }
        }
        (found, counters)
    }

    /// Other numbers: all anew, or all that the ways before and after look at moved by a little. Either is as likely to lead back.
    fn mutated(&self, numbers: &Numbers, segments: u32, source: &mut Source) -> Numbers {
        if source.next() * 100.0 < self.parameters.large_steps.get() as f32 {
            return Numbers::fresh(segments, || source.next());
        }
        let mut next = numbers.clone();
        next.way = moved(numbers.way, source.next());
        let (before, after) = (numbers.way(segments), next.way(segments));
        let light = blocks(before.light.max(after.light));
        let camera = blocks(before.camera.max(after.camera));
        for block in next.light.iter_mut().take(light).chain(next.camera.iter_mut().take(camera)) {
            block.iter_mut().for_each(|number| *number = moved(*number, source.next()));
        }
        next
    }

    fn first_pixel(&self, region: Region) -> u32 {
        region.row_start * self.scene.width
    }

    fn end_pixel(&self, region: Region) -> u32 {
        region.row_end * self.scene.width
    }
}

impl PreparedMethod for Mmlt {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        let mut total = self.direct.trace_pass(pass, sums, cancel)?;
        if self.longest.is_some_and(|longest| longest <= SAMPLED) {
            return Some(total);
        }
        let Some(bootstrap) = self.bootstrap(pass.index, &mut total, cancel)? else { return Some(total) };
        let chains: Vec<(Vec<Splat>, Counters)> = (0..self.parameters.chains.get())
            .into_par_iter()
            .map(|index| self.chain(pass, index, &bootstrap, cancel))
            .collect();
        for (splats, counters) in chains {
            total += counters;
            for splat in splats {
                let pixel = &mut sums.tallies[splat.pixel as usize];
                add_to_tally(pixel, pass, splat.radiance, &Gathered::default(), &mut total);
            }
        }
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let region = Region { row_start: 0, row_end: self.scene.height };
        let pass =
            Pass { index: u32::MAX, region, radius_squared: &[], scale: 1.0, typical_radius_squared: 1.0, guide: None };
        let mut nobody_looks = ShardSums::zero(self.scene.pixel_count());
        Some(PilotPass::without_fields(self.trace_pass(&pass, &mut nobody_looks, cancel)?))
    }
}
