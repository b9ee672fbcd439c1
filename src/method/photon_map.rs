//! `photon_map`: Jensen's two passes. Every pass of the job first traces photons into a global map and a caustic map of
//! its own, then follows one camera path per pixel through specular and narrow glossy lobes to the first wide one. There
//! direct light is sampled, caustics are read from the caustic map, and soft indirect light is gathered: rays sampled
//! from the BSDF look up the radiance that the global map estimates where they end. Passes are averaged.
//!
//! References: \[J96\] Jensen 1996, "Global illumination using photon maps"; \[Wa99\] Wald 1999, "Photorealistic rendering
//! using the photon map", sections 2.5 (estimate, caustic map), 4.1 (plausibility), 4.3 (local pass), 4.4 (multiple maps), 4.5
//! (hierarchy), 4.8 (choice of k); \[He98\] Heinrich 1998, "A multilevel version of the method of dependent tests"; \[Vo11\] Vorba
//! 2011, "Bidirectional photon mapping", section 1.6 with eq. 1.12.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | L(x, ωo) | `DensityEstimate::reflected` over `photons_per_pass` [Vo11, eq. 1.12] | W·sr⁻¹·m⁻² |
//! | k, N in the sources | `neighbors`, `caustic_neighbors`; the k-th photon gives r and does not count | – |
//! | r | distance of the k-th photon, at most `largest_radius` | m |
//! | Φ_p | photon flux, `Le·cos/pdf` | W |
//!
//! Paths, from the light L to the eye E: S specular, G a narrow glossy lobe, D a wide lobe. X is the D or G next to the
//! light, and `…` stands for (S|G)*. Every path belongs to one part:
//!
//! | part | paths |
//! |---|---|
//! | emission seen | L S* E |
//! | direct light at X | L X … E; at a G the camera path may find it by chance too, and both share its weight; at a D `direct` says how |
//! | caustic map at X | L S+ X … E |
//! | final gather | L S* X (S\|G\|D)* D … E: a D lies between X and the eye; the one next to the eye gathers |
//!
//! A gather ray goes on at S and G. At a G it takes direct light and caustics (L S* G … D … E), and at the first D′ it
//! ends with the radiance that the global map estimates (L (S|G|D)* D′ … D … E): that map holds all photons, first hits
//! too. Emission that it meets before any G does not count: at the gathering D that is direct light or a caustic. A ray
//! that ends within `largest_radius` of where it began would see its own corner blurred across the edge; there D′ does as
//! D did \[J96\]: direct light, caustics, and one more gather ray. With `final_gather: 0` the D looks at the global map
//! itself, for photons that some D or G scattered.
//!
//! Many maps [Wa99, sections 4.4 and 4.5]: a pass traces sets of `maps` maps each, one set after the other, and estimates are
//! means over a set. There is one set; with `skipping: S` there are S², and each pixel looks at one of them; with
//! `hierarchy`, pixels on finer levels of a scanline look at fewer of them. A sample of a pixel is the mean of `camera_paths`
//! paths, which look at the same set.
//! `caustic_splitting` brings more photons to the caustic map alone, see [`caustic_splitting`](crate::transport::caustic_splitting);
//! `storage: importance` keeps photons of the global map where gather rays end (`storage.rs`).
//! `direct` says who finds L D … E, where the camera path ends: `sample` and `photon_direct` sample lights and the D's lobes, `shadow_photons`
//! does so without shadow rays where photons tell what is seen, and `photons` looks up those of one segment, which no other part counts.
//! At a G it is the same with all of them: one light sample, with as usual picked lights, shares its weight with the path that goes on.
//! With `cache_error` rays gather irradiance for a whole neighbourhood on matte surfaces ([`crate::transport::irradiance`]).
//!
//! Limits: an estimate is wrong where the density changes within r: dark towards edges, light that leaks under walls,
//! caustics with blurred rims. Averaging passes removes noise and none of this, which is why progressive methods exist; r
//! falls as √(k/photons_per_pass). Memory: 36 bytes per stored photon, and again for each caustic one.

