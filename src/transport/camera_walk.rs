//! Camera paths: from the lens through specular and glossy surfaces to the first wide lobe, where they gather and end.
//!
//! A path gathers at every vertex with a lobe that has a density. At a wide lobe it gathers all photons and ends. At a
//! narrow one few photons would count: it goes on there and finds scattered light further away, and gathers only what it
//! cannot find so, caustics. Light from a source to a narrow lobe is shared between light sampling and the path that goes
//! on, by multiple importance sampling; sources seen further on through specular surfaces are left to caustic photons.

use crate::math::random::{PathRandom, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::{Lobes, TransportMode, View};
use crate::scene::{MediumIndex, Scene};

use super::counters::Counters;
use super::limits::Limits;
use super::multiple_importance::power_heuristic;
use super::shading::{self, Scattering};
use super::walk::Walk;

/// Where a camera path meets a surface, and the lobes in which it gathers there.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    /// The surface.
    pub hit: Interaction,
    /// What radiance from here is multiplied with on its way to the camera.
    pub throughput: Rgb,
    /// Segments from the camera to here.
    pub segments: u32,
    /// Length of the path from the camera to here, m.
    pub path_length: f32,
    /// The medium that it came through.
    pub medium: MediumIndex,
    /// The lobes that are gathered in.
    pub lobes: Lobes,
    /// The path goes on in the same lobes: only caustics are gathered.
    pub goes_on: bool,
}

impl GatherPoint {
    /// The true normal on the side from which the camera sees the surface.
    #[inline]
    pub fn facing_normal(&self) -> Vec3 {
        shading::facing_normal(&self.hit)
    }

    /// The surface as the path sees it.
    #[inline]
    pub fn view(&self) -> View {
        shading::view(&self.hit, TransportMode::Radiance).of(self.lobes)
    }
}

/// How emission counts that the next segment meets.
#[derive(Clone, Copy, Debug)]
enum SeenEmission {
    /// In full: nothing but specular surfaces lie between here and the camera.
    Full,
    /// Shared with light sampling at the last vertex, whose lobe has this density by solid angle.
    Shared(f32),
    /// Not at all: caustic photons bring it.
    ByPhotons,
}

/// A camera path on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraWalk {
    /// Where it is, and what it carries.
    pub walk: Walk,
    /// Length so far, m.
    path_length: f32,
    emission: SeenEmission,
    /// Whether lights are sampled at gather points; else photons bring their light.
    samples_lights: bool,
}

impl CameraWalk {
    /// A path that starts with a camera ray.
    pub(crate) fn new(scene: &Scene, ray: Ray, samples_lights: bool) -> Self {
        let walk = Walk::from_camera(scene, ray, 1.0);
        Self { walk, path_length: 0.0, emission: SeenEmission::Full, samples_lights }
    }

    /// A path that leaves `point` by `scattering` to gather indirect light there. Emission that it sees before a lobe
    /// with a density scatters it again is direct light at `point`, or a caustic: it does not count.
    pub(crate) fn gathering(scene: &Scene, point: &GatherPoint, scattering: &Scattering) -> Self {
        let mut walk = Walk::from_surface(&point.hit, point.throughput, point.segments, point.medium);
        walk.follow(scene, &point.hit, scattering);
        Self { walk, path_length: point.path_length, emission: SeenEmission::ByPhotons, samples_lights: true }
    }

    /// Traces the next segment of a path with the numbers `random`; emission that it sees is added to `radiance`. `None` when the
    /// path left the scene.
    #[inline]
    pub(crate) fn advance(
        &mut self,
        scene: &Scene,
        random: &PathRandom,
        limits: &Limits,
        radiance: &mut Rgb,
        counters: &mut Counters,
    ) -> Option<GatherPoint> {
        let walk = &mut self.walk;
        if !limits.allows(walk.segments + 1) {
            return None;
        }
        let step = walk.step(scene, random, counters);
        let found = step.surface();
        let is_seen = matches!(self.emission, SeenEmission::Full);
        if let Some((emitted, light_pdf)) = walk.arriving(scene, found, is_seen) {
            let share = match self.emission {
                SeenEmission::Full => 1.0,
                SeenEmission::Shared(pdf) => power_heuristic(pdf, light_pdf),
                SeenEmission::ByPhotons => 0.0,
            };
            *radiance += walk.throughput * emitted * share;
        }
        let hit = *found?;
        self.path_length += hit.distance;
        let Walk { throughput, segments, medium, .. } = *walk;
        let path_length = self.path_length;
        Some(GatherPoint { hit, throughput, segments, path_length, medium, lobes: Lobes::ALL, goes_on: false })
    }

    /// Goes on after a scattering.
    #[inline]
    pub(crate) fn follow(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.walk.follow(scene, hit, scattering);
        self.emission = match self.emission {
            _ if !scattering.sample.is_specular() && self.samples_lights => SeenEmission::Shared(scattering.sample.pdf),
            SeenEmission::Full if scattering.sample.is_specular() => SeenEmission::Full,
            _ => SeenEmission::ByPhotons,
        };
    }
}

impl GatherPoint {
    /// Decides whether the path ends here or goes on, and keeps the lobes that this leaves.
    #[inline]
    fn choose(&mut self, scene: &Scene, random: &PathRandom) {
        let may_follow = scene.lobes_at(self.hit.shape).any(Lobes::FOLLOWED);
        let share = if may_follow { scene.material(self.hit.shape).followed_share(&self.view()) } else { 0.0 };
        self.goes_on = match share {
            0.0 => false,
            1.0 => true,
            share => random.block(dimension::light(self.segments))[3] < share,
        };
        self.throughput /= if self.goes_on { share } else { 1.0 - share };
        self.lobes = if self.goes_on { Lobes::FOLLOWED } else { Lobes::WIDE };
    }
}

/// Follows a path to its end, one random lobe at each surface where it goes on; adds emission seen on the way and shows
/// every point where the path gathers to `gather`, the widest last.
#[inline]
pub(crate) fn trace_camera_path(
    scene: &Scene,
    mut walk: CameraWalk,
    random: &PathRandom,
    limits: &Limits,
    radiance: &mut Rgb,
    counters: &mut Counters,
    mut gather: impl FnMut(&GatherPoint, &mut Rgb, &mut Counters),
) {
    while let Some(mut point) = walk.advance(scene, random, limits, radiance, counters) {
        point.choose(scene, random);
        if !point.goes_on || scene.lobes_at(point.hit.shape).any(Lobes::NARROW) {
            gather(&point, radiance, counters);
        }
        if !point.goes_on {
            return;
        }
        walk.walk.throughput = point.throughput;
        let material = scene.material(point.hit.shape);
        let u = random.block(dimension::scattering(point.segments));
        let Some(scattering) = shading::scatter(&point.hit, material, &point.view(), [u[0], u[1], u[2]]) else {
            return;
        };
        walk.follow(scene, &point.hit, &scattering);
        if !walk.walk.survives(limits, u[3]) {
            return;
        }
    }
}
