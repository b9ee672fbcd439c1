//! Camera subpaths in scenes with participating media, for methods that make nothing but those: free flights between surfaces and
//! places in a medium, at each of which a point of a light is sampled too.
//!
//! Surfaces that a path passes straight on (`null`, panes, holes of masks) are no vertices: light is sampled through them, with what
//! they and the media let pass, and they add no segment.

use super::camera_walk::CameraWalk;
use super::vertex::Vertex;
use super::weights::{Densities, Sums, Techniques};
use crate::math::random::{PathRandom, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::light::{DirectSample, Place};
use crate::scene::material::{Lobes, TransportMode};
use crate::scene::medium::Flight;
use crate::scene::{MediumIndex, Scene};
use crate::transport::direct_light::SHADOW_END;
use crate::transport::{Counters, shading};

/// The most flights of a path, and the most surfaces that light is sampled through: what is left is lost in rounding.
const MOST_FLIGHTS: u32 = 4096;
const MOST_PANES: u32 = 64;

/// A path on its way.
struct Path {
    ray: Ray,
    medium: MediumIndex,
    throughput: Rgb,
    /// Segments with the one that begins.
    segments: u32,
    /// Product of squared relative indices.
    index_squared: f32,
    /// Where it was scattered last.
    place: Place,
    /// The density of that by solid angle; 0 for the camera and specular lobes.
    pdf: f32,
    /// Nothing turned it yet.
    straight: bool,
    /// Whether all scattering was specular.
    is_seen: bool,
}

/// Light that is sampled, in the middle of a path.
struct Sampled<'a> {
    light: &'a DirectSample,
    origin: Vec3,
    medium: MediumIndex,
    /// BSDF or phase function with the cosine.
    value: Rgb,
    /// The density of the direction by the scattering.
    pdf: f32,
}