mod chained;
mod contradictions;
mod direct_light;
mod first_pass;
mod hierarchy;
mod irradiance_cache;
mod local_pass;
mod look_up;
pub(crate) mod mps;
mod parameters;
mod second_pass;
mod storage;
mod whole_paths;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hierarchy::Hierarchy;
use look_up::LookUp;
use parameters::{DirectMode, Parameters};
use second_pass::{MapChoice, Step, TracedPass};
use whole_paths::PhotonPathSettings;

use super::gather_ends::GatherEnds;
use super::parameter_values::{Emission, limits};
use super::parameters::{ParameterSet, read_method};
use super::photon_pass::PILOT_PASS;
use super::visibility_pilot::LightSampling;
use super::{
    Bias, Contradiction, Gathering, MethodEntry, ParameterizedMethod, Pass, PilotPass, PreparedMethod, SceneTraits,
};
use crate::estimate::{Region, ShardSums};
use crate::math::random::{PassRandom, Stream};
use crate::scene::Scene;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::transport::caustic_splitting::CausticSplitting;
use crate::transport::counters::Step as Proposal;
use crate::transport::{Counters, Limits};

/// What a look-up costs, in rays, for the pilot's count.
const RAYS_PER_LOOKUP: u64 = 6;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "photon_map",
    also_called: &["pm", "photonmapper", "photonmapping", "photon_mapping"],
    summary: "photon mapping in two passes: sampled direct light, caustic map, final gather from a global map",
    cannot_sample: "nothing; but more passes do not remove the bias of its estimate, only more photons per pass do",
    reference: "Jensen 1996",
    bias: Bias::Stays,
    parameters: Parameters::HELP,
    negative_lobes: false,
    media: false,
    read: read_method::<Parameters>,
};

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        self.photons_per_pass.settle(pixels)
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        // There is no radius per pixel: what is gathered is radiance at once.
        Gathering::Nothing
    }

    fn may_guide_photons(&self) -> bool {
        self.emission.of_paths() != Emission::Power
    }

    fn proposals(&self) -> &'static [Proposal] {
        self.emission.proposals()
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(LightSampling::gathering(self.light_picks, limits(self.max_depth, self.rr_depth)))
    }

    fn futile_in(&self, traits: SceneTraits) -> Option<&'static str> {
        if self.caustic_splitting.get() > 1 && !traits.specular {
            return Some(
                "nothing is a mirror or glass, so there are no caustics to split; caustic_splitting: 1 spares its photons",
            );
        }
        (traits.sealed_lights && self.direct == DirectMode::Sample).then_some(
            "nearly all light meets mirrors or glass first, so sampled direct light finds hardly any, and most of what is seen is read \
             from the caustic map, which no gather ray smooths; sppm shrinks what that blurs",
        )
    }

    fn contradiction(&self) -> Option<Contradiction> {
        self.first_contradiction()
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        Box::new(TwoPasses::new(self.clone(), scene, photons_per_pass, seed, None))
    }
}

impl TwoPasses {
    /// Prepares both passes for a scene.
    fn new(
        parameters: Parameters,
        scene: Arc<Scene>,
        photons_per_pass: u32,
        seed: u64,
        whole_paths: Option<PhotonPathSettings>,
    ) -> Self {
        let scene_radius = scene.geometry.bounding_sphere().1;
        let photons = photons_per_pass / parameters.maps.get();
        let splitting = CausticSplitting::new(parameters.caustic_splitting.get(), parameters.splitting, &scene);
        let caustic_photons = photons.saturating_mul(splitting.factor());
        Self {
            seed,
            limits: limits(parameters.max_depth, parameters.rr_depth),
            photons_per_pass,
            global: parameters.look_up(parameters.neighbors.get(), scene_radius, photons),
            caustic: parameters.caustic_look_up(scene_radius, caustic_photons),
            direct: parameters.direct_look_up(scene_radius, photons),
            choice: parameters.map_choice(scene.width),
            splitting,
            parameters,
            whole_paths,
            scene,
        }
    }
}

