//! `sppm`: stochastic progressive photon mapping. Every pass traces one new camera path per pixel to the first surface
//! with a smooth lobe, emits photons, and gathers them there in a disc whose radius shrinks from pass to pass. All points that
//! a pixel sees share its statistics, so glossy surfaces, lenses and anti-aliasing converge too.
//!
//! References: \[HJ09\] Hachisuka & Jensen 2009, "Stochastic progressive photon mapping"; \[KZ11\] Knaus & Zwicker 2011,
//! "Progressive photon mapping: a probabilistic approach".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | R² | `pass.radius_squared` × `pass.scale` | m² |
//! | M, Φ | `PixelTally::photons`, `PixelTally::flux` (both over `pass.scale`) | –, W·sr⁻¹ |
//! | T | `GatherPoint::throughput` | – |
//! | α_p | photon flux, `Le·cos/pdf` | W |
//!
//! Limits: a bias that falls with the radius (corners and edges last); glossy surfaces seen in glossy surfaces need many
//! passes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::parameter_values::{
    Auto, Depth, DirectLight, Emission, LightPicks, OpenUnit, Passes, PhotonCount, PhotonEmission, Radius,
    RouletteDepth, limits,
};
use super::parameters::{ParameterSet, parameters, read_method};
use super::photon_pass::{Found, PhotonPasses, PhotonsOf, add_evenness, add_to_tally};
use super::pilot::CameraPaths;
use super::shared_parameters::{
    ALPHA, DIRECT, EMISSION, GATHER_RADIUS, LIGHT_PICKS, MAX_DEPTH, OCCLUSION, PASSES, PHOTONS, RADIUS_RULE, RR_DEPTH,
};
use super::visibility_pilot::LightSampling;
use super::{Bias, Gathering, MethodEntry, ParameterizedMethod, Pass, PilotPass, PreparedMethod, SceneTraits};
use crate::estimate::{PixelTally, RadiusRule, ShardSums};
use crate::math::random::{PassRandom, PathRandom, Stream};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::counters::Step;
use crate::transport::emission_learning::GuideParts;
use crate::transport::evenness::Evenness;
use crate::transport::occlusion::Occlusion;
use crate::transport::photon_map::{OriginPhoton, PhotonMap};

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "sppm",
    also_called: &["stochastic_ppm"],
    summary: "stochastic progressive photon mapping: new camera paths every pass, shared pixel statistics",
    cannot_sample: "nothing; every path with a surface that is not a mirror or glass is found",
    reference: "Hachisuka & Jensen 2009; Knaus & Zwicker 2011",
    bias: Bias::Shrinks,
    parameters: Parameters::HELP,
    negative_lobes: false,
    media: false,
    read: read_method::<Parameters>,
};

parameters! {
    /// Parameters of `sppm`.
    struct Parameters {
        alpha: OpenUnit = ALPHA,
        radius_rule: RadiusRule = RADIUS_RULE,
        photons_per_pass: Auto<PhotonCount> = PHOTONS,
        initial_radius: Auto<Radius> = GATHER_RADIUS,
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = RR_DEPTH,
        direct: DirectLight = DIRECT,
        light_picks: LightPicks = LIGHT_PICKS,
        emission: PhotonEmission = EMISSION,
        occlusion: Occlusion = OCCLUSION,
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
        Gathering::ShrinkingDiscs { rule: self.radius_rule, alpha: self.alpha.get() }
    }

    fn may_guide_photons(&self) -> bool {
        self.emission.of_paths() != Emission::Power
    }

    fn proposals(&self) -> &'static [Step] {
        self.emission.proposals()
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        let sampling = LightSampling::gathering(self.light_picks, limits(self.max_depth, self.rr_depth));
        (self.direct == DirectLight::Sample).then_some(sampling)
    }

    fn futile_in(&self, traits: SceneTraits) -> Option<&'static str> {
        self.direct.futile_in(traits)
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        let passes = PhotonPasses {
            scene,
            seed,
            limits: limits(self.max_depth, self.rr_depth),
            direct: self.direct,
            follows_narrow: true,
            photons_per_pass,
            first_radius: self.initial_radius.meters(),
            emission: self.emission.of_paths(),
            chains: self.emission == PhotonEmission::Metropolis,
            guide_parts: GuideParts::Cells,
            occlusion: self.occlusion,
        };
        Box::new(Sppm { passes, radius_rule: self.radius_rule })
    }
}

struct Sppm {
    passes: PhotonPasses,
    radius_rule: RadiusRule,
}

impl Sppm {
    /// One pixel of one pass; how evenly lies what it found.
    #[inline]
    fn trace_pixel(
        &self,
        pass: &Pass<'_>,
        map: &PhotonMap<f32>,
        (pixel, random): (usize, &PathRandom),
        radius_squared: f32,
        tally: &mut PixelTally,
        counters: &mut Counters,
    ) -> Evenness {
        let mut found = Found::default();
        let disc = (radius_squared * pass.scale, self.radius_rule);
        let radiance = self.passes.camera_path(random, pixel, counters, |point, radiance, counters| {
            *radiance += point.throughput * self.passes.direct_light(point, random, counters);
            self.passes.add_gathered(map, (point, point.throughput), disc, &mut found, counters);
        });
        add_to_tally(tally, pass, radiance, &found.gathered, counters);
        found.evenness
    }
}

impl PreparedMethod for Sppm {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        let photons = PhotonsOf::pass(pass);
        let (map, mut total) =
            self.passes.trace_photons::<OriginPhoton>(&photons, pass.typical_radius_squared, cancel)?;
        let random = PassRandom::of_pixels(self.passes.seed, Stream::Camera, pass.index);
        let width = self.passes.scene.width as usize;
        let first_pixel = pass.region.row_start as usize * width;
        let rows = sums.rows(width).into_par_iter().zip(pass.radius_squared.par_chunks(width)).enumerate();
        let counters: Vec<Counters> = rows
            .map(|(row, (sums, radii))| {
                let mut counters = Counters::default();
                if cancel.load(Ordering::Relaxed) {
                    return counters;
                }
                for (column, (tally, radius)) in sums.tallies.iter_mut().zip(radii).enumerate() {
                    let pixel = first_pixel + row * width + column;
                    let path = (pixel, &random.path(pixel as u32));
                    let evenness = self.trace_pixel(pass, &map, path, *radius, tally, &mut counters);
                    add_evenness(sums.evenness.get_mut(column), pass, &evenness);
                }
                counters
            })
            .collect();
        counters.into_iter().for_each(|counters| total += counters);
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let found = self.passes.pilot(&CameraPaths::new(&self.passes), cancel)?;
        Some(PilotPass::with_radii(found.radius_squared, found.counters).and_guide(found.guide))
    }
}
