//! Light that arrives at a gather point straight from a light source: light sampling and material sampling combined by
//! multiple importance sampling with the power heuristic [Veach 1997, eq. 9.13].

use crate::math::Rgb;
use crate::math::random::{PathRandom, dimension};
use crate::scene::Scene;
use crate::scene::geometry::Ray;

use super::camera_walk::GatherPoint;
use super::counters::Counters;
use super::multiple_importance::power_heuristic;
use super::shading;
use super::visibility::{Blockers, Joint, SHADOW_END, transmittance};
use super::walk::Walk;

/// Direct radiance that the point's lobes reflect, without the path's throughput; where the path goes on, its next segment
/// takes the part of material sampling.
#[inline]
pub fn direct_light(scene: &Scene, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
    let by_light = sample_light(scene, point, random, counters);
    if point.goes_on || !scene.lights.has_extent() {
        return by_light;
    }
    by_light + sample_material(scene, point, random, counters)
}

#[inline]
fn sample_light(scene: &Scene, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
    let hit = &point.hit;
    let material = scene.material(hit.shape);
    let u = random.block(dimension::light(point.segments));
    let place = scene.place(hit);
    let Some(light) = scene.lights.sample_direct(&scene.geometry, &place, [u[0], u[1], u[2]]) else { return Rgb::ZERO };
    let view = point.view();
    let incident = hit.frame.to_local(light.direction);
    let reflected = material.evaluate(&view, incident) * incident.z.abs();
    // Light from the other side of the true surface would leak through it.
    let leaks = light.direction.dot(hit.geometric_normal) * incident.z <= 0.0;
    if reflected == Rgb::ZERO || leaks {
        return Rgb::ZERO;
    }
    let (origin, length) = (hit.offset_towards(light.direction), light.distance * SHADOW_END);
    let joint = Joint {
        ray: Ray { origin, direction: light.direction, length },
        medium: scene.medium_beyond(hit, light.direction, point.medium),
        blockers: Blockers::All,
        random,
        step: point.segments,
    };
    let passing = transmittance(scene, &joint, counters);
    if passing == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let weight = match light.pdf_solid_angle {
        0.0 => 1.0,
        pdf => power_heuristic(pdf, material.pdf(&view, incident)),
    };
    reflected * light.weighted_radiance * passing * weight
}

#[inline]
fn sample_material(scene: &Scene, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
    let hit = &point.hit;
    let u = random.block(dimension::scattering(point.segments));
    let material = scene.material(hit.shape);
    let Some(scattering) = shading::scatter(hit, material, &point.view(), [u[0], u[1], u[2]]) else {
        return Rgb::ZERO;
    };
    let mut walk = Walk::from_surface(hit, Rgb::ONE, point.segments, point.medium);
    walk.follow(scene, hit, &scattering);
    if !scene.lights.may_be_hit(&scene.geometry, &walk.ray) {
        return Rgb::ZERO;
    }
    let step = walk.step(scene, random, counters);
    match walk.arriving(scene, step.surface(), false) {
        Some((radiance, pdf)) => walk.throughput * radiance * power_heuristic(scattering.sample.pdf, pdf),
        None => Rgb::ZERO,
    }
}
