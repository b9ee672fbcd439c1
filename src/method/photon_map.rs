//! `photon_map`: Jensen's two passes. Every pass of the job first traces photons into a global map and a caustic map of
//! its own, then follows one camera path per pixel through specular and narrow glossy lobes to the first wide one. There
//! direct light is sampled, caustics are read from the caustic map, and soft indirect light is gathered: rays sampled
//! from the BSDF look up the radiance that the global map estimates where they end. Passes are averaged.
//!
//! References: [J96] Jensen 1996, "Global illumination using photon maps"; [Wa99] Wald 1999, "Photorealistic rendering
//! using the photon map", sections 2.5 (estimate, caustic map), 4.3 (local pass), 4.4 (multiple maps); [Vo11] Vorba 2011,
//! "Bidirectional photon mapping", section 1.6 with eq. 1.12.
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
//! | direct light at X | L X … E; at a G the camera path may find it by chance too, and both share its weight |
//! | caustic map at X | L S+ X … E |
//! | final gather | L S* X (S\|G\|D)* D … E: a D lies between X and the eye; the one next to the eye gathers |
//!
//! A gather ray goes on at S and G. At a G it takes direct light and caustics (L S* G … D … E), and at the first D′ it
//! ends with the radiance that the global map estimates (L (S|G|D)* D′ … D … E): that map holds all photons, first hits
//! too. Emission that it meets before any G does not count: at the gathering D that is direct light or a caustic. A ray
//! that ends within `largest_radius` of where it began would see its own corner blurred across the edge; there D′ does as
//! D did [J96]: direct light, caustics, and one more gather ray. With `final_gather: 0` the D looks at the global map
//! itself, for photons that some D or G scattered.
//!
//! Limits: an estimate is wrong where the density changes within r: dark towards edges, light that leaks under walls,
//! caustics with blurred rims. Averaging passes removes noise and none of this, which is why progressive methods exist; r
//! falls as √(k/photons_per_pass). Memory: 36 bytes per stored photon, and again for each caustic one.

mod local_pass;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use local_pass::LocalPass;

use super::bounded_numbers::bounded;
use super::gather_ends::GatherEnds;
use super::parameter_values::{Auto, Depth, Emission, LightPicks, Passes, PhotonCount, Radius, RouletteDepth, limits};
use super::parameters::{ParameterSet, ParameterValue, parameter, parameters, read_method};
use super::photon_pass::{PILOT_PASS, add_to_tally};
use super::shared_parameters::{EMISSION, LIGHT_PICKS, MAX_DEPTH, OCCLUSION, PASSES, PHOTONS, RR_DEPTH};
use super::visibility_pilot::LightSampling;
use super::{Bias, Gathering, MethodEntry, ParameterizedMethod, Pass, PilotPass, PreparedMethod};
use crate::estimate::{PixelTally, Region};
use crate::math::random::{PassRandom, Stream};
use crate::scene::Scene;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::transport::density_estimate::DensityEstimate;
use crate::transport::first_radius::{FIRST_GATHER_PHOTONS, RadiusBounds};
use crate::transport::kernel::Kernel;
use crate::transport::occlusion::Occlusion;
use crate::transport::photon_map::{
    self as maps, FIRST_SEARCH_CELLS, Gathered, Grid, KdTree, Nearest, OriginLookup, OriginPhoton, Photon, PhotonMap,
};
use crate::transport::photon_tracing::PhotonSettings;
use crate::transport::{Counters, Limits};

/// What a look-up costs, in rays, for the pilot's count.
const RAYS_PER_LOOKUP: u64 = 6;

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: "photon_map",
    summary: "photon mapping in two passes: sampled direct light, caustic map, final gather from a global map",
    cannot_sample: "nothing; but more passes do not remove the bias of its estimate, only more photons per pass do",
    reference: "Jensen 1996",
    bias: Bias::Stays,
    parameters: Parameters::HELP,
    negative_lobes: false,
    media: false,
    read: read_method::<Parameters>,
};

bounded! {
    /// k, photons in a look-up.
    struct Neighbors(u32), [2 to 65536]
}

bounded! {
    /// Gather rays of a camera path.
    struct GatherRays(u32), [0 to 1024]
}

/// The structure that photons are looked up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
enum Structure {
    /// Cells of equal size.
    Grid,
    /// A balanced tree.
    KdTree,
}

impl ParameterValue for Structure {
    const RANGE: &'static str = "grid, kdtree";
}

