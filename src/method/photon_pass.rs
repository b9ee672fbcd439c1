//! What `sppm` and `ppm` share: the photons of a pass and the gather.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::Pass;
use super::parameter_values::{Auto, DirectLight, Emission};
use crate::estimate::{PixelEvenness, PixelTally, RadiusRule};
use crate::math::Rgb;
use crate::math::color::luminance;
use crate::math::random::{PassRandom, PathRandom, Stream, dimension};
use crate::scene::Scene;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::transport::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use crate::transport::direct_light::direct_light;
use crate::transport::emission_learning::GuideParts;
use crate::transport::evenness::Evenness;
use crate::transport::first_radius::{
    FIRST_GATHER_PHOTONS, RadiusBounds, clear_of_edges, fill_gaps, first_radius_squared,
};
use crate::transport::importance_map::{ImportanceMap, Importon};
use crate::transport::metropolis::photon_chains::{PhotonChains, StoringTracer};
use crate::transport::occlusion::{Occlusion, Sight};
use crate::transport::photon_map::{Gathered, Grid, Photon, PhotonLookup, PhotonMap, TracedPhoton, trace};
use crate::transport::photon_tracing::PhotonSettings;
use crate::transport::receiver::{Counting, Receiver};
use crate::transport::{Counters, Limits};

/// One pixel in so many shows chains where the picture looks.
const LOOKING_APART: usize = 13;

/// The pass index of the pilot, which has streams of its own.
pub(crate) const PILOT_PASS: u32 = 0;

/// A scene and the parameters of a progressive method, ready to trace.
pub(crate) struct PhotonPasses {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Job seed.
    pub seed: u64,
    /// Limits on path length.
    pub limits: Limits,
    /// How direct light is found.
    pub direct: DirectLight,
    /// Whether camera paths go on at narrow lobes; else all photons are gathered there.
    pub follows_narrow: bool,
    /// Photons per pass.
    pub photons_per_pass: u32,
    /// First radius.
    pub first_radius: Auto<f32>,
    /// Where photons start.
    pub emission: Emission,
    /// Whether they are states of chains that stay where camera paths look.
    pub chains: bool,
    /// How finely they may be guided.
    pub guide_parts: GuideParts,
    /// Which photons are tested.
    pub occlusion: Occlusion,
}

/// Which photons to trace.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhotonsOf<'a> {
    /// What they are for.
    pub stream: Stream,
    /// Index of their pass.
    pub pass: u32,
    /// Where they start; by power without one.
    pub guide: Option<&'a EmissionGuide>,
}

impl<'a> PhotonsOf<'a> {
    /// Those of a pass of the job.
    pub(crate) fn pass(pass: &Pass<'a>) -> Self {
        Self { stream: Stream::Photon, pass: pass.index, guide: pass.guide }
    }
}

/// What a pixel's discs hold in a pass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    /// As the camera sees it.
    pub gathered: Gathered,
    /// How evenly it lies; nothing but under [`RadiusRule::Uniformity`].
    pub evenness: Evenness,
}

impl PhotonPasses {
    /// Traces photons and sorts them into cells of the size of a typical gather disc.
    pub(crate) fn trace_photons<R: TracedPhoton>(
        &self,
        photons: &PhotonsOf<'_>,
        typical_radius_squared: f32,
        cancel: &AtomicBool,
    ) -> Option<(PhotonMap<R::Extra>, Counters)> {
        let random = PassRandom::independent(self.seed, photons.stream, photons.pass);
        let settings = PhotonSettings {
            limits: self.limits,
            first_stored_segment: match self.direct {
                DirectLight::Sample => 2,
                DirectLight::Photons => 1,
            },
            narrow_takes_all: !self.follows_narrow,
            random: &random,
            paths: self.photons_per_pass,
            guide: photons.guide,
        };
        let (low, high) = self.scene.geometry.bounds();
        let cell = 2.0 * typical_radius_squared.sqrt();
        let grid = Grid::new(low, high, cell, 4 * u64::from(self.photons_per_pass).max(1 << 14));
        let mut looking = Counters::default();
        // The pilot learns from photons that start as its guide says.
        let importance = match self.chains && photons.stream == Stream::Photon {
            true => self.importance_map(photons.pass, &mut looking),
            false => None,
        };
        let (chunks, mut counters) = match &importance {
            Some(importance) => {
                let [mutations, trials] = [Stream::Chain, Stream::Trial]
                    .map(|stream| PassRandom::independent(self.seed, stream, photons.pass));
                let importance = |photon: &Photon| importance.of(photon);
                PhotonChains::<StoringTracer<'_, R>, _>::storing(&self.scene, settings, importance, mutations, trials)
                    .trace(&grid, cancel)?
            }
            None => trace::<R>(&self.scene, &settings, &grid, cancel)?,
        };
        counters += looking;
        Some((PhotonMap::build(&chunks, grid), counters))
    }

