//! Whether a scene needs the default environment: a white one, in which programs that show models show them.
//!
//! It is decided by what the camera sees, not by whether something emits: two glowing spots on a helmet do not light it.

use super::draft::Draft;
use crate::scene::Scene;
use crate::scene::description::PluginClass;
use crate::scene::error::Location;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::Lobes;

/// A place is lit where it emits, or receives of the scene's own lights, at least this share of what the environment would
/// give it. A hundredth of white is a tenth of a screen's range.
const LIT: f64 = 0.01;
/// A scene is dark where less than this share of the places that its camera sees is lit.
const LIT_PLACES: f64 = 0.25;

/// The picture is looked at in so many columns and rows.
const GRID: [u32; 2] = [32, 24];
/// Samples of the light that arrives at each place.
const SAMPLES: u32 = 8;

/// White, of radiance 1 W·sr⁻¹·m⁻².
pub(super) fn emitter(location: &Location) -> Draft {
    Draft::new(PluginClass::Emitter, "constant", location).with_rgb("radiance", [1.0; 3])
}

/// Whether the lights of `scene` leave what its camera sees dark. Where it sees nothing, there is nothing to light.
pub(super) fn is_dark(scene: &Scene) -> bool {
    let (mut seen, mut lit) = (0, 0);
    for (row, column) in (0..GRID[1]).flat_map(|row| (0..GRID[0]).map(move |column| (row, column))) {
        let pixel = [column * scene.width / GRID[0], row * scene.height / GRID[1]];
        let ray = scene.camera_ray(pixel, [0.5; 4]);
        let Some(hit) = scene.intersect(&ray) else { continue };
        seen += 1;
        let emitted = scene.lights.emitted(&scene.geometry, &ray.origin.into(), &hit, true);
        let emitted = emitted.map_or(0.0, |(radiance, _)| f64::from(radiance.max_element()));
        lit += u32::from(emitted + share_received(scene, &hit, row * GRID[0] + column) >= LIT);
    }
    f64::from(lit) < LIT_PLACES * f64::from(seen)
}

/// The irradiance at a hit, as a share of that of the environment, π W·m⁻².
fn share_received(scene: &Scene, hit: &Interaction, index: u32) -> f64 {
    let place = scene.place(hit);
    let seen_from_outside = hit.outgoing.dot(hit.geometric_normal) >= 0.0;
    let facing = if seen_from_outside { hit.geometric_normal } else { -hit.geometric_normal };
    let mut irradiance = 0.0;
    for sample in 0..SAMPLES {
        // A sequence that fills the unit cube evenly [Roberts 2018].
        let number = f64::from(index * SAMPLES + sample);
        let u = [0.819_172_513, 0.671_043_607, 0.549_700_478].map(|step: f64| (0.5 + step * number).fract() as f32);
        let Some(light) = scene.lights.sample_direct(&scene.geometry, &place, u) else { continue };
        let cosine = light.direction.dot(facing);
        let length = light.distance * (1.0 - 1e-4);
        let shadow = Ray { origin: hit.offset_towards(light.direction), direction: light.direction, length };
        if cosine > 0.0 && reaches(scene, shadow) {
            irradiance += f64::from(cosine * light.weighted_radiance.max_element());
        }
    }
    irradiance / f64::from(SAMPLES) / std::f64::consts::PI
}

/// Whether nothing on a ray stops light. What lets some pass counts as clear: a lamp in a bulb of glass lights the room.
fn reaches(scene: &Scene, mut ray: Ray) -> bool {
    /// More panes than that stop light.
    const PANES: usize = 8;
    for _ in 0..PANES {
        let Some(hit) = scene.geometry.intersect(&ray) else { return true };
        if !scene.lobes_at(hit.shape).any(Lobes::TRANSMISSIVE) {
            return false;
        }
        let length = ray.length - hit.distance;
        ray = Ray { length, ..hit.ray_to(ray.direction) };
    }
    false
}
