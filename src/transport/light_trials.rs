//! Trying lights where a method samples them: on camera paths as the method makes them.

use rayon::prelude::*;

use super::camera_walk::{CameraWalk, GatherPoint, trace_camera_path};
use super::visibility::{Blockers, Joint, SHADOW_END, transmittance};
use super::visibility_learning::LightTrial;
use super::walk::Walk;
use super::{Counters, Limits, shading};
use crate::math::Rgb;
use crate::math::color::luminance;
use crate::math::random::{PassRandom, PathRandom, Stream, dimension};
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::{Lobes, TransportMode, View};
use crate::scene::{MediumIndex, Scene};

/// Trials per round, about.
const TRIALS: usize = 1 << 14;
/// The most trials at a place.
const MOST_AT_A_PLACE: usize = 64;
/// Vertices of a path at which lights are tried, at most.
const MOST_VERTICES: u32 = 16;

/// The vertices of camera paths at which a method samples lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplingVertices {
    /// Where they gather: up to the first wide lobe.
    Gathering,
    /// All.
    All,
}

/// A trial and what it brought.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WeighedTrial {
    /// The trial.
    pub trial: LightTrial,
    /// The luminance of its estimate of direct light, W·sr⁻¹·m⁻².
    pub brought: f32,
    /// The probability with which the light was picked.
    pub pick: f32,
    /// The probability with which it would have been without any visibility.
    pub plain_pick: f32,
}

/// Where and how lights are tried.
#[derive(Clone, Copy)]
pub(crate) struct LightTrials<'a> {
    /// The scene, with picks that know nothing of visibility.
    pub plain: &'a Scene,
    /// The same, with what was learnt so far.
    pub scene: &'a Scene,
    /// The method's limits on paths.
    pub limits: Limits,
    /// Where it samples lights.
    pub vertices: SamplingVertices,
    /// Job seed.
    pub seed: u64,
}

/// A vertex at which lights are tried.
struct TrialVertex<'a> {
    hit: &'a Interaction,
    view: View,
    medium: MediumIndex,
    throughput: Rgb,
    step: u32,
}

impl LightTrials<'_> {
    /// One round of trials, in the order of pixels.
    pub(crate) fn round(&self, round: u32) -> Vec<WeighedTrial> {
        let count = self.scene.pixel_count();
        let step = count.div_ceil(TRIALS);
        let random = PassRandom::of_pixels(self.seed, Stream::Visibility, round);
        let pixels: Vec<usize> = (0..count).step_by(step).collect();
        let at_a_place = (TRIALS / pixels.len()).clamp(1, MOST_AT_A_PLACE);
        let of_pixel = |pixel: &usize| {
            let mut trials = Vec::new();
            self.path(*pixel, &random.path(*pixel as u32), &mut |vertex, random| {
                trials.extend((0..at_a_place).filter_map(|index| self.trial(vertex, &random.branch(index as u32))));
            });
            trials
        };
        pixels.par_iter().flat_map_iter(of_pixel).collect()
    }

    /// Shows the vertices of a pixel's path.
    fn path(&self, pixel: usize, random: &PathRandom, visit: &mut dyn FnMut(&TrialVertex<'_>, &PathRandom)) {
        let scene = self.scene;
        let place = [pixel as u32 % scene.width, pixel as u32 / scene.width];
        let ray = scene.camera_ray(place, random.block(dimension::CAMERA));
        match self.vertices {
            SamplingVertices::Gathering => {
                let walk = CameraWalk::new(scene, ray, true);
                let (mut unused, mut counters) = (Rgb::ZERO, Counters::default());
                let gather = |point: &GatherPoint, _: &mut Rgb, _: &mut Counters| {
                    let GatherPoint { hit, medium, throughput, segments: step, .. } = *point;
                    visit(&TrialVertex { hit: &hit, view: point.view(), medium, throughput, step }, random);
                };
                trace_camera_path(scene, walk, random, &self.limits, &mut unused, &mut counters, gather);
            }
            SamplingVertices::All => self.whole_path(Walk::from_camera(scene, ray, 1.0), random, visit),
        }
    }

    fn whole_path(&self, mut walk: Walk, random: &PathRandom, visit: &mut dyn FnMut(&TrialVertex<'_>, &PathRandom)) {
        let (scene, mut counters) = (self.scene, Counters::default());
        while self.limits.allows(walk.segments + 2) && walk.steps < MOST_VERTICES {
            let step = walk.step(scene, random, &mut counters);
            let Some(hit) = step.surface() else { return };
            let material = scene.material(hit.shape);
            let view = shading::view(hit, TransportMode::Radiance);
            if scene.lobes_at(hit.shape).any(Lobes::SMOOTH) {
                let Walk { medium, throughput, steps: step, .. } = walk;
                visit(&TrialVertex { hit, view, medium, throughput, step }, random);
            }
            let u = random.block(dimension::scattering(walk.steps));
            let Some(scattering) = shading::scatter(hit, material, &view, [u[0], u[1], u[2]]) else { return };
            if !walk.follow_by_roulette(scene, hit, &scattering, &self.limits, u[3]) {
                return;
            }
        }
    }

    /// Tries a light; `None` where no light is picked, or the surface reflects none of it.
    fn trial(&self, vertex: &TrialVertex<'_>, random: &PathRandom) -> Option<WeighedTrial> {
        let (scene, TrialVertex { hit, view, .. }) = (self.scene, vertex);
        let place = scene.place(hit);
        let u = random.block(dimension::light(vertex.step));
        let (light, pick) = scene.lights.pick(&place, u[2])?;
        let sample = scene.lights.lights()[light].sample_direct(&scene.geometry, place.position, [u[0], u[1]])?;
        let incident = hit.frame.to_local(sample.direction);
        let reflected = scene.material(hit.shape).evaluate(view, incident) * incident.z.abs();
        let leaks = sample.direction.dot(hit.geometric_normal) * incident.z <= 0.0;
        if leaks || reflected == Rgb::ZERO {
            return None;
        }
        let (origin, length) = (hit.offset_towards(sample.direction), sample.distance * SHADOW_END);
        let joint = Joint {
            ray: Ray { origin, direction: sample.direction, length },
            medium: scene.medium_beyond(hit, sample.direction, vertex.medium),
            blockers: if scene.media.is_empty() { Blockers::All } else { Blockers::Turning },
            random,
            step: vertex.step,
        };
        let arriving = sample.weighted_radiance * transmittance(scene, &joint, &mut Counters::default());
        let brought = luminance(vertex.throughput * reflected * arriving) / pick;
        let trial = LightTrial { position: place.position, light: light as u32, arrives: arriving != Rgb::ZERO };
        let plain_pick = self.plain.lights.probability(&place, light);
        brought.is_finite().then_some(WeighedTrial { trial, brought, pick, plain_pick })
    }
}
