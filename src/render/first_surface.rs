//! What the camera sees first, for compositing and noise filters: colour, direction, distance and place of surfaces.
//!
//! A pure function of the scene: no photons, no job's seed, the same bits on any number of threads. Each pixel looks
//! through 4 × 4 camera rays, one in each cell of its film filter's square, spread as passes spread them.

use rayon::prelude::*;

pub use crate::estimate::picture_files::NOTHING_SEEN;
use crate::estimate::picture_files::RAYS_PER_PIXEL as RAYS;
use crate::math::random::{PathRandom, Stream, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::material::{TransportMode, View};

/// Cells of a pixel along either side.
const CELLS: u32 = 4;
const _: () = assert!(RAYS == CELLS * CELLS);
/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// What a pixel sees first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSurface {
    /// The share of light that the surface reflects or transmits towards the camera, 0 to 1 per channel; mean over the
    /// pixel, where rays that meet nothing count 0, as do light sources that do not reflect.
    pub albedo: Rgb,
    /// The shading normal on the seen side, world space: of length 1 on a flat surface, shorter where it turns within the
    /// pixel; mean over the pixel, where rays that meet nothing count 0.
    pub normal: Vec3,
    /// The distance between camera and surface, m; mean over the rays that meet one, [`NOTHING_SEEN`] when none does.
    pub depth: f32,
    /// Where the surface is, world space, m; mean over the rays that meet one, 0 when none does.
    pub position: Vec3,
}

/// What every pixel sees first, row-major, top row first. Runs on the calling rayon pool.
pub fn first_surface_layers(scene: &Scene) -> Vec<FirstSurface> {
    let pixels = (0..scene.pixel_count()).into_par_iter().with_min_len(scene.width as usize);
    pixels.map(|pixel| look_through(scene, pixel as u32)).collect()
}

fn look_through(scene: &Scene, pixel: u32) -> FirstSurface {
    let (mut albedo, mut normal, mut position) = (Rgb::ZERO, Vec3::ZERO, Vec3::ZERO);
    let (mut distance, mut met) = (0.0, 0.0);
    for (random, hit) in first_hits(scene, pixel) {
        let [u, v, lobe, _] = random.block(dimension::scattering(1));
        albedo += scattered_share(scene, &hit, [u, v, lobe]);
        normal += seen_normal(scene, &hit);
        // Rays begin at the near clip distance, hence not the length of the ray.
        distance += scene.camera.distance_to(hit.position);
        position += hit.position;
        met += 1.0;
    }
    FirstSurface {
        albedo: albedo / RAYS as f32,
        normal: normal / RAYS as f32,
        depth: if met > 0.0 { distance / met } else { NOTHING_SEEN },
        position: if met > 0.0 { position / met } else { Vec3::ZERO },
    }
}

/// What a pixel's rays meet, those that meet something, each with the random numbers of its path.
pub(super) fn first_hits(scene: &Scene, pixel: u32) -> impl Iterator<Item = (PathRandom, Interaction)> {
    (0..RAYS).filter_map(move |cell| {
        let random = PathRandom::new(0, Stream::FirstSurface, cell, pixel);
        let [x, y, lens_x, lens_y] = random.block(dimension::CAMERA);
        let place = [within(cell % CELLS, x), within(cell / CELLS, y), lens_x, lens_y];
        let ray = scene.camera_ray([pixel % scene.width, pixel / scene.width], place);
        Some((random, scene.intersect_from_camera(&ray)?))
    })
}

/// The number in a cell of [0, 1) that `u` in [0, 1) chooses; rounding must not reach the end.
fn within(cell: u32, u: f32) -> f32 {
    ((cell as f32 + u) / CELLS as f32).min(BELOW_ONE)
}

/// The integral of BSDF and cosine over all directions, by one sample. As for flux: refraction scales radiance by the
/// indices, which is no loss.
fn scattered_share(scene: &Scene, hit: &Interaction, u: [f32; 3]) -> Rgb {
    let view = View::at(hit, TransportMode::Flux);
    scene.material(hit.shape).sample(&view, u).map_or(Rgb::ZERO, |sample| sample.weight)
}

/// The shading normal, as normal and bump maps turn it, on the side of the true surface from which it is seen.
fn seen_normal(scene: &Scene, hit: &Interaction) -> Vec3 {
    let turned = scene.material(hit.shape).turned_normal(&View::at(hit, TransportMode::Radiance));
    let normal = if turned == Vec3::Z { hit.frame.normal } else { hit.frame.to_world(turned) };
    if hit.outgoing.dot(hit.geometric_normal) < 0.0 { -normal } else { normal }
}
