//! `ppm`: progressive photon mapping. Camera paths are traced once, several per pixel, to the surfaces where photons will
//! be gathered; these hit points stay for the whole job and every pass emits new photons. Mirrors and glass are followed
//! in all directions while a path is short, so that no chance is left in what the camera sees.
//!
//! Reference: [HOJ08] Hachisuka, Ogaki & Jensen 2008, "Progressive photon mapping". The hit points of a pixel share its
//! radius and count, as the region of a pixel does in `sppm`.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | R² | `pass.radius_squared` × `pass.scale` | m² |
//! | M, Φ | mean over the pixel's camera paths of `PixelTally::photons`, `PixelTally::flux` (over `pass.scale`) | –, W·sr⁻¹ |
//! | T | `HitPoint::throughput` | – |
//!
//! Limits: `samples_per_pixel` camera paths are all there ever are, so edges, lenses and the shares of light behind many
//! layers of glass keep the error of so few samples; `sppm` has no such floor. A hit point takes 48 bytes.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::parameters::{self, HELP, ParameterHelp, ProgressiveParameters};
use super::photon_pass::{PhotonPasses, add_to_tally};
use super::{
    Bias, CheckedMethod, MethodChoice, MethodEntry, MethodError, Pass, PilotPass, PreparedMethod, blind_to_nothing,
    declare_gathering,
};
use crate::estimate::{PixelTally, Region};
use crate::math::octahedral;
use crate::math::random::{PassRandom, PathRandom, Stream, dimension};
use crate::math::trigonometry::sin_cos_turn;
use crate::math::{Frame, Rgb, Vec2, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::ray::{largest, position_error};
use crate::scene::geometry::surface::NO_INSTANCE;
use crate::scene::geometry::{Detail, Interaction, Shape};
use crate::scene::material::Lobes;
use crate::transport::Counters;
use crate::transport::camera_walk::{CameraWalk, GatherPoint};
use crate::transport::photon_map::{Gathered, PhotonMap};
use crate::transport::shading;

const NAME: &str = "ppm";
const PARAMETERS: &[ParameterHelp] = HELP;
/// Specular surfaces up to this many segments are followed in all their directions, later ones in one at random.
const SPLIT_SEGMENTS: u32 = 4;
/// The pass index that addresses the random numbers of hit points.
const HIT_POINT_PASS: u32 = u32::MAX;

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: NAME,
    summary: "progressive photon mapping: hit points fixed for the whole job, photons anew every pass",
    cannot_sample: "more camera paths than samples_per_pixel: edges and lenses stay as noisy as those leave them",
    reference: "Hachisuka, Ogaki & Jensen 2008",
    bias: Bias::Shrinks,
    parameters: PARAMETERS,
    negative_lobes: false,
    media: false,
    strategies: None,
    blind_to: blind_to_nothing,
    check,
    declare: declare_gathering,
    prepare,
};

fn check(choice: &MethodChoice, pixels: u64) -> Result<CheckedMethod, MethodError> {
    Ok(parameters::read::<ProgressiveParameters>(NAME, &choice.parameters, PARAMETERS)?
        .checked(NAME, PARAMETERS, pixels))
}

