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

/// Rays to lights end this share before the light, so that rounding does not let the light hide itself.
pub(super) const SHADOW_END: f32 = 1.0 - 1.0 / 65_536.0;

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
    let ray = Ray {
        origin: hit.offset_towards(light.direction),
        direction: light.direction,
        length: light.distance * SHADOW_END,
    };
    counters.rays += 1;
    if scene.geometry.is_blocked(&ray) {
        return Rgb::ZERO;
    }
    let weight = match light.pdf_solid_angle {
        0.0 => 1.0,
        pdf => power_heuristic(pdf, material.pdf(&view, incident)),
    };
    reflected * light.weighted_radiance * weight
}

#[inline]
fn sample_material(scene: &Scene, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
    let hit = &point.hit;
    let u = random.block(dimension::scattering(point.segments));
    let material = scene.material(hit.shape);
    let Some(scattering) = shading::scatter(hit, material, &point.view(), [u[0], u[1], u[2]]) else {
        return Rgb::ZERO;
    };
    let ray = hit.ray_to(scattering.direction);
    if !scene.lights.may_be_hit(&scene.geometry, &ray) {
        return Rgb::ZERO;
    }
    counters.rays += 1;
    let place = scene.place(hit);
    let arriving = match scene.intersect(&ray) {
        Some(next) => scene.lights.emitted(&scene.geometry, &place, &next, false),
        None => scene.lights.environment(&place, ray.direction),
    };
    match arriving {
        Some((radiance, pdf)) => scattering.weight * radiance * power_heuristic(scattering.sample.pdf, pdf),
        None => Rgb::ZERO,
    }
}
