//! Light that arrives at a gather point straight from a light source: light sampling and material sampling combined by
//! multiple importance sampling with the power heuristic [Veach 1997, eq. 9.13]; with one light sample, or with as many as a plan says.

use crate::math::Rgb;
use crate::math::random::{PathRandom, dimension};
use crate::scene::Scene;
use crate::scene::geometry::Ray;
use crate::scene::light::DirectSample;

use super::camera_walk::GatherPoint;
use super::counters::Counters;
use super::light_plan::LightPlan;
use super::multiple_importance::power_heuristic;
use super::shading::{self, Scattering};
use super::visibility::{Blockers, Joint, SHADOW_END, transmittance, transmittance_of_media};
use super::walk::{Step, Walk};

/// What is known of a light at a point before a shadow ray is traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSight {
    /// Nothing: a shadow ray tells.
    #[default]
    Unknown,
    /// All of it is taken to be seen.
    Lit,
    /// None of it is taken to be seen.
    Dark,
}

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

/// The same with as many light samples as `plan` says, where the path ends: the weights know how often each light is picked. `sight` says what is
/// known of each light by its index; what is known wrongly makes the result wrong.
pub fn planned_direct_light(
    scene: &Scene,
    point: &GatherPoint,
    plan: &LightPlan<'_>,
    sight: impl Fn(usize) -> LightSight,
    random: &PathRandom,
    counters: &mut Counters,
) -> Rgb {
    let place = scene.place(&point.hit);
    let mut reflected = Rgb::ZERO;
    plan.for_each_sample(scene, &place, point.segments, random, |pick, u| {
        let known = sight(pick.index);
        if known == LightSight::Dark {
            return;
        }
        if let Some(light) = scene.lights.sample_light(&scene.geometry, &place, pick, u) {
            reflected += arriving_from(scene, point, &light, known, random, counters);
        }
    });
    if !scene.lights.has_extent() {
        return reflected;
    }
    let Some((walk, scattering, step)) = material_ray(scene, point, random, counters) else { return reflected };
    let found = match step.surface() {
        Some(hit) => scene.lights.found_at(&scene.geometry, &place, hit),
        None => scene.lights.found_outside(walk.ray.direction),
    };
    let Some(found) = found else { return reflected };
    let light_pdf = found.pdf * plan.picks(scene, &place, found.index);
    reflected + walk.throughput * found.radiance * power_heuristic(scattering.sample.pdf, light_pdf)
}

#[inline]
fn sample_light(scene: &Scene, point: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
    let u = random.block(dimension::light(point.segments));
    let place = scene.place(&point.hit);
    let Some(light) = scene.lights.sample_direct(&scene.geometry, &place, [u[0], u[1], u[2]]) else { return Rgb::ZERO };
    arriving_from(scene, point, &light, LightSight::Unknown, random, counters)
}

/// What the point's lobes reflect of a light sample, weighted against material sampling.
#[inline(always)]
fn arriving_from(
    scene: &Scene,
    point: &GatherPoint,
    light: &DirectSample,
    sight: LightSight,
    random: &PathRandom,
    counters: &mut Counters,
) -> Rgb {
    let hit = &point.hit;
    let material = scene.material(hit.shape);
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
    let passing = match sight {
        LightSight::Unknown => transmittance(scene, &joint, counters),
        LightSight::Lit => transmittance_of_media(scene, &joint),
        LightSight::Dark => Rgb::ZERO,
    };
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
    let Some((walk, scattering, step)) = material_ray(scene, point, random, counters) else { return Rgb::ZERO };
    match walk.arriving(scene, step.surface(), false) {
        Some((radiance, pdf)) => walk.throughput * radiance * power_heuristic(scattering.sample.pdf, pdf),
        None => Rgb::ZERO,
    }
}

/// A ray from the point that its lobes sample, where it may find a light, and where it ends.
#[inline(always)]
fn material_ray(
    scene: &Scene,
    point: &GatherPoint,
    random: &PathRandom,
    counters: &mut Counters,
) -> Option<(Walk, Scattering, Step)> {
    let hit = &point.hit;
    let u = random.block(dimension::scattering(point.segments));
    let scattering = shading::scatter(hit, scene.material(hit.shape), &point.view(), [u[0], u[1], u[2]])?;
    let mut walk = Walk::from_surface(hit, Rgb::ONE, point.segments, point.medium);
    walk.follow(scene, hit, &scattering);
    if !scene.lights.may_be_hit(&scene.geometry, &walk.ray) {
        return None;
    }
    let step = walk.step(scene, random, counters);
    Some((walk, scattering, step))
}
