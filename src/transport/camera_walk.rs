//! Camera paths: from the lens through specular and glossy surfaces to the first wide lobe, where they gather and end.
//!
//! A path gathers at every vertex with a lobe that has a density. At a wide lobe it gathers all photons and ends. At a
//! narrow one few photons would count: it goes on there and finds scattered light further away, and gathers only what it
//! cannot find so, caustics. Light from a source to a narrow lobe is shared between light sampling and the path that goes
//! on, by multiple importance sampling; sources seen further on through specular surfaces are left to caustic photons.

use crate::math::random::{PathRandom, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::light::Place;
use crate::scene::material::{Lobes, TransportMode, View};

use super::counters::Counters;
use super::limits::Limits;
use super::multiple_importance::power_heuristic;
use super::shading::{self, Scattering};

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
    /// The lobes that are gathered in.
    pub lobes: Lobes,
    /// The path goes on in the same lobes: only caustics are gathered.
    pub goes_on: bool,
}

impl GatherPoint {
    /// The true normal on the side from which the camera sees the surface.
    #[inline]
    pub fn facing_normal(&self) -> Vec3 {
        let normal = self.hit.geometric_normal;
        if self.hit.outgoing.dot(normal) < 0.0 { -normal } else { normal }
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
pub struct CameraWalk {
    /// The next segment.
    pub ray: Ray,
    /// Where the next segment begins.
    place: Place,
    /// What radiance from the next vertex is multiplied with.
    pub throughput: Rgb,
    /// Segments before the next one.
    pub segments: u32,
    /// Length so far, m.
    pub path_length: f32,
    /// Product of squared relative indices: undoes refraction's scaling of radiance when roulette judges a path.
    index_squared: f32,
    emission: SeenEmission,
    /// Nothing turned the path yet: a scene that hides its lights hides the environment from it.
    straight: bool,
    /// Whether lights are sampled at gather points; else photons bring their light.
    samples_lights: bool,
}

impl CameraWalk {
    /// A path that starts with a camera ray.
    pub fn new(ray: Ray, samples_lights: bool) -> Self {
        Self {
            ray,
            place: ray.origin.into(),
            throughput: Rgb::ONE,
            segments: 0,
            path_length: 0.0,
            index_squared: 1.0,
            emission: SeenEmission::Full,
            straight: true,
            samples_lights,
        }
    }

    /// A path that leaves `point` by `scattering` to gather indirect light there. Emission that it sees before a lobe
    /// with a density scatters it again is direct light at `point`, or a caustic: it does not count.
    pub fn gathering(point: &GatherPoint, scattering: &Scattering) -> Self {
        Self {
            ray: point.hit.ray_to(scattering.direction),
            // Nothing that the segment meets is shared with light sampling.
            place: point.hit.position.into(),
            throughput: point.throughput * scattering.weight,
            segments: point.segments,
            path_length: point.path_length,
            index_squared: scattering.sample.relative_index * scattering.sample.relative_index,
            emission: SeenEmission::ByPhotons,
            straight: false,
            samples_lights: true,
        }
    }

    /// Traces the next segment; emission that it sees is added to `radiance`. `None` when the path left the scene.
    #[inline]
    pub fn advance(
        &mut self,
        scene: &Scene,
        limits: &Limits,
        radiance: &mut Rgb,
        counters: &mut Counters,
    ) -> Option<GatherPoint> {
        if !limits.allows(self.segments + 1) {
            return None;
        }
        self.segments += 1;
        counters.rays += 1;
        let is_first = self.segments == 1;
        let found = if is_first { scene.intersect_from_camera(&self.ray) } else { scene.intersect(&self.ray) };
        let emitted = match &found {
            Some(hit) => scene.lights.emitted(&scene.geometry, &self.place, hit, self.is_seen()),
            None if scene.hides_lights && self.straight => None,
            None => scene.lights.environment(&self.place, self.ray.direction),
        };
        if let Some((emitted, light_pdf)) = emitted {
            *radiance += self.throughput * emitted * self.emission_share(light_pdf);
        }
        let hit = found?;
        self.path_length += hit.distance;
        let Self { throughput, segments, path_length, .. } = *self;
        Some(GatherPoint { hit, throughput, segments, path_length, lobes: Lobes::ALL, goes_on: false })
    }

    /// Whether nothing but specular surfaces lie between the next vertex and the camera.
    fn is_seen(&self) -> bool {
        matches!(self.emission, SeenEmission::Full)
    }

    fn emission_share(&self, light_pdf: f32) -> f32 {
        match self.emission {
            SeenEmission::Full => 1.0,
            SeenEmission::Shared(pdf) => power_heuristic(pdf, light_pdf),
            SeenEmission::ByPhotons => 0.0,
        }
    }

    /// Goes on after a scattering.
    #[inline]
    pub fn follow(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.place = scene.place(hit);
        self.throughput *= scattering.weight;
        let index = scattering.sample.relative_index;
        self.index_squared *= index * index;
        self.ray = hit.ray_to(scattering.direction);
        self.straight = self.straight && scattering.is_straight(hit);
        self.emission = match self.emission {
            _ if !scattering.sample.is_specular() && self.samples_lights => SeenEmission::Shared(scattering.sample.pdf),
            SeenEmission::Full if scattering.sample.is_specular() => SeenEmission::Full,
            _ => SeenEmission::ByPhotons,
        };
    }

    /// Plays roulette with `u`; false ends the path.
    #[inline]
    pub fn survives(&mut self, limits: &Limits, u: f32) -> bool {
        let kept = self.throughput.max_element() * self.index_squared;
        let survival = limits.survival(self.segments, kept);
        if u >= survival {
            return false;
        }
        self.throughput /= survival;
        true
    }
}

impl GatherPoint {
    /// Decides whether the path ends here or goes on, and keeps the lobes that this leaves.
    #[inline]
    fn choose(&mut self, scene: &Scene, random: &PathRandom) {
        let share = scene.material(self.hit.shape).followed_share(&self.view());
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
pub fn trace_camera_path(
    scene: &Scene,
    mut walk: CameraWalk,
    random: &PathRandom,
    limits: &Limits,
    radiance: &mut Rgb,
    counters: &mut Counters,
    mut gather: impl FnMut(&GatherPoint, &mut Rgb, &mut Counters),
) {
    while let Some(mut point) = walk.advance(scene, limits, radiance, counters) {
        point.choose(scene, random);
        let material = scene.material(point.hit.shape);
        if !point.goes_on || material.lobes().any(Lobes::NARROW) {
            gather(&point, radiance, counters);
        }
        if !point.goes_on {
            return;
        }
        walk.throughput = point.throughput;
        let u = random.block(dimension::scattering(walk.segments));
        let Some(scattering) = shading::scatter(&point.hit, material, &point.view(), [u[0], u[1], u[2]]) else {
            return;
        };
        walk.follow(scene, &point.hit, &scattering);
        if !walk.survives(limits, u[3]) {
            return;
        }
    }
}
