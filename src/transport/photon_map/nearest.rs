//! The photons nearest to a point.
//!
//! A photon's distance is the least radius whose disc it is found in: its distance in space, or its
//! height over the tangent plane in units of the disc's thickness, whichever is larger.
//!
//! With `r` the distance of the k-th photon, the k − 1 nearer ones over `π·r²` estimate a density without bias where it is
//! uniform; k of them would give k/(k − 1) times too much. Where fewer than k lie within the largest radius, all of them
//! over its disc do, and so does the mixture of both cases.

use super::gather::{FLATNESS, GatherQuery, LANES, LaneTest};
use super::{PhotonColumns, PhotonMap};

/// The radius that a search starts with, in cells; it doubles until enough photons are found.
pub const FIRST_SEARCH_CELLS: f32 = 2.0;

/// What [`PhotonLookup::nearest`](super::PhotonLookup::nearest) found; kept between queries, it spares an allocation each.
#[derive(Debug, Default)]
pub struct Nearest {
    /// Bits of the squared distance in the upper half, the photon's index in the lower: sorted as the pair is.
    keys: Vec<u64>,
    /// Photons at this squared distance or farther are of no use any more, m².
    radius_squared: f32,
}

impl Nearest {
    /// The square of the radius inside which all photons were found, m².
    pub fn radius_squared(&self) -> f32 {
        self.radius_squared
    }

    /// Squared distance, m², and index of every photon found, in no particular order but always the same.
    pub fn photons(&self) -> impl ExactSizeIterator<Item = (f32, usize)> {
        self.keys.iter().map(|key| (f32::from_bits((key >> 32) as u32), (key & 0xffff_ffff) as usize))
    }

    /// Begins a search within √`radius_squared`.
    pub fn begin(&mut self, radius_squared: f32) {
        self.keys.clear();
        self.radius_squared = radius_squared;
    }

    /// Takes a photon that lies within the radius, m²; others are of no use.
    #[inline(always)]
    pub fn take(&mut self, distance_squared: f32, index: usize) {
        self.keys.push(u64::from(distance_squared.to_bits()) << 32 | index as u64);
    }

    /// Forgets what is farther than the `count`-th, now and then: often enough to cost a constant number of steps per photon.
    #[inline(always)]
    pub fn forget(&mut self, count: usize) {
        if self.keys.len() >= 2 * count {
            self.trim(count);
        }
    }

    /// Ends a search: whether there were `count`, the last of which gave the radius and does not count.
    pub fn end(&mut self, count: usize) -> bool {
        let is_full = self.keys.len() >= count;
        if is_full {
            self.trim(count);
            self.keys.pop();
        }
        is_full
    }

    /// Keeps the `count` nearest, and moves the border to the last of them.
    fn trim(&mut self, count: usize) {
        let (_, last, _) = self.keys.select_nth_unstable(count - 1);
        self.radius_squared = f32::from_bits((*last >> 32) as u32);
        self.keys.truncate(count);
    }

    #[inline]
    fn scan<E>(&mut self, photons: &PhotonColumns<E>, [first, last]: [usize; 2], test: &LaneTest, count: usize) {
        for index in (first..last).step_by(LANES) {
            let seen = test.look(photons, index, last);
            let height = seen.height * (1.0 / FLATNESS);
            let distance_squared = seen.distance_squared.fast_max(height * height);
            let mut found = (distance_squared.simd_lt(self.radius_squared) & seen.suitable).to_bitmask();
            let distances = distance_squared.to_array();
            while found != 0 {
                let lane = found.trailing_zeros() as usize;
                self.take(distances[lane], index + lane);
                found &= found - 1;
            }
            self.forget(count);
        }
    }
}

impl<E> PhotonMap<E> {
    /// [`PhotonLookup::nearest`](super::PhotonLookup::nearest) with a radius that doubles.
    pub(super) fn find_nearest(&self, query: &GatherQuery, count: usize, found: &mut Nearest) {
        let test = LaneTest::new(query);
        let mut radius = FIRST_SEARCH_CELLS * self.grid.cell_side();
        loop {
            let radius_squared = (radius * radius).min(query.radius_squared);
            found.begin(radius_squared);
            let part = GatherQuery { radius_squared, ..*query };
            self.for_each_run(&part, |first, last| found.scan(&self.photons, [first, last], &test, count));
            if found.end(count) || radius_squared == query.radius_squared {
                return;
            }
            radius *= 2.0;
        }
    }
}