    /// Where the camera paths of a pass look for photons, over the whole picture whatever the pass's region; `None` where they look at nothing.
    pub(super) fn importance_map(&self, pass: u32, counters: &mut Counters) -> Option<ImportanceMap> {
        let random = PassRandom::independent(self.seed, Stream::Importance, pass);
        let pixels = self.scene.pixel_count();
        let first = pass as usize % LOOKING_APART.min(pixels);
        let look = |pixel: usize| {
            let (mut counters, mut importons) = (Counters::default(), Vec::new());
            self.camera_path(&random.path(pixel as u32), pixel, &mut counters, |point, _, _| {
                let importance = luminance(point.throughput);
                importons.push(Importon { position: point.hit.position, importance });
            });
            (importons, counters)
        };
        let looks: Vec<(Vec<Importon>, Counters)> =
            (first..pixels).into_par_iter().step_by(LOOKING_APART).with_min_len(64).map(look).collect();
        looks.iter().for_each(|(_, counted)| *counters += *counted);
        let importons: Vec<Importon> = looks.into_iter().flat_map(|(importons, _)| importons).collect();
        ImportanceMap::new(self.scene.geometry.bounds(), &importons)
    }

    /// Sampled direct light at a gather point, without the path's throughput; black where photons bring it.
    #[inline]
    pub(crate) fn direct_light(&self, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
        if self.direct == DirectLight::Sample && self.limits.allows(point.segments + 1) {
            direct_light(&self.scene, point, random, counters)
        } else {
            Rgb::ZERO
        }
    }

    /// Reflected flux Φ/T = Σ f_r·α and the photon count M at a gather point.
    #[inline]
    pub(crate) fn gather(
        &self,
        map: &PhotonMap<f32>,
        point: &GatherPoint,
        radius_squared: f32,
        counters: &mut Counters,
    ) -> Gathered {
        let counting = self.counting(point, radius_squared);
        let receiver = Receiver::new(&self.scene, &point.hit, point.view());
        let gathered = receiver.gather(map, counting);
        if gathered.photons == 0.0 {
            return gathered;
        }
        match Sight::new(&self.scene, &point.hit, &receiver.query(counting), self.occlusion) {
            Some(sight) => gather_in_sight(&sight, map, &receiver, counting, counters).unwrap_or(gathered),
            None => gathered,
        }
    }

    /// Adds what the disc around a gather point holds, of which the camera sees `throughput`; what the radius rule does not ask for is not measured.
    #[inline]
    pub(crate) fn add_gathered(
        &self,
        map: &PhotonMap<f32>,
        (point, throughput): (&GatherPoint, Rgb),
        (radius_squared, rule): (f32, RadiusRule),
        found: &mut Found,
        counters: &mut Counters,
    ) {
        let gathered = match rule {
            RadiusRule::Statistics | RadiusRule::Schedule => self.gather(map, point, radius_squared, counters),
            RadiusRule::Uniformity => {
                let (gathered, evenness) = self.gather_measured(map, (point, throughput), radius_squared, counters);
                found.evenness.add(&evenness);
                gathered
            }
        };
        found.gathered.add(&gathered, throughput);
    }

    /// [`gather`](Self::gather), and how evenly lies what the camera sees of it.
    #[inline(never)]
    fn gather_measured(
        &self,
        map: &PhotonMap<f32>,
        (point, throughput): (&GatherPoint, Rgb),
        radius_squared: f32,
        counters: &mut Counters,
    ) -> (Gathered, Evenness) {
        let counting = self.counting(point, radius_squared);
        let receiver = Receiver::new(&self.scene, &point.hit, point.view());
        match Sight::new(&self.scene, &point.hit, &receiver.query(counting), self.occlusion) {
            None => receiver.gather_measured(map, counting, throughput, |_| true),
            Some(sight) => receiver.gather_measured(map, counting, throughput, |index| {
                sight.accepts(&map.photon(index), map.extras()[index], counters)
            }),
        }
    }

