//! The second pass of `photon_map`: what each camera path sees by the photons of the first.

use super::TwoPasses;
use super::direct_light::DirectRow;
use super::first_pass::Maps;
use super::irradiance_cache::PassCache;
use super::look_up::LookUp;
use super::second_pass::Seen;
use crate::math::Rgb;
use crate::math::random::{PathRandom, dimension, spread};
use crate::transport::Counters;
use crate::transport::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use crate::transport::irradiance::Arrival;
use crate::transport::photon_map::{LightLookup, Nearest, OriginLookup};
use crate::transport::shading::{self, Scattering};

/// What a thread needs to look at pixels.
pub(super) struct LocalPass<'a, P, D> {
    pub(super) method: &'a TwoPasses,
    maps: &'a Maps<Vec<P>>,
    direct: DirectRow<'a, D>,
    /// Irradiance on matte surfaces, if it is cached.
    cache: Option<&'a PassCache>,
    found: Nearest,
}

impl<'a, P: OriginLookup, D: LightLookup> LocalPass<'a, P, D> {
    /// For a row of pixels.
    pub(super) fn new(method: &'a TwoPasses, seen: &'a Seen<P, D>, cache: Option<&'a PassCache>) -> Self {
        let Seen { maps, direct } = seen;
        Self { method, maps, direct: DirectRow::new(method, direct), cache, found: Nearest::default() }
    }

    /// Radiance that a camera path sees.
    pub(super) fn pixel(&mut self, pixel: [u32; 2], random: &PathRandom, counters: &mut Counters) -> Rgb {
        let TwoPasses { scene, limits, .. } = self.method;
        let ray = scene.camera_ray(pixel, random.block(dimension::CAMERA));
        let mut seen = Rgb::ZERO;
        trace_camera_path(
            scene,
            CameraWalk::new(scene, ray, true),
            random,
            limits,
            &mut seen,
            counters,
            |at, seen, counters| {
                *seen += self.direct_and_caustic(at, random, counters);
                if !at.goes_on {
                    *seen += self.indirect(at, random, counters);
                }
            },
        );
        seen
    }

    /// Direct light and caustics at a point, as the camera sees them.
    fn direct_and_caustic(&mut self, at: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
        let TwoPasses { limits, caustic, .. } = self.method;
        let mut reflected = self.look_up(caustic, &self.maps.caustic, at, counters);
        if limits.allows(at.segments + 1) {
            reflected += self.direct.reflected(at, random, counters);
        }
        at.throughput * reflected
    }

    /// Soft indirect light at a wide lobe, as the camera sees it.
    fn indirect(&mut self, at: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
        let rays = self.method.parameters.final_gather.get();
        if rays == 0 {
            return at.throughput * self.look_up(&self.method.global, &self.maps.global, at, counters);
        }
        if let Some(reflected) = self.cache.and_then(|cache| cache.reflected(self.method, at)) {
            return at.throughput * reflected;
        }
        let [shift_x, shift_y, ..] = random.block(dimension::scattering(at.segments));
        let sum: Rgb = (0..rays)
            .map(|ray| {
                let random = random.branch(ray);
                let [_, _, lobe, roulette] = random.block(dimension::scattering(at.segments));
                let [x, y] = spread([shift_x, shift_y], ray, rays);
                self.gather_ray(at, [x, y, lobe, roulette], &random, counters)
            })
            .sum();
        sum / rays as f32
    }

    /// Indirect light along one ray that is sampled at `from` with `u`, as the camera sees it.
    fn gather_ray(&mut self, from: &GatherPoint, u: [f32; 4], random: &PathRandom, counters: &mut Counters) -> Rgb {
        let scene = &self.method.scene;
        let material = scene.material(from.hit.shape);
        match shading::scatter(&from.hit, material, &from.view(), [u[0], u[1], u[2]]) {
            Some(scattering) => self.gather_along(from, &scattering, u[3], random, counters).radiance,
            None => Rgb::ZERO,
        }
    }

    /// Indirect light along the ray that leaves `from` by `scattering` unless roulette with `u` ends it, as the camera sees it, and
    /// the length of the path to the first surface that gathers.
    pub(super) fn gather_along(
        &mut self,
        from: &GatherPoint,
        scattering: &Scattering,
        u: f32,
        random: &PathRandom,
        counters: &mut Counters,
    ) -> Arrival {
        let TwoPasses { scene, limits, global, .. } = self.method;
        let mut walk = CameraWalk::gathering(scene, from, scattering);
        if !walk.walk.survives(limits, u) {
            return Arrival::NOTHING;
        }
        let (mut seen, mut distance) = (Rgb::ZERO, f32::INFINITY);
        trace_camera_path(scene, walk, random, limits, &mut seen, counters, |at, seen, counters| {
            distance = distance.min(at.path_length - from.path_length);
            let is_near = at.hit.position.distance_squared(from.hit.position) < global.estimate.largest_radius_squared;
            if at.goes_on || is_near {
                *seen += self.direct_and_caustic(at, random, counters);
            }
            if !at.goes_on {
                *seen += match is_near {
                    true => {
                        let u = random.block(dimension::scattering(at.segments));
                        self.gather_ray(at, u, random, counters)
                    }
                    false => at.throughput * self.look_up(global, &self.maps.global, at, counters),
                };
            }
        });
        Arrival { radiance: seen, distance }
    }

    /// Radiance that the point's lobes reflect of the photons in `maps`: the mean of what each map estimates, weighted by its photons.
    fn look_up(&mut self, look_up: &LookUp, maps: &[P], at: &GatherPoint, counters: &mut Counters) -> Rgb {
        let TwoPasses { scene, limits, photons_per_pass, .. } = self.method;
        let most_segments = limits.most_photon_segments(at.segments);
        let mut sum = Rgb::ZERO;
        for map in maps.iter().filter(|map| !map.is_empty()) {
            sum += look_up.estimate.reflected(scene, map, at, most_segments, &mut self.found, counters);
        }
        sum / *photons_per_pass as f32
    }
}
