//! Tracing and sorting a pass's photons in parallel, in an order that does not depend on the threads.
//!
//! Paths are traced in chunks; each chunk sorts its photons into 256 buckets of consecutive cells. Then every bucket
//! collects its photons from the chunks in order and counting-sorts them by cell. Both sorts are stable, so photons of a
//! cell stand in path order.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::photon::{OriginPhoton, Photon, PhotonColumns, PhotonColumnsMut, PhotonRecord, TracedPhoton};
use super::{Grid, OriginLookup, PhotonLookup, PhotonMap};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::transport::counters::Counters;
use crate::transport::photon_tracing::{PhotonSettings, trace_photon};

const BUCKETS: usize = 256;
/// Paths per chunk: enough work to hide scheduling, few enough to keep a chunk in the cache.
const PATHS_PER_CHUNK: u32 = 2048;

/// The photons of a chunk of paths, sorted by bucket.
pub struct PhotonChunk<R = Photon> {
    photons: Vec<R>,
    /// Index of the first photon of each bucket, and the count last.
    bucket_start: Vec<u32>,
}

/// Cells per bucket, as a power of two.
fn bucket_shift(grid: &Grid) -> u32 {
    let per_bucket = grid.cell_count().div_ceil(BUCKETS).next_power_of_two();
    per_bucket.trailing_zeros()
}

fn cell_of(grid: &Grid, photon: &Photon) -> usize {
    grid.cell(grid.coordinates(Vec3::from_array(photon.position)))
}

/// Emits the photons of a pass and traces them; `None` when `cancel` was set meanwhile.
pub fn trace<R: TracedPhoton>(
    scene: &Scene,
    settings: &PhotonSettings<'_>,
    grid: &Grid,
    cancel: &AtomicBool,
) -> Option<(Vec<PhotonChunk<R>>, Counters)> {
    let path = |path: u32, photons: &mut Vec<R>, counters: &mut Counters| {
        trace_photon(scene, settings, path, photons, counters);
    };
    trace_with(settings.paths, grid, cancel, path)
}

/// Traces `count` paths, each by `trace_path`, which appends the photons that it stores; `None` when `cancel` was set meanwhile.
pub fn trace_with<R: PhotonRecord>(
    count: u32,
    grid: &Grid,
    cancel: &AtomicBool,
    trace_path: impl Fn(u32, &mut Vec<R>, &mut Counters) + Sync,
) -> Option<(Vec<PhotonChunk<R>>, Counters)> {
    trace_chunks(count, cancel, |paths, counters| {
        let mut photons = Vec::with_capacity(4 * PATHS_PER_CHUNK as usize);
        for path in paths {
            trace_path(path, &mut photons, counters);
        }
        PhotonChunk::store(photons, grid, counters)
    })
}

/// Cuts the paths of a pass into chunks and has `trace` trace each of them; in the order of the paths. `None` when `cancel` was set
/// meanwhile.
pub fn trace_chunks<T: Send>(
    paths: u32,
    cancel: &AtomicBool,
    trace: impl Fn(Range<u32>, &mut Counters) -> T + Sync,
) -> Option<(Vec<T>, Counters)> {
    let traced: Option<Vec<(T, Counters)>> = (0..paths.div_ceil(PATHS_PER_CHUNK))
        .into_par_iter()
        .map(|chunk| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let first = chunk * PATHS_PER_CHUNK;
            let mut counters = Counters::default();
            let traced = trace(first..paths.min(first + PATHS_PER_CHUNK), &mut counters);
            Some((traced, counters))
        })
        .collect();
    let mut total = Counters::default();
    let chunks = traced?
        .into_iter()
        .map(|(chunk, counters)| {
            total += counters;
            chunk
        })
        .collect();
    Some((chunks, total))
}

fn drop_non_finite<R: PhotonRecord>(photons: &mut Vec<R>) -> u64 {
    let before = photons.len();
    let finite = |photon: &Photon| photon.flux.iter().chain(&photon.position).all(|value| value.is_finite());
    photons.retain(|record| finite(record.photon()));
    (before - photons.len()) as u64
}

impl<R: PhotonRecord> PhotonChunk<R> {
    /// Counts the photons that are finite and sorts them by bucket.
    pub fn store(mut photons: Vec<R>, grid: &Grid, counters: &mut Counters) -> Self {
        counters.non_finite += drop_non_finite(&mut photons);
        counters.photons_stored += photons.len() as u64;
        Self::sort(&photons, grid)
    }