/// A scene and the method's parameters.
struct TwoPasses {
    scene: Arc<Scene>,
    seed: u64,
    limits: Limits,
    photons_per_pass: u32,
    global: LookUp,
    caustic: LookUp,
    direct: LookUp,
    choice: MapChoice,
    splitting: CausticSplitting,
    parameters: Parameters,
    /// Photons of whole paths in place of those of light paths.
    whole_paths: Option<PhotonPathSettings>,
}

impl Parameters {
    /// Which pixels of a picture `width` pixels wide look at which maps.
    fn map_choice(&self, width: u32) -> MapChoice {
        match (self.hierarchy.get(), self.skipping.get()) {
            (0, 1) => MapChoice::Only,
            (0, skipping) => MapChoice::Skipping(skipping * skipping),
            (levels, _) => {
                let (coarsest, finest) = (self.coarsest_samples.get(), self.finest_samples.get());
                MapChoice::Hierarchy(Hierarchy::new(width, levels, coarsest, finest))
            }
        }
    }
}

impl PreparedMethod for TwoPasses {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        TracedPass { method: self, streams: [Stream::Photon, Stream::Camera], pass, cancel }.trace(&mut sums.tallies)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let region = Region { row_start: 0, row_end: self.scene.height };
        let ends = GatherEnds {
            scene: &self.scene,
            limits: self.limits,
            gathers: self.parameters.final_gather.get() > 0,
            random: PassRandom::of_pixels(self.seed, Stream::PilotCamera, PILOT_PASS),
        };
        let values = ends.learn(
            self.seed,
            self.photons_per_pass,
            (self.parameters.emission.of_paths(), self.global.estimate.occlusion),
            cancel,
        )?;
        // They were read once already.
        let guide = values.as_ref().and_then(|values| EmissionGuide::new(values, &self.scene.lights).ok());
        let pass = Pass {
            index: PILOT_PASS,
            region,
            radius_squared: &[],
            scale: 1.0,
            typical_radius_squared: 1.0,
            guide: guide.as_ref(),
        };
        let traced =
            TracedPass { method: self, streams: [Stream::PilotPhoton, Stream::PilotCamera], pass: &pass, cancel };
        let counters = self.cost(&traced)?;
        Some(PilotPass::without_fields(counters).and_guide(values))
    }
}

impl TwoPasses {
    /// What a pass costs, by one set of its maps and one look of every pixel; that pixels are localized is not foreseen.
    fn cost(&self, traced: &TracedPass<'_>) -> Option<Counters> {
        let mut nobody_cares = vec![(); self.scene.pixel_count()];
        let step = Step { set: 0, sample: 0 };
        let (seen, photons) = traced.trace_seen(step.set)?;
        let mut looks = traced.look_at(seen, step, &mut nobody_cares, |_, ()| true, |(), _, _| {})?;
        looks.rays += self.look_ups(&looks) * RAYS_PER_LOOKUP;
        let mut total = scaled(&photons, f64::from(self.choice.sets()));
        total += scaled(&looks, self.choice.mean_sets_of_a_pixel());
        Some(total)
    }

    /// Look-ups of one look of every pixel, which traced so many rays.
    fn look_ups(&self, looks: &Counters) -> u64 {
        let Parameters { final_gather, camera_paths, maps, direct, cache_error, .. } = &self.parameters;
        let paths = self.scene.pixel_count() as u64 * u64::from(camera_paths.get());
        let gathered = match cache_error.on() {
            None => paths * (1 + u64::from(final_gather.get())),
            // Nearly every ray is one of a record, and ends with a look-up.
            Some(_) => looks.rays,
        };
        gathered * u64::from(maps.get()) + paths * u64::from(*direct != DirectMode::Sample)
    }
}

/// Counts of so many times as much.
fn scaled(counters: &Counters, factor: f64) -> Counters {
    let times = |count: u64| (count as f64 * factor) as u64;
    let Counters { rays, photons_emitted, photons_stored, non_finite, steps } = *counters;
    Counters {
        rays: times(rays),
        photons_emitted: times(photons_emitted),
        photons_stored: times(photons_stored),
        non_finite: times(non_finite),
        steps,
    }
}
