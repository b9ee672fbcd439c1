//! The pilot: first gather radii per pixel from the photon density that a first gather meets.
//!
//! A radius is found by repeated gathering in a photon map of its own random numbers, so it is independent of every pass.
//! It is no smaller than half a pixel's width on the surface, since detail below that is averaged anyway.

use rayon::prelude::*;

use super::camera_walk::GatherPoint;
use super::photon_map::{GatherQuery, PhotonMap};

/// Photons that a first gather should find.
pub const FIRST_GATHER_PHOTONS: f32 = 30.0;
/// The largest first radius as a share of the scene's bounding radius.
const LARGEST_SHARE: f32 = 0.05;
const STEPS: usize = 8;
/// A gather that finds within this factor of what it should is good enough to extrapolate from.
const CLOSE_ENOUGH: f32 = 1.3;
/// The most by which one step may change R².
const LARGEST_STEP: f32 = 16.0;

/// Bounds on a first radius.
#[derive(Clone, Copy, Debug)]
pub struct RadiusBounds {
    /// Radius of the scene's bounding sphere, m.
    pub scene_radius: f32,
    /// Where to start searching, R², m².
    pub guess: f32,
}

impl RadiusBounds {
    /// Bounds for a map of `photons` photons in a scene of `scene_radius`, m.
    pub fn new(scene_radius: f32, photons: usize) -> Self {
        // The sphere's surface stands for the unknown area that the photons lie on.
        let area_per_photon = 4.0 * std::f32::consts::PI * scene_radius * scene_radius / photons.max(1) as f32;
        let guess = FIRST_GATHER_PHOTONS * area_per_photon / std::f32::consts::PI;
        Self { scene_radius, guess: guess.min(Self::largest_squared(scene_radius)) }
    }

    fn largest_squared(scene_radius: f32) -> f32 {
        (LARGEST_SHARE * scene_radius) * (LARGEST_SHARE * scene_radius)
    }
}

/// R² with which a gather at `point` finds [`FIRST_GATHER_PHOTONS`], m². `footprint` is half a pixel's width there, m.
pub fn first_radius_squared(map: &PhotonMap, point: &GatherPoint, footprint: f32, bounds: &RadiusBounds) -> f32 {
    let largest = RadiusBounds::largest_squared(bounds.scene_radius);
    let smallest = (footprint * footprint).clamp(f32::MIN_POSITIVE, largest);
    let mut radius_squared = bounds.guess.clamp(smallest, largest);
    for _ in 0..STEPS {
        let query = GatherQuery {
            position: point.hit.position,
            normal: point.facing_normal(),
            radius_squared,
            most_segments: 255,
        };
        let found = map.gather(&query).photons;
        let step = FIRST_GATHER_PHOTONS / found.max(0.5);
        let next = (radius_squared * step.clamp(1.0 / LARGEST_STEP, LARGEST_STEP)).clamp(smallest, largest);
        let settled = step < CLOSE_ENOUGH && step > 1.0 / CLOSE_ENOUGH;
        if settled || next == radius_squared {
            return next;
        }
        radius_squared = next;
    }
    radius_squared
}

/// Gives pixels without a radius the smallest of their neighbours', growing from the edges inwards; pixels far from any
/// take `fallback`.
pub fn fill_gaps(radius_squared: &mut [Option<f32>], width: usize, fallback: f32) -> Vec<f32> {
    const RINGS: usize = 4;
    let height = radius_squared.len() / width.max(1);
    for _ in 0..RINGS {
        let before = radius_squared.to_vec();
        let neighbours = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let values = rows.flat_map(|row| {
                let columns = x.saturating_sub(1)..(x + 2).min(width);
                before[row * width..][columns].iter().flatten().copied().collect::<Vec<f32>>()
            });
            values.reduce(f32::min)
        };
        let empty: Vec<usize> = (0..before.len()).filter(|pixel| before[*pixel].is_none()).collect();
        let filled: Vec<Option<f32>> = empty.par_iter().map(|pixel| neighbours(*pixel)).collect();
        for (pixel, value) in empty.into_iter().zip(filled) {
            radius_squared[pixel] = value;
        }
    }
    radius_squared.iter().map(|value| value.unwrap_or(fallback)).collect()
}