    /// Sorts photons by bucket.
    pub fn sort(photons: &[R], grid: &Grid) -> Self {
        let shift = bucket_shift(grid);
        let buckets: Vec<u8> = photons.iter().map(|photon| (cell_of(grid, photon.photon()) >> shift) as u8).collect();
        let mut bucket_start = vec![0u32; BUCKETS + 1];
        for bucket in &buckets {
            bucket_start[*bucket as usize + 1] += 1;
        }
        for bucket in 0..BUCKETS {
            bucket_start[bucket + 1] += bucket_start[bucket];
        }
        let mut next = bucket_start.clone();
        let mut sorted = vec![R::default(); photons.len()];
        for (photon, bucket) in photons.iter().zip(&buckets) {
            let slot = &mut next[*bucket as usize];
            sorted[*slot as usize] = *photon;
            *slot += 1;
        }
        Self { photons: sorted, bucket_start }
    }

    fn bucket(&self, bucket: usize) -> &[R] {
        &self.photons[self.bucket_start[bucket] as usize..self.bucket_start[bucket + 1] as usize]
    }
}

/// One bucket of the sorted map, to be filled by one thread.
struct Bucket<'a, E> {
    index: usize,
    /// Index of the bucket's first photon in the map.
    first_photon: u32,
    cell_start: &'a mut [u32],
    photons: PhotonColumnsMut<'a, E>,
}

impl<E: Copy + Default + Send + Sync> PhotonMap<E> {
    /// Sorts chunks of photons into a map.
    pub fn build<R: PhotonRecord<Extra = E>>(chunks: &[PhotonChunk<R>], grid: Grid) -> Self {
        let shift = bucket_shift(&grid);
        let count = chunks.iter().map(|chunk| chunk.photons.len()).sum();
        let mut cell_start = vec![0u32; grid.cell_count() + 1];
        let mut photons = PhotonColumns::zeroed(count);
        split_buckets(chunks, shift, &mut cell_start, photons.as_mut())
            .into_par_iter()
            .for_each(|bucket| bucket.fill(chunks, &grid, shift));
        cell_start[grid.cell_count()] = count as u32;
        Self { grid, cell_start, photons }
    }
}

impl OriginLookup for PhotonMap<f32> {
    #[inline]
    fn origin_distance(&self, index: usize) -> f32 {
        self.extras()[index]
    }
}

impl PhotonMap<f32> {
    /// A map of those photons that `keep` wants, in the order that they have here.
    pub fn select(&self, grid: Grid, keep: impl Fn(&Photon) -> bool) -> Self {
        let all = (0..self.len()).map(|index| self.record(index));
        let photons: Vec<OriginPhoton> = all.filter(|record| keep(&record.photon)).collect();
        Self::build(&[PhotonChunk::sort(&photons, &grid)], grid)
    }
}

fn split_buckets<'a, R: PhotonRecord>(
    chunks: &[PhotonChunk<R>],
    shift: u32,
    mut cells: &'a mut [u32],
    mut columns: PhotonColumnsMut<'a, R::Extra>,
) -> Vec<Bucket<'a, R::Extra>> {
    let mut buckets = Vec::with_capacity(BUCKETS);
    let mut first_photon = 0;
    for index in 0..BUCKETS {
        let count: usize = chunks.iter().map(|chunk| chunk.bucket(index).len()).sum();
        let (cell_start, rest) = cells.split_at_mut(cells.len().min(1 << shift));
        cells = rest;
        let (photons, rest) = columns.split(count);
        columns = rest;
        buckets.push(Bucket { index, first_photon, cell_start, photons });
        first_photon += count as u32;
    }
    buckets
}

impl<E: Copy> Bucket<'_, E> {
    /// Counting sort by cell.
    fn fill<R: PhotonRecord<Extra = E>>(mut self, chunks: &[PhotonChunk<R>], grid: &Grid, shift: u32) {
        let first_cell = self.index << shift;
        let photons = || chunks.iter().flat_map(|chunk| chunk.bucket(self.index));
        let mut next = vec![0u32; self.cell_start.len() + 1];
        let cells: Vec<u32> = photons().map(|photon| (cell_of(grid, photon.photon()) - first_cell) as u32).collect();
        for cell in &cells {
            next[*cell as usize + 1] += 1;
        }
        for cell in 0..self.cell_start.len() {
            next[cell + 1] += next[cell];
            self.cell_start[cell] = self.first_photon + next[cell];
        }
        for (photon, cell) in photons().zip(&cells) {
            let slot = &mut next[*cell as usize];
            self.photons.set(*slot as usize, photon);
            *slot += 1;
        }
    }
}