fn prepare(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Box<dyn PreparedMethod>, MethodError> {
    let parameters: ProgressiveParameters = parameters::read(NAME, &method.choice.parameters, PARAMETERS)?;
    let (low, high) = scene.geometry.bounds();
    Ok(Box::new(Ppm {
        samples_per_pixel: parameters.samples_per_pixel,
        error: position_error(largest(low).max(largest(high))),
        passes: PhotonPasses::new(scene, method, &parameters, seed, false)?,
        cache: Mutex::new(HashMap::new()),
    }))
}

struct Ppm {
    passes: PhotonPasses,
    samples_per_pixel: u32,
    /// Bound on the rounding error of any position in the scene, m.
    error: f32,
    /// Hit points per region, made when first needed.
    cache: Mutex<HashMap<Region, Arc<HitPoints>>>,
}

/// Where a camera path meets a surface with a smooth lobe.
#[derive(Clone, Copy, Debug)]
struct HitPoint {
    position: Vec3,
    /// Octahedral codes: true normal, shading normal, direction towards the camera.
    directions: [u32; 3],
    throughput: Rgb,
    /// Material, and segments from the camera in the top byte.
    material_and_segments: u32,
    parameterization: Parameterization,
    /// `Interaction::detail`.
    detail: Detail,
    /// The shape's border between media.
    boundary: u16,
    /// The index of the medium that the path came through, or [`NO_MEDIUM`].
    medium: u16,
}

/// The number of a medium where there is none.
const NO_MEDIUM: u16 = u16::MAX;

/// Texture coordinates as floats of 24 bits each, a 2¹⁶th exact; then the tangent's turn from that of [`Frame::from_normal`]
/// in 15 bits, and whether the bitangent is mirrored. Fractions of integers would not do: how far coordinates go, and how
/// they wrap, is each texture's own affair. All 0 where the shape needs none.
#[derive(Clone, Copy, Debug)]
struct Parameterization(u64);

const TURNS: f32 = 32768.0;

impl Parameterization {
    fn new(hit: &Interaction) -> Self {
        if !hit.shape.needs_uv {
            return Self(0);
        }
        let [u, v] = hit.uv.to_array().map(|number| u64::from(number.to_bits().saturating_add(0x80) >> 8));
        let plain = Frame::from_normal(hit.frame.normal);
        let local = plain.to_local(hit.frame.tangent);
        let turn = libm::atan2f(local.y, local.x) / std::f32::consts::TAU;
        let turn = ((turn + 1.0) * TURNS + 0.5) as u64 % TURNS as u64;
        let mirrored = hit.frame.normal.cross(hit.frame.tangent).dot(hit.frame.bitangent) < 0.0;
        Self(u | v << 24 | turn << 48 | u64::from(mirrored) << 63)
    }

    fn uv(self) -> Vec2 {
        Vec2::new(f32::from_bits((self.0 as u32) << 8), f32::from_bits(((self.0 >> 24) as u32) << 8))
    }

    fn frame(self, normal: Vec3) -> Frame {
        let plain = Frame::from_normal(normal);
        let (sin, cos) = sin_cos_turn((self.0 >> 48 & 0x7fff) as f32 / TURNS);
        let side = if self.0 >> 63 == 1 { -1.0 } else { 1.0 };
        Frame {
            tangent: plain.tangent * cos + plain.bitangent * sin,
            bitangent: (plain.bitangent * cos - plain.tangent * sin) * side,
            normal,
        }
    }
}

/// The hit points of a region, and the emission that its pixels see.
#[derive(Default)]
struct HitPoints {
    points: Vec<HitPoint>,
    /// Index of the first point of each pixel, and the count last.
    first: Vec<u32>,
    /// Emission seen directly or through specular surfaces, mean over the pixel's paths.
    seen: Vec<[f32; 3]>,
    /// Rays that made them.
    rays: u64,
}

const MATERIAL_BITS: u32 = 24;

impl HitPoint {
    fn new(point: &GatherPoint) -> Self {
        let hit = &point.hit;
        let directions = [hit.geometric_normal, hit.frame.normal, hit.outgoing].map(octahedral::encode);
        Self {
            position: hit.position,
            directions,
            throughput: point.throughput,
            material_and_segments: hit.shape.material | point.segments.min(255) << MATERIAL_BITS,
            parameterization: Parameterization::new(hit),
            detail: hit.detail,
            boundary: hit.shape.boundary,
            medium: point.medium.unwrap_or(NO_MEDIUM),
        }
    }

    fn segments(&self) -> u32 {
        self.material_and_segments >> MATERIAL_BITS
    }

    fn gather_point(&self, error: f32) -> GatherPoint {
        let [geometric_normal, shading_normal, outgoing] = self.directions.map(octahedral::decode);
        let material = self.material_and_segments & ((1 << MATERIAL_BITS) - 1);
        // Codes of equal normals are equal: flat surfaces stay flat.
        let flat = self.directions[0] == self.directions[1];
        let hit = Interaction {
            position: self.position,
            geometric_normal,
            frame: self.parameterization.frame(if flat { geometric_normal } else { shading_normal }),
            uv: self.parameterization.uv(),
            outgoing,
            distance: 0.0,
            shape: Shape { boundary: self.boundary, ..Shape::new(material) },
            primitive: 0,
            instance: NO_INSTANCE,
            error,
            detail: self.detail,
        };
        GatherPoint {
            hit,
            throughput: self.throughput,
            segments: self.segments(),
            path_length: 0.0,
            medium: (self.medium != NO_MEDIUM).then_some(self.medium),
            lobes: Lobes::SMOOTH,
            goes_on: false,
        }
    }
}

impl Ppm {
    /// The hit points of a region, from the cache or traced now.
    fn hit_points(&self, region: Region, cancel: &AtomicBool) -> Option<Arc<HitPoints>> {
        let cache = || self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = cache().get(&region) {
            return Some(known.clone());
        }
        let rows: Vec<HitPoints> = (region.row_start..region.row_end)
            .into_par_iter()
            .map(|row| if cancel.load(Ordering::Relaxed) { HitPoints::default() } else { self.trace_row(row) })
            .collect();
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let mut all = HitPoints::default();
        for row in rows {
            let before = all.points.len() as u32;
            all.first.extend(row.first.iter().map(|first| first + before));
            all.points.extend(row.points);
            all.seen.extend(row.seen);
            all.rays += row.rays;
        }
        all.first.push(all.points.len() as u32);
        all.points.shrink_to_fit();
        let all = Arc::new(all);
        cache().insert(region, all.clone());
        Some(all)
    }

    fn trace_row(&self, row: u32) -> HitPoints {
        let width = self.passes.scene.width;
        let mut points = HitPoints::default();
        let mut counters = Counters::default();
        for column in 0..width {
            points.first.push(points.points.len() as u32);
            let mut seen = Rgb::ZERO;
            for sample in 0..self.samples_per_pixel {
                self.trace_tree([column, row], sample, &mut seen, &mut points.points, &mut counters);
            }
            points.seen.push((seen / self.samples_per_pixel as f32).to_array());
        }
        points.rays = counters.rays;
        points
    }

    /// One camera path with all its specular branches.
    fn trace_tree(
        &self,
        [column, row]: [u32; 2],
        sample: u32,
        seen: &mut Rgb,
        points: &mut Vec<HitPoint>,
        counters: &mut Counters,
    ) {
        let scene = &*self.passes.scene;
        let path = (row * scene.width + column).wrapping_mul(self.samples_per_pixel).wrapping_add(sample);
        let random = PathRandom::new(self.passes.seed, Stream::Camera, HIT_POINT_PASS, path);
        let ray = scene.camera_ray([column, row], random.block(dimension::CAMERA));
        let mut waiting = vec![CameraWalk::new(scene, ray, true)];
        while let Some(mut walk) = waiting.pop() {
            let Some(point) = walk.advance(scene, &random, &self.passes.limits, seen, counters) else { continue };
            let lobes = scene.material(point.hit.shape).lobes();
            if lobes.any(Lobes::SMOOTH) {
                points.push(HitPoint::new(&point));
            }
            if lobes.any(Lobes::SPECULAR) {
                match point.segments <= SPLIT_SEGMENTS {
                    true => waiting.extend(self.all_directions(&walk, &point)),
                    false => waiting.extend(self.one_direction(walk, &point, &random)),
                }
            }
        }
    }

    fn all_directions(&self, walk: &CameraWalk, point: &GatherPoint) -> impl Iterator<Item = CameraWalk> {
        let (walk, hit, view) = (*walk, point.hit, point.view().of(Lobes::SPECULAR));
        let scene = &self.passes.scene;
        let lobes = scene.material(hit.shape).specular_lobes(&view);
        lobes.into_iter().flatten().filter_map(move |sample| {
            let scattering = shading::finish(&hit, &view, sample)?;
            let mut branch = walk;
            branch.follow(scene, &hit, &scattering);
            Some(branch)
        })
    }

    fn one_direction(&self, mut walk: CameraWalk, point: &GatherPoint, random: &PathRandom) -> Option<CameraWalk> {
        let hit = &point.hit;
        let u = random.block(dimension::scattering(point.segments));
        let scene = &self.passes.scene;
        let view = point.view().of(Lobes::SPECULAR);
        let scattering = shading::scatter(hit, scene.material(hit.shape), &view, [u[0], u[1], u[2]])?;
        walk.follow(scene, hit, &scattering);
        walk.walk.survives(&self.passes.limits, u[3]).then_some(walk)
    }

    /// One pixel of one pass: sums over its hit points.
    fn trace_pixel(
        &self,
        pass: &Pass<'_>,
        map: &PhotonMap,
        points: &[HitPoint],
        random: &PassRandom,
        (first_point, radius_squared): (usize, f32),
        counters: &mut Counters,
    ) -> (Rgb, Gathered) {
        let (mut radiance, mut gathered) = (Rgb::ZERO, Gathered::default());
        let share = 1.0 / self.samples_per_pixel as f32;
        for (index, hit_point) in points.iter().enumerate() {
            let point = hit_point.gather_point(self.error);
            let random = random.path((first_point + index) as u32);
            radiance += point.throughput * self.passes.direct_light(&point, &random, counters);
            gathered.add(&self.passes.gather(map, &point, radius_squared * pass.scale), point.throughput * share);
        }
        gathered.photons *= share;
        (radiance * share, gathered)
    }
}

impl PreparedMethod for Ppm {
    fn trace_pass(&self, pass: &Pass<'_>, pixels: &mut [PixelTally], cancel: &AtomicBool) -> Option<Counters> {
        let hit_points = self.hit_points(pass.region, cancel)?;
        let (map, mut total) =
            self.passes.photon_map(Stream::Photon, pass.index, pass.typical_radius_squared, cancel)?;
        let width = self.passes.scene.width as usize;
        let random = PassRandom::of_pixels(self.passes.seed, Stream::Camera, pass.index);
        // Random numbers are addressed by the hit point's place in its row, which no region changes.
        let rows = pixels.par_chunks_mut(width).enumerate();
        let counters: Vec<Counters> = rows
            .map(|(row, tallies)| {
                let mut counters = Counters::default();
                if cancel.load(Ordering::Relaxed) {
                    return counters;
                }
                for (column, tally) in tallies.iter_mut().enumerate() {
                    let pixel = row * width + column;
                    let range = hit_points.first[pixel] as usize..hit_points.first[pixel + 1] as usize;
                    let picture_pixel = pass.region.row_start as usize * width + pixel;
                    let address = picture_pixel.wrapping_mul(MOST_POINTS_PER_PIXEL);
                    let radius = pass.radius_squared[pixel];
                    let points = &hit_points.points[range];
                    let (radiance, gathered) =
                        self.trace_pixel(pass, &map, points, &random, (address, radius), &mut counters);
                    let radiance = radiance + Rgb::from_array(hit_points.seen[pixel]);
                    add_to_tally(tally, pass, radiance, &gathered, &mut counters);
                }
                counters
            })
            .collect();
        counters.into_iter().for_each(|counters| total += counters);
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let (map, mut total) = self.passes.pilot_map(cancel)?;
        let scene = &*self.passes.scene;
        let region = Region { row_start: 0, row_end: scene.height };
        let hit_points = self.hit_points(region, cancel)?;
        let mut radii: Vec<Option<f32>> = (0..scene.pixel_count())
            .into_par_iter()
            .with_min_len(1024)
            .map(|pixel| {
                let range = hit_points.first[pixel] as usize..hit_points.first[pixel + 1] as usize;
                let point = hit_points.points.get(range)?.first()?.gather_point(self.error);
                // The straight distance stands for the path's: hit points do not keep it.
                let distance = scene.camera.distance_to(point.hit.position);
                Some(self.passes.first_radius_squared(&map, &point, distance))
            })
            .collect();
        total.rays += 2 * hit_points.points.len() as u64;
        let filled = self.passes.complete_first_radii(&mut radii);
        (!cancel.load(Ordering::Relaxed)).then(|| PilotPass::with_radii(filled, total))
    }
}

/// Spaces the random number addresses of pixels apart; a pixel with more hit points shares some with its neighbour, which
/// is harmless: no estimate compares them.
const MOST_POINTS_PER_PIXEL: usize = 256;