parameters! {
    /// Parameters of `photon_map`.
    struct Parameters {
        photons_per_pass: Auto<PhotonCount> = PHOTONS,
        neighbors: Neighbors = parameter(
            "nearest photons in a look-up of the global map",
            Neighbors::new(20).expect("in range"),
            "20",
        ),
        caustic_neighbors: Neighbors = parameter(
            "nearest photons in a look-up of the caustic map",
            Neighbors::new(10).expect("in range"),
            "10",
        ),
        largest_radius: Auto<Radius> = parameter(
            "largest radius of a look-up, m; gather rays shorter than it go on",
            Auto::Auto,
            "auto: half the area that k photons take on average",
        ),
        kernel: Kernel = parameter("how photons count by their distance", Kernel::Epanechnikov, "epanechnikov"),
        light_picks: LightPicks = LIGHT_PICKS,
        emission: Emission = EMISSION,
        occlusion: Occlusion = OCCLUSION,
        final_gather: GatherRays = parameter(
            "gather rays per camera path; 0 looks at the global map directly",
            GatherRays::new(4).expect("in range"),
            "4",
        ),
        structure: Structure =
            parameter("what photons are looked up in: cells or a balanced tree", Structure::Grid, "grid"),
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
        // There is no radius per pixel: what is gathered is radiance at once.
        Gathering::Nothing
    }

    fn may_guide_photons(&self) -> bool {
        self.emission != Emission::Power
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        Some(LightSampling::gathering(self.light_picks, limits(self.max_depth, self.rr_depth)))
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        let scene_radius = scene.geometry.bounding_sphere().1;
        let look_up = |neighbors: Neighbors| self.look_up(neighbors.get(), scene_radius, photons_per_pass);
        Box::new(TwoPasses {
            seed,
            limits: limits(self.max_depth, self.rr_depth),
            photons_per_pass,
            global: look_up(self.neighbors),
            caustic: look_up(self.caustic_neighbors),
            gather_rays: self.final_gather.get(),
            emission: self.emission,
            structure: self.structure,
            scene,
        })
    }
}

impl Parameters {
    fn look_up(&self, neighbors: u32, scene_radius: f32, photons_per_pass: u32) -> LookUp {
        let automatic = largest_radius_squared(scene_radius, neighbors, photons_per_pass);
        let largest_radius_squared = match self.largest_radius.meters() {
            Auto::Value(radius) => radius * radius,
            Auto::Auto => automatic,
        };
        let Self { kernel, occlusion, .. } = *self;
        let first_radius = largest_radius_squared.min(automatic).sqrt();
        let neighbors = neighbors as usize;
        LookUp { estimate: DensityEstimate { neighbors, largest_radius_squared, kernel, occlusion }, first_radius }
    }
}

/// The largest r² where the user named none, m²: half the area that `neighbors` photons would have on the scene's
/// bounding sphere, at most 5 % of its radius. Surfaces are smaller than that sphere, so at mean brightness about k are
/// found. Larger discs would find more in the dark, but blur it, and bring more light over edges than they take.
fn largest_radius_squared(scene_radius: f32, neighbors: u32, photons_per_pass: u32) -> f32 {
    // Two or three photons are stored per emitted one in a closed room.
    let bounds = RadiusBounds::new(scene_radius, 2 * photons_per_pass as usize);
    let mean = bounds.guess * (neighbors as f32 / FIRST_GATHER_PHOTONS);
    (0.5 * mean).clamp(f32::MIN_POSITIVE, RadiusBounds::largest_squared(scene_radius))
}

/// A scene and the method's parameters.
struct TwoPasses {
    scene: Arc<Scene>,
    seed: u64,
    limits: Limits,
    photons_per_pass: u32,
    global: LookUp,
    caustic: LookUp,
    gather_rays: u32,
    emission: Emission,
    structure: Structure,
}

/// How a map is looked at.
struct LookUp {
    estimate: DensityEstimate,
    /// What a search starts with, m; sizes the map's cells.
    first_radius: f32,
}

/// The photons of a pass.
struct Maps<P> {
    /// For gather rays: all photons. Without them: those that a lobe with a density has scattered.
    global: P,
    /// Photons that only mirrors and glass have scattered, at least once.
    caustic: P,
}

