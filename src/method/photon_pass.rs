//! What `sppm` and `ppm` share: the photons of a pass, the gather, and the pilot.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::Pass;
use super::parameter_values::{Auto, DirectLight};
use crate::estimate::PixelTally;
use crate::math::Rgb;
use crate::math::random::{PassRandom, PathRandom, Stream, dimension};
use crate::scene::Scene;
use crate::transport::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use crate::transport::direct_light::direct_light;
use crate::transport::first_radius::{
    FIRST_GATHER_PHOTONS, RadiusBounds, clear_of_edges, fill_gaps, first_radius_squared,
};
use crate::transport::photon_map::{Gathered, Grid, PhotonLookup, PhotonMap, trace};
use crate::transport::photon_tracing::PhotonSettings;
use crate::transport::receiver::{Counting, Receiver};
use crate::transport::{Counters, Limits};

/// The pass index of the pilot, which has streams of its own.
pub const PILOT_PASS: u32 = 0;

/// A scene and the parameters of a progressive method, ready to trace.
pub struct PhotonPasses {
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
}

impl PhotonPasses {
    /// Traces the photons of pass `pass` and sorts them into cells of the size of a typical gather disc.
    pub fn photon_map(
        &self,
        stream: Stream,
        pass: u32,
        typical_radius_squared: f32,
        cancel: &AtomicBool,
    ) -> Option<(PhotonMap, Counters)> {
        let random = PassRandom::independent(self.seed, stream, pass);
        let settings = PhotonSettings {
            limits: self.limits,
            first_stored_segment: match self.direct {
                DirectLight::Sample => 2,
                DirectLight::Photons => 1,
            },
            narrow_takes_all: !self.follows_narrow,
            random: &random,
            paths: self.photons_per_pass,
        };
        let (low, high) = self.scene.geometry.bounds();
        let cell = 2.0 * typical_radius_squared.sqrt();
        let grid = Grid::new(low, high, cell, 4 * u64::from(self.photons_per_pass).max(1 << 14));
        let (chunks, counters) = trace(&self.scene, &settings, &grid, cancel)?;
        Some((PhotonMap::build(&chunks, grid), counters))
    }

    /// Sampled direct light at a gather point, without the path's throughput; black where photons bring it.
    #[inline]
    pub fn direct_light(&self, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
        if self.direct == DirectLight::Sample && self.limits.allows(point.segments + 1) {
            direct_light(&self.scene, point, random, counters)
        } else {
            Rgb::ZERO
        }
    }

    /// Reflected flux Φ/T = Σ f_r·α and the photon count M at a gather point.
    #[inline]
    pub fn gather(&self, map: &impl PhotonLookup, point: &GatherPoint, radius_squared: f32) -> Gathered {
        let most_segments = self.limits.most_photon_segments(point.segments);
        let counting = Counting { radius_squared, most_segments, caustics_only: point.goes_on };
        Receiver::new(&self.scene, &point.hit, point.view()).gather(map, counting)
    }

    /// First R² at a gather point that the camera sees over `path_length` m, m².
    pub fn first_radius_squared(&self, map: &impl PhotonLookup, point: &GatherPoint, path_length: f32) -> f32 {
        if let Auto::Value(radius) = self.first_radius {
            return radius * radius;
        }
        let footprint = self.scene.camera.pixel_footprint(path_length, self.scene.film.whole[0]);
        let dense = first_radius_squared(map, point, footprint, &self.radius_bounds(map.len()));
        clear_of_edges(&self.scene, point, dense, footprint)
    }

    /// First R² of every pixel from those of the pixels that see something to gather at, m².
    pub fn complete_first_radii(&self, radii: &mut [Option<f32>]) -> Vec<f32> {
        match self.first_radius {
            Auto::Auto => fill_gaps(radii, self.scene.width as usize, self.fallback_radius_squared()),
            Auto::Value(radius) => vec![radius * radius; radii.len()],
        }
    }

    /// Traces the path of a pixel in a pass and shows `gather` where it gathers; the radiance seen on the way.
    #[inline]
    pub fn camera_path(
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

    /// First radii where new camera paths of every pixel gather, m², and what that costs.
    pub fn pilot(&self, cancel: &AtomicBool) -> Option<(Vec<f32>, Counters)> {
        let (map, mut total) = self.pilot_map(cancel)?;
        let scene = &*self.scene;
        let random = PassRandom::of_pixels(self.seed, Stream::PilotCamera, PILOT_PASS);
        let found: Vec<(Option<f32>, Counters)> = (0..scene.pixel_count())
            .into_par_iter()
            .with_min_len(1024)
            .map(|pixel| {
                let mut counters = Counters::default();
                let random = random.path(pixel as u32);
                let mut last = None;
                self.camera_path(&random, pixel, &mut counters, |point, _, counters| {
                    // Direct light will cost its rays too.
                    counters.rays += 2;
                    last = Some(*point);
                });
                let radius = last.map(|point| self.first_radius_squared(&map, &point, point.path_length));
                (radius, counters)
            })
            .collect();
        found.iter().for_each(|(_, counters)| total += *counters);
        let mut radii: Vec<Option<f32>> = found.into_iter().map(|(radius, _)| radius).collect();
        let filled = self.complete_first_radii(&mut radii);
        (!cancel.load(Ordering::Relaxed)).then_some((filled, total))
    }

    /// Where the search for first radii starts.
    fn radius_bounds(&self, photons: usize) -> RadiusBounds {
        RadiusBounds::new(self.scene.geometry.bounding_sphere().1, photons)
    }

    /// A photon map for the pilot, with cells of the size that the search starts with.
    pub fn pilot_map(&self, cancel: &AtomicBool) -> Option<(PhotonMap, Counters)> {
        // Two or three photons are stored per emitted one in a closed room.
        let bounds = self.radius_bounds(2 * self.photons_per_pass as usize);
        self.photon_map(Stream::PilotPhoton, PILOT_PASS, bounds.guess, cancel)
    }

    /// R² for pixels that see nothing to gather at, m².
    fn fallback_radius_squared(&self) -> f32 {
        self.radius_bounds(self.photons_per_pass as usize).guess.max(f32::MIN_POSITIVE * FIRST_GATHER_PHOTONS)
    }
}

/// Adds one pass's sums of a pixel; what is not finite is dropped and counted.
#[inline]
pub fn add_to_tally(
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
