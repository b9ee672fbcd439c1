//! The pilot: first gather radii per pixel from the photon density that a first gather meets.
//!
//! A radius is found by repeated gathering in a photon map of its own random numbers, so it is independent of every pass.
//! It is no smaller than half a pixel's width on the surface, since detail below that is averaged anyway.

use rayon::prelude::*;

use super::camera_walk::GatherPoint;
use super::photon_map::{GatherQuery, PhotonLookup};
use crate::math::Frame;
use crate::math::trigonometry::sin_cos_turn;
use crate::scene::Scene;
use crate::scene::geometry::Ray;

/// Photons that a first gather should find.
pub(crate) const FIRST_GATHER_PHOTONS: f32 = 20.0;
/// The largest first radius as a share of the scene's bounding radius.
const LARGEST_SHARE: f32 = 0.05;
const STEPS: usize = 8;
/// A gather that finds within this factor of what it should is good enough to extrapolate from.
const CLOSE_ENOUGH: f32 = 1.3;
/// The most by which one step may change R².
const LARGEST_STEP: f32 = 16.0;

/// Bounds on a first radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RadiusBounds {
    /// Radius of the scene's bounding sphere, m.
    pub scene_radius: f32,
    /// Where to start searching, R², m².
    pub guess: f32,
}

impl RadiusBounds {
    /// Bounds for a map of `photons` photons in a scene of `scene_radius`, m.
    pub(crate) fn new(scene_radius: f32, photons: usize) -> Self {
        // The sphere's surface stands for the unknown area that the photons lie on.
        let area_per_photon = 4.0 * std::f32::consts::PI * scene_radius * scene_radius / photons.max(1) as f32;
        let guess = FIRST_GATHER_PHOTONS * area_per_photon / std::f32::consts::PI;
        Self { scene_radius, guess: guess.min(Self::largest_squared(scene_radius)) }
    }

    /// The largest R² in a scene of `scene_radius`, m².
    pub(crate) fn largest_squared(scene_radius: f32) -> f32 {
        (LARGEST_SHARE * scene_radius) * (LARGEST_SHARE * scene_radius)
    }
}

/// R² with which a gather at `point` finds [`FIRST_GATHER_PHOTONS`], m². `footprint` is half a pixel's width there, m.
pub(crate) fn first_radius_squared(
    map: &impl PhotonLookup,
    point: &GatherPoint,
    footprint: f32,
    bounds: &RadiusBounds,
) -> f32 {
    let largest = RadiusBounds::largest_squared(bounds.scene_radius);
    let smallest = (footprint * footprint).clamp(f32::MIN_POSITIVE, largest);
    let mut radius_squared = bounds.guess.clamp(smallest, largest);
    for _ in 0..STEPS {
        let query = GatherQuery {
            position: point.hit.position,
            normal: point.facing_normal(),
            radius_squared,
            most_segments: 127,
            caustics_only: point.goes_on,
            both_sides: false,
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

/// How often a disc that reaches over an edge or into a corner is halved.
const HALVINGS: usize = 2;
/// Directions in which a disc is probed.
const PROBES: usize = 8;
/// Height of the probes over the tangent plane, in radii.
const PROBE_HEIGHT: f32 = 0.05;
/// Depth to which a surface still belongs to the disc, in radii; what the gather accepts too.
const PROBE_DEPTH: f32 = 0.25;
/// The least cosine between the normals at the rim and in the middle.
const PROBE_COSINE: f32 = 0.7;

/// R² made smaller, m², until the disc lies on one surface without obstacles, or [`HALVINGS`] times.
///
/// A disc that reaches over an edge or into a corner finds too few photons for its area: the bias that stays longest. Rays
/// along the surface find corners and obstacles, rays down at the rim find edges.
pub(crate) fn clear_of_edges(scene: &Scene, point: &GatherPoint, radius_squared: f32, smallest: f32) -> f32 {
    let mut radius = radius_squared.sqrt();
    for _ in 0..HALVINGS {
        if radius <= smallest || is_clear(scene, point, radius) {
            break;
        }
        radius = (0.5 * radius).max(smallest);
    }
    radius * radius
}

fn is_clear(scene: &Scene, point: &GatherPoint, radius: f32) -> bool {
    let normal = point.facing_normal();
    let frame = Frame::from_normal(normal);
    let height = (PROBE_HEIGHT * radius).max(2.0 * point.hit.error);
    let origin = point.hit.position + normal * height;
    (0..PROBES).all(|probe| {
        let (sin, cos) = sin_cos_turn((probe as f32 + 0.5) / PROBES as f32);
        let along = frame.tangent * cos + frame.bitangent * sin;
        if scene.geometry.is_blocked(&Ray { origin, direction: along, length: radius }) {
            return false;
        }
        let length = height + PROBE_DEPTH * radius;
        let down = Ray { origin: origin + along * radius, direction: -normal, length };
        let rim = scene.geometry.intersect(&down);
        rim.is_some_and(|rim| rim.geometric_normal.dot(normal).abs() > PROBE_COSINE)
    })
}

/// Gives pixels without a radius the smallest of their neighbours', growing from the edges inwards; pixels far from any
/// take `fallback`.
pub(crate) fn fill_gaps(radius_squared: &mut [Option<f32>], width: usize, fallback: f32) -> Vec<f32> {
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