    /// Which photons count at a gather point.
    #[inline]
    pub(crate) fn counting(&self, point: &GatherPoint, radius_squared: f32) -> Counting {
        let most_segments = self.limits.most_photon_segments(point.segments);
        Counting { radius_squared, most_segments, caustics_only: point.goes_on }
    }

    /// First R² at a gather point, m²; the search starts with `guess`, m².
    pub(crate) fn first_radius_squared(&self, map: &impl PhotonLookup, point: &GatherPoint, guess: f32) -> f32 {
        if let Auto::Value(radius) = self.first_radius {
            return radius * radius;
        }
        let footprint = self.scene.camera.pixel_footprint(point.path_length, self.scene.film.whole[0]);
        let bounds = RadiusBounds { guess, ..self.radius_bounds(map.len()) };
        let dense = first_radius_squared(map, point, footprint, &bounds);
        clear_of_edges(&self.scene, point, dense, footprint)
    }

    /// First R² of every pixel from those of the pixels that see something to gather at, m².
    pub(crate) fn complete_first_radii(&self, radii: &mut [Option<f32>]) -> Vec<f32> {
        match self.first_radius {
            Auto::Auto => fill_gaps(radii, self.scene.width as usize, self.fallback_radius_squared()),
            Auto::Value(radius) => vec![radius * radius; radii.len()],
        }
    }

    /// Traces the path of a pixel in a pass and shows `gather` where it gathers; the radiance seen on the way.
    #[inline]
    pub(crate) fn camera_path(
        &self,
        random: &PathRandom,
        pixel: usize,
        counters: &mut Counters,
        gather: impl FnMut(&GatherPoint, &mut Rgb, &mut Counters),
    ) -> Rgb {
        let scene = &*self.scene;
        let pixel = [pixel as u32 % scene.width, pixel as u32 / scene.width];
        let ray = scene.camera_ray(pixel, random.block(dimension::CAMERA));
        let walk = CameraWalk::new(scene, ray, self.direct == DirectLight::Sample);
        let mut radiance = Rgb::ZERO;
        trace_camera_path(scene, walk, random, &self.limits, &mut radiance, counters, gather);
        radiance
    }

    /// Where the search for first radii starts.
    pub(super) fn radius_bounds(&self, photons: usize) -> RadiusBounds {
        RadiusBounds::new(self.scene.geometry.bounding_sphere().1, photons)
    }

    /// R² for pixels that see nothing to gather at, m².
    fn fallback_radius_squared(&self) -> f32 {
        self.radius_bounds(self.photons_per_pass as usize).guess.max(f32::MIN_POSITIVE * FIRST_GATHER_PHOTONS)
    }
}

/// What `receiver` reflects of the photons that count; `None` where all do.
#[inline(never)]
fn gather_in_sight(
    sight: &Sight<'_>,
    map: &PhotonMap<f32>,
    receiver: &Receiver<'_>,
    counting: Counting,
    counters: &mut Counters,
) -> Option<Gathered> {
    receiver.gather_some(map, counting, |index| sight.accepts(&map.photon(index), map.extras()[index], counters))
}

/// Adds how evenly lies what a pass found in a pixel, where that is summed; what is not finite is dropped. It is counted as flux.
#[inline]
pub(crate) fn add_evenness(sums: Option<&mut PixelEvenness>, pass: &Pass<'_>, evenness: &Evenness) {
    if let Some(sums) = sums
        && evenness.is_finite()
    {
        let inverse_scale = 1.0 / pass.scale;
        sums.flux_slope = [0, 1].map(|axis| sums.flux_slope[axis] + evenness.slope[axis] * inverse_scale);
        sums.squared_flux += evenness.squares * inverse_scale * inverse_scale;
    }
}

/// Adds one pass's sums of a pixel; what is not finite is dropped and counted.
#[inline]
pub(crate) fn add_to_tally(
    pixel: &mut PixelTally,
    pass: &Pass<'_>,
    radiance: Rgb,
    gathered: &Gathered,
    counters: &mut Counters,
) {
    let inverse_scale = 1.0 / pass.scale;
    if radiance.is_finite() {
        pixel.radiance = (Rgb::from_array(pixel.radiance) + radiance).to_array();
    } else {
        counters.non_finite += 1;
    }
    if gathered.flux.is_finite() {
        pixel.flux = (Rgb::from_array(pixel.flux) + gathered.flux * inverse_scale).to_array();
        pixel.inner_flux += gathered.inner_flux.element_sum() / 3.0 * inverse_scale;
    } else {
        counters.non_finite += 1;
    }
    pixel.photons += gathered.photons * inverse_scale;
}
