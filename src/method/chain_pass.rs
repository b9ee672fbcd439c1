//! What methods of Metropolis light transport share: emission that is seen and direct light are sampled as by `bdpt`, all longer paths are those of chains.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::bidirectional_settings::{PassSettings, Paths};
use super::bounded_numbers::bounded;
use super::parameter_values::{All, Depth, RouletteDepth, one_per_pixel};
use super::parameters::{Parameter, parameter};
use super::photon_pass::add_to_tally;
use super::{Pass, PilotPass, PreparedMethod};
use crate::estimate::ShardSums;
use crate::math::random::{PassRandom, Stream};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::bidirectional::{Show, Techniques};
use crate::transport::metropolis::chains::{Chains, Found, Lengths, Space};
use crate::transport::metropolis::sample::Splat;
use crate::transport::photon_map::Gathered;

/// Paths up to this length are not left to chains.
const SAMPLED: u32 = 2;

/// How emission that is seen and direct light are found.
pub(crate) fn direct(max_depth: Depth) -> PassSettings {
    let rr_depth = RouletteDepth::new(SAMPLED + 1).expect("in range");
    let paths = Paths { max_depth, rr_depth, length: All::All, strategy: All::All, show: Show::Radiance };
    let mut settings = PassSettings::new(Techniques::ALL_CONNECTIONS, &paths);
    settings.limits.max_depth = Some(settings.limits.max_depth.unwrap_or(SAMPLED).min(SAMPLED));
    settings
}

bounded! {
    /// Chains of a pass.
    pub(super) struct ChainCount(u32), [1 to 65536]
}

bounded! {
    /// Mutations of a pass for each pixel.
    pub(super) struct Mutations(u32), [1 to 1024]
}

bounded! {
    /// A share of mutations, %.
    pub(super) struct Percent(u32), [1 to 100]
}

/// How many chains a pass has.
pub(super) const CHAINS: Parameter<ChainCount> = parameter("chains of a pass", ChainCount(64), "64");
/// How long they are together.
pub(super) const MUTATIONS: Parameter<Mutations> = parameter("mutations of a pass for each pixel", Mutations(1), "1");
/// How often chains start anew.
pub(super) const LARGE_STEPS: Parameter<Percent> =
    parameter("the share of mutations that change all of a path, %", Percent(30), "30");

/// The chains of a method.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChainSettings {
    /// Chains of a pass.
    pub chains: u32,
    /// Mutations of a pass for each pixel.
    pub mutations: u32,
    /// The share of mutations that do not depend on where a chain is, %.
    pub large_steps: u32,
    /// The longest paths.
    pub max_depth: Depth,
}

/// A method of chains, prepared for a scene; `space` makes what its chains move through for the pixels of a pass.
pub(crate) struct ChainMethod<M> {
    scene: Arc<Scene>,
    seed: u64,
    settings: ChainSettings,
    direct: Box<dyn PreparedMethod>,
    space: M,
}

/// Makes the space that chains move through.
pub(crate) trait MakeSpace: Send + Sync {
    /// The space.
    type Space<'a>: Space<Brought = Splat>
    where
        Self: 'a;

    /// That of paths in `scene` of which those of `pixels` are wanted.
    fn space<'a>(&'a self, scene: &'a Scene, lengths: Lengths, pixels: Range<u32>) -> Self::Space<'a>;
}

impl<M: MakeSpace> ChainMethod<M> {
    /// Prepares it.
    pub(crate) fn new(scene: Arc<Scene>, settings: ChainSettings, photons_per_pass: u32, seed: u64, space: M) -> Self {
        let direct = direct(settings.max_depth).prepare(scene.clone(), photons_per_pass, seed);
        Self { scene, seed, settings, direct, space }
    }
}

impl<M: MakeSpace> PreparedMethod for ChainMethod<M> {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        let mut total = self.direct.trace_pass(pass, sums, cancel)?;
        let lengths = Lengths { shortest: SAMPLED + 1, longest: u32::try_from(self.settings.max_depth.get()).ok() };
        if !lengths.contain(SAMPLED + 1) {
            return Some(total);
        }
        let width = self.scene.width;
        let pixels = pass.region.row_start * width..pass.region.row_end * width;
        let numbers = |stream| PassRandom::independent(self.seed, stream, pass.index);
        let chains = Chains {
            space: &self.space.space(&self.scene, lengths, pixels),
            large_steps: self.settings.large_steps as f32 / 100.0,
            mutations: one_per_pixel(self.scene.pixel_count() as u64).saturating_mul(self.settings.mutations),
            chains: self.settings.chains,
            starts: numbers(Stream::Bootstrap),
            trials: numbers(Stream::Trial),
            steps: numbers(Stream::Chain),
        };
        for Found { brought, counters } in chains.trace(cancel)? {
            total += counters;
            for splat in brought {
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