impl CameraWalk<'_> {
    /// The radiance that the camera subpath of `pixel` finds.
    pub fn trace_in_media(&self, pixel: u32, counters: &mut Counters) -> Rgb {
        let scene = self.scene;
        let random = self.random.path(pixel);
        let place = [pixel % scene.width, pixel / scene.width];
        let (ray, count) = scene.filtered_camera_ray(place, random.block(dimension::CAMERA));
        let mut path = Path {
            ray,
            medium: scene.camera_medium,
            throughput: Rgb::splat(count),
            segments: 1,
            index_squared: 1.0,
            place: ray.origin.into(),
            pdf: 0.0,
            straight: true,
            is_seen: true,
        };
        let mut radiance = Rgb::ZERO;
        for flight in 1..MOST_FLIGHTS {
            if !self.limits.allows(path.segments) || path.throughput == Rgb::ZERO {
                break;
            }
            let before = path.segments;
            if !self.fly(&mut path, flight, &random, &mut radiance, counters) {
                break;
            }
            if path.segments > before {
                let kept = path.throughput.abs().max_element() / count.abs() * path.index_squared;
                let survival = self.limits.survival(before, kept);
                if random.block(dimension::scattering(flight))[3] >= survival {
                    break;
                }
                path.throughput /= survival;
            }
        }
        radiance
    }

    /// One flight, and the scattering at its end; false where the path ends.
    fn fly(
        &self,
        path: &mut Path,
        flight: u32,
        random: &PathRandom,
        radiance: &mut Rgb,
        counters: &mut Counters,
    ) -> bool {
        let scene = self.scene;
        counters.rays += 1;
        let found = if flight == 1 { scene.intersect_from_camera(&path.ray) } else { scene.intersect(&path.ray) };
        let numbers = random.block(dimension::light(flight));
        if let Some(medium) = scene.medium(path.medium) {
            let distance = found.as_ref().map_or(f32::INFINITY, |hit| hit.distance);
            match medium.fly(distance, numbers[3]) {
                Flight::Through(weight) => path.throughput *= weight,
                Flight::Scattered(distance, weight) => {
                    path.throughput *= weight;
                    let position = path.ray.at(distance);
                    *radiance += self.light_in_medium(path, position, [numbers[0], numbers[1], numbers[2]], counters);
                    let u = random.block(dimension::scattering(flight));
                    let (direction, pdf) = medium.phase.sample(path.ray.direction, [u[0], u[1]]);
                    path.ray = Ray::new(position, direction);
                    (path.place, path.pdf, path.straight, path.is_seen) = (position.into(), pdf, false, false);
                    path.segments += 1;
                    return true;
                }
            }
        }
        *radiance += self.emission_in_media(path, found.as_ref());
        let Some(hit) = found else { return false };
        let material = scene.material(hit.shape);
        if material.lobes().any(Lobes::SMOOTH) {
            *radiance += self.light_on_surface(path, &hit, [numbers[0], numbers[1], numbers[2]], counters);
        }
        let u = random.block(dimension::scattering(flight));
        let view = shading::view(&hit, TransportMode::Radiance);
        let Some(scattering) = shading::scatter(&hit, material, &view, [u[0], u[1], u[2]]) else { return false };
        path.throughput *= scattering.weight;
        path.index_squared *= scattering.sample.relative_index * scattering.sample.relative_index;
        path.medium = scene.medium_beyond(&hit, scattering.direction, path.medium);
        path.ray = hit.ray_to(scattering.direction);
        if !scattering.is_straight(&hit) {
            (path.place, path.pdf, path.straight) = (scene.place(&hit), scattering.sample.pdf, false);
            path.is_seen &= scattering.sample.is_specular();
            path.segments += 1;
        }
        true
    }

    /// The radiance that a light sends along the last segment, as far as finding it by chance counts.
    fn emission_in_media(&self, path: &Path, hit: Option<&Interaction>) -> Rgb {
        let lights = &self.scene.lights;
        let arriving = match hit {
            Some(hit) => lights.emitted(&self.scene.geometry, &path.place, hit, path.is_seen),
            None if self.scene.hides_lights && path.straight => None,
            None => lights.environment(&path.place, path.ray.direction),
        };
        let Some((radiance, sampled)) = arriving else { return Rgb::ZERO };
        let takes_part = path.segments == 1 || self.weighting.techniques.any(Techniques::HIT);
        if !takes_part || !self.selection.takes(path.segments, 0, path.segments + 1) {
            return Rgb::ZERO;
        }
        let weight = self.weighting.hit(&Sums::default(), path.pdf, sampled, 0.0, 0.0);
        self.selection.shown(path.throughput * radiance, weight)
    }

    /// A point of a light as a place in a medium sees it.
    fn light_in_medium(&self, path: &Path, position: Vec3, u: [f32; 3], counters: &mut Counters) -> Rgb {
        let place = Place::from(position);
        let sample = self.scene.lights.sample_direct(&self.scene.geometry, &place, u);
        let (Some(light), Some(medium)) = (sample, self.scene.medium(path.medium)) else { return Rgb::ZERO };
        let value = medium.phase.value(path.ray.direction, light.direction);
        let (origin, medium) = (position, path.medium);
        self.sampled_light(
            path,
            &Sampled { light: &light, origin, medium, value: Rgb::splat(value), pdf: value },
            counters,
        )
    }

    /// A point of a light as a surface sees it.
    fn light_on_surface(&self, path: &Path, hit: &Interaction, u: [f32; 3], counters: &mut Counters) -> Rgb {
        let scene = self.scene;
        let Some(light) = scene.lights.sample_direct(&scene.geometry, &scene.place(hit), u) else { return Rgb::ZERO };
        let Path { throughput, segments, .. } = *path;
        let vertex = Vertex { hit: *hit, throughput, sums: Sums::default(), segments };
        let Some(reflected) = vertex.reflect(scene, TransportMode::Radiance, light.direction) else { return Rgb::ZERO };
        let pdf = vertex.forward_pdf(scene, &reflected).forward;
        let medium = scene.medium_beyond(hit, light.direction, path.medium);
        let origin = hit.offset_towards(light.direction);
        self.sampled_light(path, &Sampled { light: &light, origin, medium, value: reflected.value, pdf }, counters)
    }

    fn sampled_light(&self, path: &Path, sampled: &Sampled<'_>, counters: &mut Counters) -> Rgb {
        let segments = path.segments + 1;
        let takes = self.weighting.techniques.any(Techniques::DIRECT)
            && self.limits.allows(segments)
            && self.selection.takes(segments, 1, path.segments + 1);
        let carried = path.throughput * sampled.value * sampled.light.weighted_radiance;
        if !takes || carried == Rgb::ZERO {
            return Rgb::ZERO;
        }
        let passing = transmittance(self.scene, sampled, counters);
        let pdf = Densities { forward: sampled.pdf, reverse: 0.0 };
        let weight = self.weighting.direct(&Sums::default(), pdf, 1.0, sampled.light, 0.0);
        self.selection.shown(carried * passing, weight)
    }
}

/// The share of a sampled light that media and what can be passed straight on let through.
fn transmittance(scene: &Scene, sampled: &Sampled<'_>, counters: &mut Counters) -> Rgb {
    let direction = sampled.light.direction;
    let mut ray = Ray { origin: sampled.origin, direction, length: sampled.light.distance * SHADOW_END };
    let (mut medium, mut passing) = (sampled.medium, Rgb::ONE);
    for _ in 0..MOST_PANES {
        counters.rays += 1;
        let found = scene.intersect(&ray);
        let distance = found.as_ref().map_or(ray.length, |hit| hit.distance);
        if let Some(medium) = scene.medium(medium) {
            passing *= medium.transmittance(distance);
        }
        let Some(hit) = found else { return passing };
        let view = shading::view(&hit, TransportMode::Radiance);
        let lobes = scene.material(hit.shape).specular_lobes(&view);
        let Some(straight) = lobes.iter().flatten().find(|lobe| lobe.direction == -view.outgoing) else {
            return Rgb::ZERO;
        };
        passing *= straight.weight;
        if passing == Rgb::ZERO {
            return passing;
        }
        medium = scene.medium_beyond(&hit, direction, medium);
        ray = Ray { length: ray.length - distance, ..hit.ray_to(direction) };
    }
    Rgb::ZERO
}
