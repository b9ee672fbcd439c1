//! A balanced kd-tree in an array [Bentley 1975, "Multidimensional binary search trees used for associative searching"; Jensen 1996]: the other
//! structure that photons can be looked up in.
//!
//! The photon in the middle of a run splits it at its own place, across the longest side of the run's box: those before it lie on one
//! side, those behind it on the other. So the tree needs no pointers, only a byte for the axis, and photons of a neighbourhood
//! lie together. Runs of [`LEAF`] photons are searched one by one. The tree depends on the photons alone, not on the order in which they come.

use std::cmp::Ordering;

use super::gather::FLATNESS;
use super::photon::OriginPhoton;
use super::{GatherQuery, Nearest, OriginLookup, Photon, PhotonLookup, PhotonMap, PhotonWith, StoredPhoton};
use crate::math::Vec3;

/// Photons of a run that is not split any more.
const LEAF: usize = 8;
/// From so many photons on both halves of a run are sorted at once.
const PARALLEL: usize = 1 << 13;

/// The photons of one pass in a kd-tree.
pub struct KdTree<R = Photon> {
    photons: Vec<R>,
    /// Of the photon in the middle of each run that is split: 0, 1 or 2.
    axes: Vec<u8>,
}

impl<E: Copy + Default + Send + Sync> From<PhotonMap<E>> for KdTree<PhotonWith<E>> {
    fn from(map: PhotonMap<E>) -> Self {
        Self::build((0..map.len()).map(|index| map.record(index)).collect())
    }
}

impl<R: StoredPhoton> KdTree<R> {
    /// Sorts photons into a tree.
    pub fn build(mut photons: Vec<R>) -> Self {
        let mut axes = vec![0; photons.len()];
        sort(&mut photons, &mut axes);
        Self { photons, axes }
    }

    /// The photon with an index, and whatever else is kept of it.
    #[inline]
    pub fn record(&self, index: usize) -> &R {
        &self.photons[index]
    }

    /// Shows the index of every photon of the run that may lie within √`radius_squared` of `center`, in ascending order.
    fn for_each_near(&self, run: Run, center: Vec3, radius: f32, visit: &mut impl FnMut(usize)) {
        let Some((before, middle, behind)) = run.split() else {
            (run.first..run.last).for_each(visit);
            return;
        };
        let beyond = self.beyond(middle, center);
        if beyond <= radius {
            self.for_each_near(before, center, radius, visit);
        }
        visit(middle);
        if beyond >= -radius {
            self.for_each_near(behind, center, radius, visit);
        }
    }

    /// Takes the photons of a run that are nearer than what was found already, the nearer side first.
    fn take_nearest(&self, run: Run, query: &GatherQuery, count: usize, found: &mut Nearest) {
        let Some((before, middle, behind)) = run.split() else {
            (run.first..run.last).for_each(|index| self.take(index, query, count, found));
            return;
        };
        let beyond = self.beyond(middle, query.position);
        let (near, far) = if beyond <= 0.0 { (before, behind) } else { (behind, before) };
        self.take_nearest(near, query, count, found);
        self.take(middle, query, count, found);
        if beyond * beyond < found.radius_squared() {
            self.take_nearest(far, query, count, found);
        }
    }

    #[inline]
    fn take(&self, index: usize, query: &GatherQuery, count: usize, found: &mut Nearest) {
        let Some(seen) = query.look(&self.photons[index].unpacked()) else { return };
        let distance_squared = seen.least_radius_squared();
        if distance_squared < found.radius_squared() {
            found.take(distance_squared, index);
            found.forget(count);
        }
    }

    /// How far `point` lies behind the plane at which a photon splits its run, m.
    #[inline]
    fn beyond(&self, photon: usize, point: Vec3) -> f32 {
        let axis = usize::from(self.axes[photon]);
        point[axis] - self.photons[photon].position()[axis]
    }

    fn all(&self) -> Run {
        Run { first: 0, last: self.photons.len() }
    }
}

/// Photons from `first` on and before `last`.
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    last: usize,
}

impl Run {
    /// The run before the photon in the middle, that photon, and the run behind it; `None` for a leaf.
    #[inline]
    fn split(self) -> Option<(Self, usize, Self)> {
        let Self { first, last } = self;
        if last - first <= LEAF {
            return None;
        }
        let middle = first + (last - first) / 2;
        Some((Self { first, last: middle }, middle, Self { first: middle + 1, last }))
    }
}

/// Sorts a run so that its middle splits it, and then both sides.
fn sort<R: StoredPhoton>(photons: &mut [R], axes: &mut [u8]) {
    if photons.len() <= LEAF {
        photons.sort_unstable_by(|a, b| compare(a, b, 0));
        return;
    }
    let axis = longest_side(photons);
    let middle = photons.len() / 2;
    photons.select_nth_unstable_by(middle, |a, b| compare(a, b, axis));
    axes[middle] = axis as u8;
    let ((before, rest), (axes_before, axes_rest)) = (photons.split_at_mut(middle), axes.split_at_mut(middle));
    let (behind, axes_behind) = (&mut rest[1..], &mut axes_rest[1..]);
    if before.len() < PARALLEL {
        sort(before, axes_before);
        sort(behind, axes_behind);
    } else {
        rayon::join(|| sort(before, axes_before), || sort(behind, axes_behind));
    }
}

/// By the coordinate along `axis`, and where that is the same by all else, so that only photons that are the same are equal.
fn compare<R: StoredPhoton>(a: &R, b: &R, axis: usize) -> Ordering {
    let by_rest = || {
        let (a, b) = (a.unpacked(), b.unpacked());
        let places = a.position.map(f32::to_bits).cmp(&b.position.map(f32::to_bits));
        let words = |photon: &Photon| (photon.direction, photon.normal_and_segments, photon.flux.map(f32::to_bits));
        places.then_with(|| words(&a).cmp(&words(&b)))
    };
    a.position()[axis].total_cmp(&b.position()[axis]).then_with(by_rest)
}

fn longest_side<R: StoredPhoton>(photons: &[R]) -> usize {
    let around = |(low, high): (Vec3, Vec3), photon: &R| {
        let position = Vec3::from_array(photon.position());
        (low.min(position), high.max(position))
    };
    let (low, high) = photons.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), around);
    (high - low).max_position()
}

impl<R: StoredPhoton> PhotonLookup for KdTree<R> {
    fn visit_disc(&self, query: &GatherQuery, mut visit: impl FnMut(usize, bool)) {
        let flatness = FLATNESS * query.radius_squared.sqrt();
        self.for_each_near(self.all(), query.position, query.radius_squared.sqrt(), &mut |index| {
            let Some(seen) = query.look(&self.photons[index].unpacked()) else { return };
            if seen.distance_squared < query.radius_squared && seen.height.abs() <= flatness {
                visit(index, seen.distance_squared < 0.5 * query.radius_squared);
            }
        });
    }

    fn nearest(&self, query: &GatherQuery, count: usize, found: &mut Nearest) {
        found.begin(query.radius_squared);
        self.take_nearest(self.all(), query, count, found);
        found.end(count);
    }

    #[inline]
    fn photon(&self, index: usize) -> Photon {
        self.photons[index].unpacked()
    }

    fn len(&self) -> usize {
        self.photons.len()
    }

    fn bytes(&self) -> usize {
        size_of_val(self.photons.as_slice()) + size_of_val(self.axes.as_slice())
    }
}

impl OriginLookup for KdTree<OriginPhoton> {
    #[inline]
    fn origin_distance(&self, index: usize) -> f32 {
        self.record(index).extra
    }
}
