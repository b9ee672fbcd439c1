//! The second pass of `photon_map`: what each camera path sees by the photons of the first.

use super::TwoPasses;
use super::direct_light::DirectRow;
use super::first_pass::Maps;
use super::look_up::LookUp;
use crate::math::Rgb;
use crate::math::random::{PathRandom, dimension, spread};
use crate::transport::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use crate::transport::photon_map::{LightLookup, Nearest, OriginLookup};
use crate::transport::{Counters, shading};

/// What a thread needs to look at pixels.
pub(super) struct LocalPass<'a, P, D> {
    pub(super) method: &'a TwoPasses,
    pub(super) maps: &'a Maps<Vec<P>>,
    pub(super) direct: DirectRow<'a, D>,
    pub(super) found: Nearest,
}

impl<P: OriginLookup, D: LightLookup> LocalPass<'_, P, D> {
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
        let TwoPasses { scene, limits, global, .. } = self.method;
        let material = scene.material(from.hit.shape);
        let Some(scattering) = shading::scatter(&from.hit, material, &from.view(), [u[0], u[1], u[2]]) else {
            return Rgb::ZERO;
        };
        let mut walk = CameraWalk::gathering(scene, from, &scattering);
        if !walk.walk.survives(limits, u[3]) {
            return Rgb::ZERO;
        }
        let mut seen = Rgb::ZERO;
        trace_camera_path(scene, walk, random, limits, &mut seen, counters, |at, seen, counters| {
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
        seen
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
