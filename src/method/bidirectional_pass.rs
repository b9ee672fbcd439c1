//! One pass of the methods that make paths from two ends: light subpaths first, kept where the method connects or merges them;
//! then a camera subpath per pixel, joined with them.
//!
//! Memory: 80 bytes per vertex that is kept to be connected, 52 per photon (twice as many with chains) that is kept to be merged. Roulette keeps their number near the number of light
//! subpaths times their mean length, which grows with the reflectance of the scene.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::bidirectional_settings::{MergeSettings, PassSettings};
use super::parameter_values::{Auto, DirectLight};
use super::photon_pass::{PhotonPasses, add_to_tally};
use super::pilot::CameraPaths;
use super::{Pass, PilotPass, PreparedMethod};
use crate::estimate::{PixelTally, Region, ShardSums};
use crate::math::Rgb;
use crate::math::random::{PassRandom, PathRandom, Stream};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::bidirectional::{
    CameraWalk, LightWalk, MergePhoton, MergeRecord, Merging, StoredVertex, Techniques, Vertex, Weighting, connect,
    direct_light, merge, to_camera,
};
use crate::transport::emission_learning::GuideParts;
use crate::transport::first_radius::FIRST_GATHER_PHOTONS;
use crate::transport::occlusion::Occlusion;
use crate::transport::photon_map::{Gathered, Grid, Nearest, PhotonChunk, PhotonMap};

/// Light subpaths per chunk, which one thread traces.
const PATHS_PER_CHUNK: u32 = 2048;

/// Of the area in which `sppm` would gather at first: every vertex of a path is merged, so each can do with fewer photons.
const MERGED_SHARE: f32 = 0.25;

/// Where the nearest photons give the radius, the search ends at so many times the area that they are expected in.
const SEARCHED_AREA: f32 = 4.0;

/// A scene and settings, ready to trace.
pub(crate) struct BidirectionalPasses {
    scene: Arc<Scene>,
    pub(super) seed: u64,
    settings: PassSettings,
    weighting: Weighting,
    pub(super) light_paths: u32,
    /// Finds first radii as `sppm` does.
    pilot: PhotonPasses,
}

/// What a chunk of light subpaths leaves.
#[derive(Default)]
struct LightChunk {
    /// Those that are connected.
    vertices: Vec<StoredVertex>,
    /// Where the vertices of each subpath end.
    ends: Vec<u32>,
    /// Those that are merged.
    photons: Vec<MergePhoton>,
    /// How much chains seek each subpath, where there are chains.
    targets: Vec<f64>,
    /// What the camera sees: index of the pixel in the region, radiance.
    splats: Vec<(u32, Rgb)>,
    counters: Counters,
}

/// All light subpaths of a pass.
#[derive(Default)]
struct LightPaths {
    vertices: Vec<StoredVertex>,
    ends: Vec<u32>,
    map: Option<PhotonMap<MergeRecord>>,
    /// As many subpaths as weights take photons to come from.
    merged: f32,
}

impl LightPaths {
    fn new(chunks: Vec<LightChunk>, map: Option<PhotonMap<MergeRecord>>, merged: f32) -> Self {
        let mut paths = Self { map, merged, ..Self::default() };
        for chunk in chunks {
            let first = paths.vertices.len() as u32;
            paths.ends.extend(chunk.ends.iter().map(|end| first + end));
            paths.vertices.extend(chunk.vertices);
        }
        paths
    }

    /// The vertices of subpath `path`.
    fn range(&self, path: usize) -> Range<usize> {
        let start = if path == 0 { 0 } else { self.ends[path - 1] };
        start as usize..self.ends[path] as usize
    }
}

impl BidirectionalPasses {
    /// Passes with `light_paths` light subpaths each.
    pub(crate) fn new(scene: Arc<Scene>, settings: PassSettings, light_paths: u32, seed: u64) -> Self {
        let pilot = PhotonPasses {
            scene: scene.clone(),
            seed,
            limits: settings.limits,
            direct: DirectLight::Photons,
            follows_narrow: true,
            photons_per_pass: light_paths,
            first_radius: settings.merging.first_radius,
            chains: false,
            emission: settings.emission,
            guide_parts: GuideParts::Lights,
            occlusion: Occlusion::Off,
        };
        let weighting = settings.weighting(light_paths);
        Self { scene, seed, settings, weighting, light_paths, pilot }
    }

