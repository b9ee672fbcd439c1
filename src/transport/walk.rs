//! A path on its way, from a light or from the camera: one state and one step for every method.
//!
//! [`Walk::step`] traces the next segment; media along it absorb, and may scatter. [`Walk::follow`] goes on from a surface,
//! [`Walk::pass`] through one that turns nothing, [`Walk::scatter`] from a place in a medium. Methods say what happens at the
//! vertices.

use super::Counters;
use super::limits::Limits;
use super::shading::Scattering;
use crate::math::random::{PathRandom, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::light::{EmittedPhoton, Origin, Place};
use crate::scene::material::TransportMode;
use crate::scene::medium::{Flight, FlightNumbers};
use crate::scene::{MediumIndex, Scene};

/// Where a step ends.
pub enum Step {
    /// At a surface.
    Surface(Interaction),
    /// At a place in a medium that scatters light; only in methods that render such media.
    Medium(Vec3),
    /// Nowhere: the path left the scene.
    Escaped,
}

impl Step {
    /// The surface, if it is one.
    #[inline(always)]
    pub fn surface(self) -> Option<Interaction> {
        match self {
            Self::Surface(hit) => Some(hit),
            Self::Medium(_) | Self::Escaped => None,
        }
    }
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// The next segment.
    pub ray: Ray,
    /// The medium that it crosses.
    pub medium: MediumIndex,
    /// What it carries: flux of photons, W; else what radiance from the next vertex is multiplied with.
    pub throughput: Rgb,
    /// Segments so far.
    pub segments: u32,
    /// Steps so far, which address random numbers: as many as segments, and one more for each surface that was passed.
    pub steps: u32,
    /// Where the next segment begins; the lens at first.
    pub place: Place,
    /// Nothing turned the path yet: a scene that hides its lights hides the environment from it.
    pub straight: bool,
    mode: TransportMode,
    /// Size of the throughput at first.
    begun_with: f32,
    /// Product of squared relative indices: undoes refraction's scaling of radiance when roulette judges a path.
    index_squared: f32,
}

impl Walk {
    /// A path that starts with a camera ray which counts `count`; that may be negative.
    #[inline]
    pub fn from_camera(scene: &Scene, ray: Ray, count: f32) -> Self {
        Self::new(ray, scene.camera_medium, Rgb::splat(count), count.abs(), TransportMode::Radiance)
    }

    /// A camera path that came to `hit` with `throughput`, in `segments` through `medium`. [`Walk::follow`] lets it go on.
    #[inline]
    pub fn from_surface(hit: &Interaction, throughput: Rgb, segments: u32, medium: MediumIndex) -> Self {
        let ray = hit.ray_to(hit.outgoing);
        let walk = Self::new(ray, medium, throughput, 1.0, TransportMode::Radiance);
        Self { segments, steps: segments, straight: false, ..walk }
    }

    /// A path that starts with a photon; `None` where that carries nothing, or nothing finite, which is counted.
    #[inline]
    pub fn from_light(
        scene: &Scene,
        emitted: &EmittedPhoton,
        random: &PathRandom,
        counters: &mut Counters,
    ) -> Option<Self> {
        let peak = emitted.flux.max_element();
        if !(peak > 0.0 && peak.is_finite()) {
            counters.non_finite += u64::from(!peak.is_finite());
            return None;
        }
        let ray = Ray::new(emitted.origin, emitted.direction);
        let mut walk = Self::new(ray, None, emitted.flux, peak, TransportMode::Flux);
        if !scene.media.is_empty() {
            walk.enter_media(scene, emitted, random);
        }
        Some(walk)
    }

    #[inline]
    fn new(ray: Ray, medium: MediumIndex, throughput: Rgb, begun_with: f32, mode: TransportMode) -> Self {
        Self {
            ray,
            medium,
            throughput,
            segments: 0,
            steps: 0,
            place: ray.origin.into(),
            straight: true,
            mode,
            begun_with,
            index_squared: 1.0,
        }
    }

    /// Finds the medium that a photon begins in. Light that comes from outside has crossed the outermost one for ever.
    #[cold]
    fn enter_media(&mut self, scene: &Scene, emitted: &EmittedPhoton, random: &PathRandom) {
        self.medium = scene.medium_along(&self.ray);
        let outside = scene.medium(scene.outermost_medium);
        if let (Origin::Distant { .. }, Some(medium)) = (emitted.origin_kind, outside) {
            self.throughput *= medium.transmittance(&self.ray, || random.branch(dimension::flight(0)));
        }
    }

    /// Traces the next segment, of a path that has the numbers `random`.
    #[inline(always)]
    pub fn step(&mut self, scene: &Scene, random: &PathRandom, counters: &mut Counters) -> Step {
        self.segments += 1;
        self.steps += 1;
        counters.rays += 1;
        let is_seen_first = self.mode == TransportMode::Radiance && self.steps == 1;
        let found = if is_seen_first { scene.intersect_from_camera(&self.ray) } else { scene.intersect(&self.ray) };
        if self.medium.is_some() {
            let length = found.as_ref().map_or(f32::INFINITY, |hit| hit.distance);
            if let Some(scattered) = self.cross(scene, length, random) {
                return Step::Medium(scattered);
            }
        }
        found.map_or(Step::Escaped, Step::Surface)
    }

    /// Goes through the medium for `length`, m; the place where it scatters the path, if it does.
    #[cold]
    #[inline(never)]
    fn cross(&mut self, scene: &Scene, length: f32, random: &PathRandom) -> Option<Vec3> {
        let medium = scene.medium(self.medium)?;
        let numbers = || FlightNumbers {
            first: random.block(dimension::light(self.steps))[3],
            more: random.branch(dimension::flight(self.steps)),
        };
        let Flight { scattered, weight } = medium.fly(&Ray { length, ..self.ray }, numbers);
        self.throughput *= weight;
        scattered.map(|distance| self.ray.at(distance))
    }

    /// Radiance that arrives from a light at the end of the last step, which was a surface or outside of the scene, and the density
    /// by solid angle with which sampling the light from where the step began finds it. `is_seen`: nothing but specular surfaces lie
    /// between that end and the camera.
    #[inline]
    pub fn arriving(&self, scene: &Scene, hit: Option<&Interaction>, is_seen: bool) -> Option<(Rgb, f32)> {
        match hit {
            Some(hit) => scene.lights.emitted(&scene.geometry, &self.place, hit, is_seen),
            None if scene.hides_lights && self.straight => None,
            None => scene.lights.environment(&self.place, self.ray.direction),
        }
    }

    /// Goes on from a surface.
    #[inline]
    pub fn follow(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.place = scene.place(hit);
        self.straight = self.straight && scattering.is_straight(hit);
        self.leave(scene, hit, scattering);
    }

    /// Goes on straight through a surface that is no vertex.
    #[inline]
    pub fn pass(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.segments -= 1;
        self.leave(scene, hit, scattering);
    }

    #[inline]
    fn leave(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.throughput *= scattering.weight;
        if self.mode == TransportMode::Radiance {
            let index = scattering.sample.relative_index;
            self.index_squared *= index * index;
        }
        self.medium = scene.medium_beyond(hit, scattering.direction, self.medium);
        self.ray = hit.ray_to(scattering.direction);
    }

    /// Goes on from `position` in a medium in `direction`.
    #[inline]
    pub fn scatter(&mut self, position: Vec3, direction: Vec3) {
        self.place = position.into();
        self.straight = false;
        self.ray = Ray::new(position, direction);
    }

    /// Plays roulette with `u`; false ends the path.
    #[inline]
    pub fn survives(&mut self, limits: &Limits, u: f32) -> bool {
        let kept = self.throughput.abs().max_element() / self.begun_with * self.index_squared;
        let survival = limits.survival(self.segments, kept);
        if u >= survival {
            return false;
        }
        self.throughput /= survival;
        true
    }
}
