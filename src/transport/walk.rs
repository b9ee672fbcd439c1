//! A path on its way, from a light or from the camera: one state and one step for every method.
//!
//! [`Walk::step`] traces the next segment; media along it absorb, and may scatter. [`Walk::follow`] goes on from a surface,
//! [`Walk::pass`] through one that turns nothing, [`Walk::scattered`] from a place in a medium. Methods say what happens at the
//! vertices.

use super::Counters;
use super::limits::Limits;
use super::shading::Scattering;
use crate::math::random::{Numbers, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::light::{EmittedPhoton, Origin, Place};
use crate::scene::material::TransportMode;
use crate::scene::medium::{Flight, FlightNumbers};
use crate::scene::{MediumIndex, Scene};

/// Where a step ends: at a surface, in a medium, or outside of the scene.
pub struct Step {
    surface: Option<Interaction>,
    scattered: Option<Vec3>,
}

impl Step {
    /// The surface, if it is one.
    #[inline(always)]
    pub fn surface(&self) -> Option<&Interaction> {
        self.surface.as_ref()
    }

    /// The place, if it is one in a medium that scatters light; only in methods that render such media.
    #[inline(always)]
    pub fn medium(&self) -> Option<Vec3> {
        self.scattered
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
    /// Where the next segment of a camera path begins; the lens at first.
    pub place: Place,
    /// Nothing turned the camera path yet: a scene that hides its lights hides the environment from it.
    pub straight: bool,
    mode: TransportMode,
    /// Size of the throughput at first.
    begun_with: f32,
    /// Product of squared relative indices: undoes refraction's scaling of radiance when roulette judges a path.
    index_squared: f32,
}

impl Walk {
    /// A path that starts with a camera ray which counts `count`; that may be negative.
    #[inline(always)]
    pub fn from_camera(scene: &Scene, ray: Ray, count: f32) -> Self {
        Self::new(ray, scene.camera_medium, Rgb::splat(count), count.abs(), TransportMode::Radiance)
    }

    /// A camera path that came to `hit` with `throughput`, in `segments` through `medium`. [`Walk::follow`] lets it go on.
    #[inline(always)]
    pub fn from_surface(hit: &Interaction, throughput: Rgb, segments: u32, medium: MediumIndex) -> Self {
        let ray = hit.ray_to(hit.outgoing);
        let walk = Self::new(ray, medium, throughput, 1.0, TransportMode::Radiance);
        Self { segments, steps: segments, straight: false, ..walk }
    }

    /// A path that starts with a photon.
    #[inline(always)]
    pub fn from_light(scene: &Scene, emitted: &EmittedPhoton, random: &impl Numbers) -> Self {
        let ray = Ray::new(emitted.origin, emitted.direction);
        let mut walk = Self::new(ray, None, emitted.flux, emitted.flux.max_element(), TransportMode::Flux);
        if !scene.media.is_empty() {
            let arriving;
            (walk.medium, arriving) = enter_media(scene, emitted, random);
            walk.throughput *= arriving;
        }
        walk
    }

    #[inline(always)]
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

    /// Traces the next segment, of a path that has the numbers `random`.
    #[inline(always)]
    pub fn step(&mut self, scene: &Scene, random: &impl Numbers, counters: &mut Counters) -> Step {
        self.segments += 1;
        self.steps += 1;
        counters.rays += 1;
        let is_seen_first = self.mode == TransportMode::Radiance && self.steps == 1;
        // A copy: a walk whose parts are known elsewhere by address would not be kept in registers.
        let ray = self.ray;
        let mut step = Step {
            surface: if is_seen_first { scene.intersect_from_camera(&ray) } else { scene.intersect(&ray) },
            scattered: None,
        };
        if self.medium.is_some() {
            let length = step.surface().map_or(f32::INFINITY, |hit| hit.distance);
            let Flight { scattered, weight } = fly(scene, self.medium, Ray { length, ..self.ray }, self.steps, random);
            self.throughput *= weight;
            if let Some(distance) = scattered {
                step = Step { surface: None, scattered: Some(self.ray.at(distance)) };
            }
        }
        step
    }

    /// Radiance that arrives from a light at the end of the last step, which was a surface or outside of the scene, and the density
    /// by solid angle with which sampling the light from where the step began finds it. `is_seen`: nothing but specular surfaces lie
    /// between that end and the camera.
    #[inline(always)]
    pub fn arriving(&self, scene: &Scene, hit: Option<&Interaction>, is_seen: bool) -> Option<(Rgb, f32)> {
        let place = self.place;
        match hit {
            Some(hit) => scene.lights.emitted(&scene.geometry, &place, hit, is_seen),
            None if scene.hides_lights && self.straight => None,
            None => scene.lights.environment(&place, self.ray.direction),
        }
    }

    /// Goes on from a surface.
    #[inline(always)]
    pub fn follow(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.weigh(scattering);
        self.turn(scene, hit, scattering);
    }

    /// Goes on from a surface unless roulette with `u` ends the path: then false.
    #[inline(always)]
    pub fn follow_by_roulette(
        &mut self,
        scene: &Scene,
        hit: &Interaction,
        scattering: &Scattering,
        limits: &Limits,
        u: f32,
    ) -> bool {
        self.weigh(scattering);
        let survives = self.survives(limits, u);
        if survives {
            self.turn(scene, hit, scattering);
        }
        survives
    }

    /// Goes on straight through a surface that is no vertex.
    #[inline(always)]
    pub fn pass(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        self.segments -= 1;
        self.weigh(scattering);
        self.leave(scene, hit, scattering.direction);
    }

    #[inline(always)]
    fn weigh(&mut self, scattering: &Scattering) {
        self.throughput *= scattering.weight;
        if self.mode == TransportMode::Radiance {
            let index = scattering.sample.relative_index;
            self.index_squared *= index * index;
        }
    }

    #[inline(always)]
    fn turn(&mut self, scene: &Scene, hit: &Interaction, scattering: &Scattering) {
        if self.mode == TransportMode::Radiance {
            self.place = scene.place(hit);
            self.straight = self.straight && scattering.is_straight(hit);
        }
        self.leave(scene, hit, scattering.direction);
    }

    #[inline(always)]
    fn leave(&mut self, scene: &Scene, hit: &Interaction, direction: Vec3) {
        self.medium = scene.medium_beyond(hit, direction, self.medium);
        self.ray = hit.ray_to(direction);
    }

    /// The path that goes on from `position` in a medium in `direction`.
    #[must_use]
    pub fn scattered(self, position: Vec3, direction: Vec3) -> Self {
        Self { place: position.into(), straight: false, ray: Ray::new(position, direction), ..self }
    }

    /// Plays roulette with `u`; false ends the path.
    #[inline(always)]
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

// What scenes without media never call takes and gives values, for the same reason.

/// The medium that a photon begins in, and the share of it that gets there: light from outside has crossed the outermost one for ever.
#[cold]
#[inline(never)]
fn enter_media(scene: &Scene, emitted: &EmittedPhoton, random: &impl Numbers) -> (MediumIndex, Rgb) {
    let ray = Ray::new(emitted.origin, emitted.direction);
    let arriving = match (emitted.origin_kind, scene.medium(scene.outermost_medium)) {
        (Origin::Distant { .. }, Some(medium)) => medium.transmittance(&ray, || random.branch(dimension::flight(0))),
        _ => Rgb::ONE,
    };
    (scene.medium_along(&ray), arriving)
}

/// How far a ray gets within its length.
#[cold]
#[inline(never)]
fn fly(scene: &Scene, medium: MediumIndex, ray: Ray, step: u32, random: &impl Numbers) -> Flight {
    let numbers = || FlightNumbers {
        first: random.block(dimension::light(step))[3],
        more: random.branch(dimension::flight(step)),
    };
    match scene.medium(medium) {
        Some(medium) => medium.fly(&ray, numbers),
        None => Flight { scattered: None, weight: Rgb::ONE },
    }
}