    fn uses(&self, techniques: Techniques) -> bool {
        self.settings.uses(techniques)
    }

    /// Whether there are light subpaths.
    fn traces_light(&self) -> bool {
        self.uses(Techniques::CAMERA) || self.uses(Techniques::CONNECT) || self.uses(Techniques::MERGE)
    }

    fn camera_walk<'a>(&'a self, random: &'a PassRandom) -> CameraWalk<'a> {
        let PassSettings { techniques, mut limits, selection, .. } = self.settings;
        if techniques == Techniques::CAMERA {
            // All that is left to camera subpaths is light that is seen directly.
            limits.max_depth = Some(1);
        }
        CameraWalk { scene: &self.scene, limits, weighting: self.weighting, selection, random }
    }

    /// ηᵝ of a pixel, counted in the region, where photons are taken to come from `paths` light subpaths.
    fn acceptance(&self, pass: &Pass<'_>, pixel: usize, paths: f32) -> f32 {
        if !self.uses(Techniques::MERGE) {
            return 0.0;
        }
        let radius_squared = pass.radius_squared[pixel] * pass.scale;
        let area_share =
            if self.settings.merging.neighbors == 0 { radius_squared } else { radius_squared / SEARCHED_AREA };
        self.weighting.acceptance(area_share, paths)
    }

    /// The walk of the light subpaths of a pass.
    pub(super) fn light_walk<'a>(&'a self, random: &'a PassRandom) -> LightWalk<'a> {
        LightWalk { scene: &self.scene, limits: self.settings.limits, weighting: self.weighting, random }
    }

    /// Traces the light subpaths `paths`; chains weigh the photons of each.
    fn light_chunk(&self, pass: &Pass<'_>, random: &PassRandom, paths: Range<u32>, merged: &Merged<'_>) -> LightChunk {
        let walk = self.light_walk(random);
        let mut chunk = LightChunk::default();
        let LightChunk { vertices, ends, photons, targets, splats, counters } = &mut chunk;
        let keeps = u64::from(self.uses(Techniques::MERGE) || self.uses(Techniques::CONNECT));
        for path in paths {
            let first = photons.len();
            walk.trace(path, counters, |vertex, random, counters| {
                if self.uses(Techniques::CAMERA) {
                    self.splat(&walk, (pass, merged.paths), vertex, random, splats, counters);
                }
                if self.uses(Techniques::MERGE) {
                    photons.extend(MergePhoton::new(vertex));
                }
                if self.uses(Techniques::CONNECT) {
                    vertices.push(StoredVertex::new(vertex));
                }
                counters.photons_stored += keeps;
            });
            ends.push(vertices.len() as u32);
            targets.extend(merged.weigh.map(|weigh| weigh(&mut photons[first..])));
        }
        chunk
    }

