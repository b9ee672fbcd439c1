//! `ppm`: progressive photon mapping. Camera paths are traced once, several per pixel, to the surfaces where photons will
//! be gathered; these hit points stay for the whole job and every pass emits new photons. Mirrors and glass are followed
//! in all directions while a path is short, so that no chance is left in what the camera sees.
//!
//! Reference: \[HOJ08\] Hachisuka, Ogaki & Jensen 2008, "Progressive photon mapping". The hit points of a pixel share its
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
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::bounded_numbers::bounded;
use super::parameter_values::{
    Auto, Depth, DirectLight, Emission, LightPicks, OpenUnit, Passes, PhotonCount, PhotonEmission, Radius,
    RouletteDepth, limits,
};
use super::parameters::{ParameterSet, parameter, parameters, read_method};
use super::photon_pass::{Found, PILOT_PASS, PhotonPasses, PhotonsOf, add_evenness, add_to_tally};
use super::pilot::PilotView;
use super::shared_parameters::{
    ALPHA, DIRECT, EMISSION, GATHER_RADIUS, LIGHT_PICKS, MAX_DEPTH, OCCLUSION, PASSES, PHOTONS, RADIUS_RULE, RR_DEPTH,
};
use super::visibility_pilot::LightSampling;
use super::{Bias, Gathering, MethodEntry, ParameterizedMethod, Pass, PilotPass, PreparedMethod, SceneTraits};
use crate::estimate::{RadiusRule, Region, ShardSums};
use crate::math::Rgb;
use crate::math::random::{PassRandom, PathRandom, Stream, dimension};
use crate::scene::Scene;
use crate::scene::geometry::ray::{largest, position_error};
use crate::scene::material::Lobes;
use crate::transport::Counters;
use crate::transport::camera_walk::{CameraWalk, GatherPoint};
use crate::transport::counters::Step;
use crate::transport::emission_learning::GuideParts;
use crate::transport::hit_point::HitPoint;
use crate::transport::occlusion::Occlusion;
use crate::transport::photon_map::{OriginPhoton, PhotonMap};
use crate::transport::shading;

/// Specular surfaces up to this many segments are followed in all their directions, later ones in one at random.
const SPLIT_SEGMENTS: u32 = 4;
/// The pass index that addresses the random numbers of hit points.
const HIT_POINT_PASS: u32 = u32::MAX;

/// The row of the table.
pub(crate) const ENTRY: MethodEntry = MethodEntry {
    name: "ppm",
    also_called: &["progressive_photon_mapping"],
    summary: "progressive photon mapping: hit points fixed for the whole job, photons anew every pass",
    cannot_sample: "more camera paths than samples_per_pixel: edges and lenses stay as noisy as those leave them",
    reference: "Hachisuka, Ogaki & Jensen 2008",
    bias: Bias::Shrinks,
    parameters: Parameters::HELP,
    negative_lobes: false,
    media: false,
    read: read_method::<Parameters>,
};

bounded! {
    /// A number of camera paths per pixel.
    struct Samples(u32), [1 to 64]
}

parameters! {
    /// Parameters of `ppm`.
    struct Parameters {
        alpha: OpenUnit = ALPHA,
        radius_rule: RadiusRule = RADIUS_RULE,
        photons_per_pass: Auto<PhotonCount> = PHOTONS,
        initial_radius: Auto<Radius> = GATHER_RADIUS,
        max_depth: Depth = MAX_DEPTH,
        rr_depth: RouletteDepth = RR_DEPTH,
        direct: DirectLight = DIRECT,
        light_picks: LightPicks = LIGHT_PICKS,
        emission: PhotonEmission = EMISSION,
        occlusion: Occlusion = OCCLUSION,
        passes: Passes = PASSES,
        samples_per_pixel: Samples =
            parameter("hit points per pixel, fixed for the whole job", Samples::new(4).expect("in range"), "4"),
    }
}

impl ParameterizedMethod for Parameters {
    fn settle_photons(&mut self, pixels: u64) -> u32 {
        self.photons_per_pass.settle(pixels)
    }

    fn passes(&self) -> u32 {
        self.passes.get()
    }

    fn gathering(&self) -> Gathering {
        Gathering::ShrinkingDiscs { rule: self.radius_rule, alpha: self.alpha.get() }
    }

    fn may_guide_photons(&self) -> bool {
        self.emission.of_paths() != Emission::Power
    }

    fn proposals(&self) -> &'static [Step] {
        self.emission.proposals()
    }

    fn light_sampling(&self) -> Option<LightSampling> {
        let sampling = LightSampling::gathering(self.light_picks, limits(self.max_depth, self.rr_depth));
        (self.direct == DirectLight::Sample).then_some(sampling)
    }

    fn futile_in(&self, traits: SceneTraits) -> Option<&'static str> {
        self.direct.futile_in(traits)
    }

    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod> {
        let (low, high) = scene.geometry.bounds();
        let error = position_error(largest(low).max(largest(high)));
        let passes = PhotonPasses {
            scene,
            seed,
            limits: limits(self.max_depth, self.rr_depth),
            direct: self.direct,
            follows_narrow: false,
            photons_per_pass,
            first_radius: self.initial_radius.meters(),
            emission: self.emission.of_paths(),
            chains: self.emission == PhotonEmission::Metropolis,
            guide_parts: GuideParts::Cells,
            occlusion: self.occlusion,
        };
        Box::new(Ppm {
            passes,
            radius_rule: self.radius_rule,
            samples_per_pixel: self.samples_per_pixel.get(),
            error,
            cache: Mutex::new(HashMap::new()),
        })
    }
}