impl TwoPasses {
    /// First pass: traces and sorts photons.
    fn trace_photons(
        &self,
        stream: Stream,
        pass: &Pass<'_>,
        cancel: &AtomicBool,
    ) -> Option<(Maps<PhotonMap<f32>>, Counters)> {
        let random = PassRandom::independent(self.seed, stream, pass.index);
        let settings = PhotonSettings {
            limits: self.limits,
            first_stored_segment: 1,
            narrow_takes_all: false,
            random: &random,
            paths: self.photons_per_pass,
            guide: pass.guide,
        };
        let (chunks, counters) = maps::trace::<OriginPhoton>(&self.scene, &settings, &self.grid(&self.global), cancel)?;
        let all = PhotonMap::build(&chunks, self.grid(&self.global));
        let caustic = all.select(self.grid(&self.caustic), Photon::is_caustic);
        let global = match self.gather_rays {
            0 => all.select(self.grid(&self.global), Photon::is_scattered),
            _ => all,
        };
        Some((Maps { global, caustic }, counters))
    }

    fn grid(&self, look_up: &LookUp) -> Grid {
        let (low, high) = self.scene.geometry.bounds();
        let cell = look_up.first_radius / FIRST_SEARCH_CELLS;
        Grid::new(low, high, cell, 4 * u64::from(self.photons_per_pass).max(1 << 14))
    }

    /// Both passes, with random numbers of `streams` for photons and camera.
    fn trace(
        &self,
        streams: [Stream; 2],
        pass: &Pass<'_>,
        pixels: &mut [PixelTally],
        cancel: &AtomicBool,
    ) -> Option<Counters> {
        let (maps, mut total) = self.trace_photons(streams[0], pass, cancel)?;
        total += match self.structure {
            Structure::Grid => self.look_at_pixels(&maps, streams[1], pass, pixels, cancel),
            Structure::KdTree => {
                let maps = Maps { global: KdTree::from(maps.global), caustic: KdTree::from(maps.caustic) };
                self.look_at_pixels(&maps, streams[1], pass, pixels, cancel)
            }
        };
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    /// Second pass, with random numbers of `stream`.
    fn look_at_pixels<P: OriginLookup>(
        &self,
        maps: &Maps<P>,
        stream: Stream,
        pass: &Pass<'_>,
        pixels: &mut [PixelTally],
        cancel: &AtomicBool,
    ) -> Counters {
        let width = self.scene.width as usize;
        let random = PassRandom::of_pixels(self.seed, stream, pass.index);
        let trace_row = |(row, tallies): (usize, &mut [PixelTally])| {
            let mut gathering = LocalPass { method: self, maps, found: Nearest::default() };
            let mut counters = Counters::default();
            if cancel.load(Ordering::Relaxed) {
                return counters;
            }
            let y = pass.region.row_start + row as u32;
            for (x, tally) in (0..).zip(tallies) {
                let random = random.path(y * self.scene.width + x);
                let radiance = gathering.pixel([x, y], &random, &mut counters);
                add_to_tally(tally, pass, radiance, &Gathered::default(), &mut counters);
            }
            counters
        };
        let counters: Vec<Counters> = pixels.par_chunks_mut(width).enumerate().map(trace_row).collect();
        let mut total = Counters::default();
        counters.into_iter().for_each(|counters| total += counters);
        total
    }
}

impl PreparedMethod for TwoPasses {
    fn trace_pass(&self, pass: &Pass<'_>, pixels: &mut [PixelTally], cancel: &AtomicBool) -> Option<Counters> {
        self.trace([Stream::Photon, Stream::Camera], pass, pixels, cancel)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let region = Region { row_start: 0, row_end: self.scene.height };
        let count = self.scene.pixel_count();
        let ends = GatherEnds {
            scene: &self.scene,
            limits: self.limits,
            gathers: self.gather_rays > 0,
            random: PassRandom::of_pixels(self.seed, Stream::PilotCamera, PILOT_PASS),
        };
        let values =
            ends.learn(self.seed, self.photons_per_pass, (self.emission, self.global.estimate.occlusion), cancel)?;
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
        let mut nobody_looks = vec![PixelTally::default(); count];
        let mut counters = self.trace([Stream::PilotPhoton, Stream::PilotCamera], &pass, &mut nobody_looks, cancel)?;
        counters.rays += count as u64 * (1 + u64::from(self.gather_rays)) * RAYS_PER_LOOKUP;
        Some(PilotPass::without_fields(counters).and_guide(values))
    }
}