    fn splat(
        &self,
        walk: &LightWalk<'_>,
        (pass, merged): (&Pass<'_>, f32),
        vertex: &Vertex,
        random: &PathRandom,
        splats: &mut Vec<(u32, Rgb)>,
        counters: &mut Counters,
    ) {
        let Some(seen) = to_camera(walk, &self.settings.selection, vertex, random, counters) else { return };
        let region = pixels_of(pass.region, self.scene.width);
        seen.for_each_pixel(&self.scene, |pixel, filter| {
            if region.contains(&pixel) {
                let pixel = pixel - region.start;
                let weight = seen.weight(&self.weighting, self.acceptance(pass, pixel as usize, merged));
                let radiance = seen.radiance * (filter / self.weighting.light_paths);
                splats.push((pixel, self.settings.selection.shown(radiance, weight)));
            }
        });
    }

    /// Traces all light subpaths; what the camera sees of them is added to `pixels`.
    fn light_paths(
        &self,
        pass: &Pass<'_>,
        pixels: &mut [PixelTally],
        total: &mut Counters,
        cancel: &AtomicBool,
    ) -> Option<LightPaths> {
        let random = PassRandom::independent(self.seed, Stream::Photon, pass.index);
        let importance = match self.settings.chains {
            true => self.pilot.importance_map(pass.index, total),
            false => None,
        };
        let Some(importance) = importance else {
            let merged = Merged { paths: self.light_paths as f32, weigh: None };
            let mut chunks = self.light_chunks(pass, &random, &merged, cancel)?;
            self.show(pass, &chunks, pixels, total);
            let grid = self.grid(pass, self.light_paths);
            let map = self.uses(Techniques::MERGE).then(|| photon_map(&mut chunks, Vec::new(), grid));
            return Some(LightPaths::new(chunks, map, merged.paths));
        };
        let chains = self.chains(pass, &random, &importance);
        let tried = chains.tried(cancel)?;
        let weigh = |photons: &mut [MergePhoton]| chains.weigh(&tried, photons);
        let merged = Merged { paths: tried.visible_paths(), weigh: Some(&weigh) };
        let mut chunks = self.light_chunks(pass, &random, &merged, cancel)?;
        self.show(pass, &chunks, pixels, total);
        let targets: Vec<f64> = chunks.iter_mut().flat_map(|chunk| std::mem::take(&mut chunk.targets)).collect();
        let grid = self.grid(pass, self.light_paths.saturating_mul(2));
        let (chained, counted) = chains.from(&tried, &targets, &grid, cancel)?;
        *total += counted;
        total.rays += tried.rays;
        total.photons_emitted = chains.paths();
        let map = photon_map(&mut chunks, chained, grid);
        Some(LightPaths::new(chunks, Some(map), merged.paths))
    }

    fn light_chunks(
        &self,
        pass: &Pass<'_>,
        random: &PassRandom,
        merged: &Merged<'_>,
        cancel: &AtomicBool,
    ) -> Option<Vec<LightChunk>> {
        (0..self.light_paths.div_ceil(PATHS_PER_CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let first = chunk * PATHS_PER_CHUNK;
                let paths = first..self.light_paths.min(first.saturating_add(PATHS_PER_CHUNK));
                (!cancel.load(Ordering::Relaxed)).then(|| self.light_chunk(pass, random, paths, merged))
            })
            .collect()
    }

    /// Adds what the camera sees of light subpaths to `pixels`.
    fn show(&self, pass: &Pass<'_>, chunks: &[LightChunk], pixels: &mut [PixelTally], total: &mut Counters) {
        for chunk in chunks {
            *total += chunk.counters;
            for (pixel, radiance) in &chunk.splats {
                add_to_tally(&mut pixels[*pixel as usize], pass, *radiance, &Gathered::default(), total);
            }
        }
    }

    /// Cells for the photons of so many paths.
    fn grid(&self, pass: &Pass<'_>, paths: u32) -> Grid {
        let (low, high) = self.scene.geometry.bounds();
        // The search for the nearest begins with two cells, about where it ends.
        let cells_per_radius = if self.settings.merging.neighbors == 0 { 0.5 } else { 4.0 };
        let cell = pass.typical_radius_squared.sqrt() / cells_per_radius;
        Grid::new(low, high, cell, 4 * u64::from(paths).max(1 << 14))
    }
}

/// What is known of merged photons before light subpaths are traced.
struct Merged<'a> {
    /// As many subpaths as weights take them to come from.
    paths: f32,
    /// Makes the photons of a subpath count beside those of chains; how much chains seek it.
    weigh: Option<&'a Weigh<'a>>,
}

type Weigh<'a> = dyn Fn(&mut [MergePhoton]) -> f64 + Sync + 'a;

/// Sorts the photons of all chunks by place, and those of chains with them.
fn photon_map(chunks: &mut [LightChunk], chained: Vec<PhotonChunk<MergePhoton>>, grid: Grid) -> PhotonMap<MergeRecord> {
    let sort = |chunk: &mut LightChunk| PhotonChunk::sort(&std::mem::take(&mut chunk.photons), &grid);
    let mut sorted: Vec<PhotonChunk<MergePhoton>> = chunks.par_iter_mut().map(sort).collect();
    sorted.extend(chained);
    PhotonMap::build(&sorted, grid)
}