struct Ppm {
    passes: PhotonPasses,
    radius_rule: RadiusRule,
    samples_per_pixel: u32,
    /// Bound on the rounding error of any position in the scene, m.
    error: f32,
    /// Hit points per region, made when first needed.
    cache: Mutex<HashMap<Region, Arc<HitPoints>>>,
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
            let lobes = scene.lobes_at(point.hit.shape);
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
        map: &PhotonMap<f32>,
        points: &[HitPoint],
        random: &PassRandom,
        (first_point, radius_squared): (usize, f32),
        counters: &mut Counters,
    ) -> (Rgb, Found) {
        let (mut radiance, mut found) = (Rgb::ZERO, Found::default());
        let share = 1.0 / self.samples_per_pixel as f32;
        let disc = (radius_squared * pass.scale, self.radius_rule);
        for (index, hit_point) in points.iter().enumerate() {
            let point = hit_point.gather_point(self.error);
            let random = random.path((first_point + index) as u32);
            radiance += point.throughput * self.passes.direct_light(&point, &random, counters);
            self.passes.add_gathered(map, (&point, point.throughput * share), disc, &mut found, counters);
        }
        found.gathered.photons *= share;
        // The discs of a pixel lie over each other and find the same photons, so that what one brings comes at once.
        found.evenness.squares *= self.samples_per_pixel as f32;
        (radiance * share, found)
    }
}

impl PreparedMethod for Ppm {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        let hit_points = self.hit_points(pass.region, cancel)?;
        let photons = PhotonsOf::pass(pass);
        let (map, mut total) =
            self.passes.trace_photons::<OriginPhoton>(&photons, pass.typical_radius_squared, cancel)?;
        let width = self.passes.scene.width as usize;
        let random = PassRandom::of_pixels(self.passes.seed, Stream::Camera, pass.index);
        // Random numbers are addressed by the hit point's place in its row, which no region changes.
        let rows = sums.rows(width).into_par_iter().enumerate();
        let counters: Vec<Counters> = rows
            .map(|(row, sums)| {
                let mut counters = Counters::default();
                if cancel.load(Ordering::Relaxed) {
                    return counters;
                }
                for (column, tally) in sums.tallies.iter_mut().enumerate() {
                    let pixel = row * width + column;
                    let range = hit_points.first[pixel] as usize..hit_points.first[pixel + 1] as usize;
                    let picture_pixel = pass.region.row_start as usize * width + pixel;
                    let address = picture_pixel.wrapping_mul(MOST_POINTS_PER_PIXEL);
                    let radius = pass.radius_squared[pixel];
                    let points = &hit_points.points[range];
                    let (radiance, found) =
                        self.trace_pixel(pass, &map, points, &random, (address, radius), &mut counters);
                    let radiance = radiance + Rgb::from_array(hit_points.seen[pixel]);
                    add_to_tally(tally, pass, radiance, &found.gathered, &mut counters);
                    add_evenness(sums.evenness.get_mut(column), pass, &found.evenness);
                }
                counters
            })
            .collect();
        counters.into_iter().for_each(|counters| total += counters);
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let region = Region { row_start: 0, row_end: self.passes.scene.height };
        let hit_points = self.hit_points(region, cancel)?;
        let random = PassRandom::of_pixels(self.passes.seed, Stream::PilotCamera, PILOT_PASS);
        let view = KeptPoints { ppm: self, hit_points: &hit_points, random };
        let mut found = self.passes.pilot(&view, cancel)?;
        found.counters.rays += 2 * hit_points.points.len() as u64;
        Some(PilotPass::with_radii(found.radius_squared, found.counters).and_guide(found.guide))
    }
}

/// The hit points of the whole picture, as the pilot looks at them.
struct KeptPoints<'a> {
    ppm: &'a Ppm,
    hit_points: &'a HitPoints,
    random: PassRandom,
}

impl KeptPoints<'_> {
    fn range(&self, pixel: usize) -> Range<usize> {
        self.hit_points.first[pixel] as usize..self.hit_points.first[pixel + 1] as usize
    }
}

impl PilotView for KeptPoints<'_> {
    fn visit(
        &self,
        pixel: usize,
        counters: &mut Counters,
        visit: &mut dyn FnMut(&GatherPoint, &PathRandom, &mut Counters),
    ) -> Rgb {
        let share = 1.0 / self.ppm.samples_per_pixel as f32;
        let address = pixel.wrapping_mul(MOST_POINTS_PER_PIXEL);
        for (index, hit_point) in self.hit_points.points[self.range(pixel)].iter().enumerate() {
            let mut point = hit_point.gather_point(self.ppm.error);
            point.throughput *= share;
            visit(&point, &self.random.path((address + index) as u32), counters);
        }
        Rgb::from_array(self.hit_points.seen[pixel])
    }

    fn radius_point(&self, pixel: usize, _: &mut Counters) -> Option<GatherPoint> {
        let mut point = self.hit_points.points.get(self.range(pixel))?.first()?.gather_point(self.ppm.error);
        // The straight distance stands for the path's: hit points do not keep it.
        point.path_length = self.ppm.passes.scene.camera.distance_to(point.hit.position);
        Some(point)
    }
}

/// Spaces the random number addresses of pixels apart; a pixel with more hit points shares some with its neighbour, which
/// is harmless: no estimate compares them.
const MOST_POINTS_PER_PIXEL: usize = 256;