/// The camera subpaths of a pass, on one thread.
struct CameraPass<'a> {
    passes: &'a BidirectionalPasses,
    pass: &'a Pass<'a>,
    walk: CameraWalk<'a>,
    paths: &'a LightPaths,
    /// The light subpath that a pixel's camera subpath is connected with.
    own: Vec<Vertex>,
    nearest: Nearest,
    counters: Counters,
}

impl CameraPass<'_> {
    /// Adds the camera subpath of `pixel`, counted in the region.
    fn trace_pixel(&mut self, pixel: usize, tally: &mut PixelTally) {
        let Self { passes, pass, walk, paths, own, nearest, counters } = self;
        let index = pixels_of(pass.region, passes.scene.width).start + pixel as u32;
        let acceptance = passes.acceptance(pass, pixel, paths.merged);
        own.clear();
        if passes.uses(Techniques::CONNECT) {
            let path = (index % passes.light_paths) as usize;
            own.extend(paths.vertices[paths.range(path)].iter().map(StoredVertex::unpack));
        }
        let mut gathered = Gathered::default();
        let radiance = walk.trace(index, acceptance, counters, |camera, random, counters| {
            let mut radiance = Rgb::ZERO;
            if passes.uses(Techniques::DIRECT) {
                radiance += direct_light(walk, camera, random, acceptance, counters);
            }
            for light in own.iter() {
                radiance += connect(walk, camera, light, random, acceptance, counters);
            }
            if let Some(map) = &paths.map {
                let MergeSettings { kernel, neighbors, occlusion, .. } = passes.settings.merging;
                let merging = Merging { photons: map, records: map.extras(), kernel, neighbors, occlusion };
                let radius_squared = pass.radius_squared[pixel] * pass.scale;
                let area = (radius_squared, acceptance);
                gathered.add(&merge(walk, camera, &merging, area, nearest, counters), Rgb::ONE);
            }
            radiance
        });
        add_to_tally(tally, pass, radiance, &gathered, counters);
    }
}

/// The pixels of a region, counted in the picture.
fn pixels_of(region: Region, width: u32) -> Range<u32> {
    region.row_start * width..region.row_end * width
}

impl PreparedMethod for BidirectionalPasses {
    fn trace_pass(&self, pass: &Pass<'_>, sums: &mut ShardSums, cancel: &AtomicBool) -> Option<Counters> {
        let mut total = Counters::default();
        let paths = match self.traces_light() {
            true => self.light_paths(pass, &mut sums.tallies, &mut total, cancel)?,
            false => LightPaths::default(),
        };
        let random = PassRandom::of_pixels(self.seed, Stream::Camera, pass.index);
        let walk = self.camera_walk(&random);
        let width = self.scene.width as usize;
        let counters: Vec<Counters> = sums
            .tallies
            .par_chunks_mut(width)
            .enumerate()
            .map(|(row, tallies)| {
                let (own, nearest, counters) = (Vec::new(), Nearest::default(), Counters::default());
                let mut camera = CameraPass { passes: self, pass, walk, paths: &paths, own, nearest, counters };
                if !cancel.load(Ordering::Relaxed) {
                    for (column, tally) in tallies.iter_mut().enumerate() {
                        camera.trace_pixel(row * width + column, tally);
                    }
                }
                camera.counters
            })
            .collect();
        counters.into_iter().for_each(|counters| total += counters);
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        if self.uses(Techniques::MERGE) {
            let found = self.pilot.pilot(&CameraPaths::new(&self.pilot), cancel)?;
            let (mut radii, counters) = (found.radius_squared, found.counters);
            if self.pilot.first_radius == Auto::Auto {
                let share = match self.settings.merging.neighbors {
                    0 => MERGED_SHARE,
                    neighbors => SEARCHED_AREA * neighbors as f32 / FIRST_GATHER_PHOTONS,
                };
                radii.iter_mut().for_each(|radius_squared| *radius_squared *= share);
            }
            return Some(PilotPass::with_radii(radii, counters).and_guide(found.guide));
        }
        let guide = match self.pilot.may_guide() && self.traces_light() {
            true => self.pilot.pilot(&CameraPaths::new(&self.pilot), cancel)?.guide,
            false => None,
        };
        Some(PilotPass::of_a_pass(self, &self.scene, cancel)?.and_guide(guide))
    }
}
