//! The density estimate's inner loop: photons in a disc around a point.
//!
//! A photon counts when it lies within the radius, near the tangent plane and on a surface that faces the same way.
//! Eight are tested at a time without branches; where their flux is all that counts they are summed so too. Their plain twin, a search through all photons, stands in `tests/agreement/gather_twin.rs`.

use wide::{f32x8, i32x8};

use super::photon::SCATTERED;
use super::{Nearest, Photon, PhotonColumns, PhotonLookup, PhotonMap};
use crate::math::{Rgb, Vec3};

/// How far a photon may lie off the tangent plane, in radii.
pub(super) const FLATNESS: f32 = 0.25;
/// The least cosine between the photon's surface normal and the gather point's, in units of the stored bytes (1/127).
const LEAST_NORMAL_COSINE: f32 = 0.7 * 127.0;

/// Where to gather.
#[derive(Clone, Copy, Debug)]
pub struct GatherQuery {
    /// Position, m.
    pub position: Vec3,
    /// Unit normal on the side that is looked at.
    pub normal: Vec3,
    /// R², m².
    pub radius_squared: f32,
    /// Photons with more segments do not count; 127 lets all count.
    pub most_segments: u32,
    /// Only photons that nothing but specular surfaces scattered count.
    pub caustics_only: bool,
    /// Photons on the other side of the surface count too.
    pub both_sides: bool,
}

impl GatherQuery {
    /// The square of the least radius whose disc holds `photon`, m².
    #[inline]
    pub fn distance_squared(&self, photon: &Photon) -> f32 {
        self.place(photon).least_radius_squared()
    }

    /// Where a photon lies.
    #[inline]
    fn place(&self, photon: &Photon) -> SeenPhoton {
        let offset = Vec3::from_array(photon.position) - self.position;
        SeenPhoton { distance_squared: offset.length_squared(), height: offset.dot(self.normal) }
    }

    /// A photon whatever its distance; `None` where it faces another way or is of a kind that does not count. What [`LaneTest`] tells of
    /// eight.
    #[inline]
    pub(super) fn look(&self, photon: &Photon) -> Option<SeenPhoton> {
        let cosine = photon.normal_bytes().dot(self.normal);
        let cosine = if self.both_sides { cosine.abs() } else { cosine };
        let segments = photon.normal_and_segments >> 24 & self.segments_mask();
        (cosine > LEAST_NORMAL_COSINE && segments <= self.most_segments).then(|| self.place(photon))
    }

    /// What of a photon's top byte is compared with `most_segments`: scattered photons exceed it where they do not count.
    #[inline]
    fn segments_mask(&self) -> u32 {
        if self.caustics_only { 0xff } else { 0xff & !SCATTERED }
    }
}

/// A photon as a query sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenPhoton {
    /// Squared distance, m².
    pub(super) distance_squared: f32,
    /// Height over the tangent plane, m.
    pub(super) height: f32,
}

impl SeenPhoton {
    /// The square of the least radius whose disc holds it, m².
    #[inline]
    pub(super) fn least_radius_squared(&self) -> f32 {
        let height = self.height * (1.0 / FLATNESS);
        self.distance_squared.max(height * height)
    }
}

/// What was found: flux of photons (W), or what surfaces reflect of it (W·sr⁻¹).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Sum of flux.
    pub flux: Rgb,
    /// Sum of the flux inside half the disc's area. Twice as much as it is what `flux` would be without half its bias.
    pub inner_flux: Rgb,
    /// Number of photons.
    pub photons: f32,
}

impl Gathered {
    /// Adds what another gather found, its flux times `factor`.
    #[inline]
    pub fn add(&mut self, other: &Self, factor: Rgb) {
        self.flux += other.flux * factor;
        self.inner_flux += other.inner_flux * factor;
        self.photons += other.photons;
    }

    /// Adds one photon.
    #[inline(always)]
    pub fn add_photon(&mut self, flux: Rgb, is_inner: bool) {
        self.flux += flux;
        self.inner_flux += if is_inner { flux } else { Rgb::ZERO };
        self.photons += 1.0;
    }
}

pub(super) const LANES: usize = 8;
const LANE: i32x8 = i32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);

#[derive(Default)]
struct LaneSums {
    flux: [f32x8; 3],
    inner_flux: [f32x8; 3],
    photons: f32x8,
}

/// Eight entries of a column, which is padded so that they always exist.
#[inline(always)]
fn eight<T: Copy>(column: &[T], index: usize) -> [T; LANES] {
    *column[index..].first_chunk().expect("columns are padded")
}

#[inline(always)]
fn lanes(column: &[f32], index: usize) -> f32x8 {
    f32x8::new(eight(column, index))
}

#[inline(always)]
fn dot(a: [f32x8; 3], b: [f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl<E: Sync> PhotonLookup for PhotonMap<E> {
    #[inline]
    fn gather(&self, query: &GatherQuery) -> Gathered {
        let mut sums = LaneSums::default();
        let test = LaneTest::new(query);
        self.for_each_run(query, |first, last| self.sum_run(first, last, &test, &mut sums));
        // Lane by lane: a sum in another order would depend on the machine.
        let total = |lanes: &f32x8| lanes.to_array().iter().sum::<f32>();
        Gathered {
            flux: Rgb::from_array([0, 1, 2].map(|channel| total(&sums.flux[channel]))),
            inner_flux: Rgb::from_array([0, 1, 2].map(|channel| total(&sums.inner_flux[channel]))),
            photons: total(&sums.photons),
        }
    }

    #[inline]
    fn visit_disc(&self, query: &GatherQuery, mut visit: impl FnMut(usize, bool)) {
        let test = LaneTest::new(query);
        self.for_each_run(query, |first, last| {
            for index in (first..last).step_by(LANES) {
                let (counts, inner) = test.count(&self.photons, index, last);
                let (mut found, inner) = (counts.to_bitmask(), inner.to_bitmask());
                while found != 0 {
                    let lane = found.trailing_zeros();
                    visit(index + lane as usize, inner >> lane & 1 != 0);
                    found &= found - 1;
                }
            }
        });
    }

    #[inline]
    fn nearest(&self, query: &GatherQuery, count: usize, found: &mut Nearest) {
        self.find_nearest(query, count, found);
    }

    #[inline]
    fn flux(&self, index: usize) -> Rgb {
        let [red, green, blue] = &self.photons.flux;
        Rgb::new(red[index], green[index], blue[index])
    }

    #[inline]
    fn photon(&self, index: usize) -> Photon {
        let columns = &self.photons;
        Photon {
            position: [0, 1, 2].map(|axis| columns.position[axis][index]),
            direction: columns.direction[index],
            normal_and_segments: columns.normal_and_segments[index],
            flux: [0, 1, 2].map(|channel| columns.flux[channel][index]),
        }
    }

    #[inline]
    fn direction(&self, index: usize) -> u32 {
        self.photons.direction[index]
    }

    fn len(&self) -> usize {
        self.cell_start.last().map_or(0, |count| *count as usize)
    }

    fn bytes(&self) -> usize {
        size_of_val(self.cell_start.as_slice()) + self.photons.bytes()
    }
}

impl<E> PhotonMap<E> {
    /// Calls `run` with the index range of each run of photons that may count.
    #[inline]
    pub(super) fn for_each_run(&self, query: &GatherQuery, mut run: impl FnMut(usize, usize)) {
        let radius = query.radius_squared.sqrt();
        let low = self.grid.coordinates(query.position - radius);
        let high = self.grid.coordinates(query.position + radius);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let first = self.cell_start[self.grid.cell([low[0], y, z])];
                let last = self.cell_start[self.grid.cell([high[0], y, z]) + 1];
                if first < last {
                    run(first as usize, last as usize);
                }
            }
        }
    }

    #[inline]
    fn sum_run(&self, first: usize, last: usize, test: &LaneTest, sums: &mut LaneSums) {
        for index in (first..last).step_by(LANES) {
            let (counts, inner) = test.count(&self.photons, index, last);
            sums.photons += counts & f32x8::ONE;
            for (channel, flux) in self.photons.flux.iter().enumerate() {
                let flux = lanes(flux, index);
                sums.flux[channel] += counts & flux;
                sums.inner_flux[channel] += inner & flux;
            }
        }
    }
}

/// A query, spread over the lanes.
pub(super) struct LaneTest {
    center: [f32x8; 3],
    normal: [f32x8; 3],
    radius_squared: f32,
    flatness: f32,
    segments_mask: i32x8,
    most_segments: i32x8,
    /// Clears the sign of a cosine where both sides of the surface count.
    cosine_mask: f32x8,
}

impl LaneTest {
    pub(super) fn new(query: &GatherQuery) -> Self {
        let cosine_mask = if query.both_sides { 0x7fff_ffff } else { u32::MAX };
        Self {
            center: query.position.to_array().map(f32x8::splat),
            normal: query.normal.to_array().map(f32x8::splat),
            radius_squared: query.radius_squared,
            flatness: FLATNESS * query.radius_squared.sqrt(),
            segments_mask: i32x8::splat(query.segments_mask() as i32),
            most_segments: i32x8::splat(query.most_segments as i32),
            cosine_mask: f32x8::splat(f32::from_bits(cosine_mask)),
        }
    }

    /// All bits of the lanes whose photon counts, of eight from `index` on and before `last`; and of those whose photon counts
    /// and lies inside half the disc's area.
    #[inline(always)]
    fn count<E>(&self, photons: &PhotonColumns<E>, index: usize, last: usize) -> (f32x8, f32x8) {
        let seen = self.look(photons, index, last);
        let flat = seen.height.abs().simd_le(self.flatness) & seen.suitable;
        let counts = seen.distance_squared.simd_lt(self.radius_squared) & flat;
        (counts, seen.distance_squared.simd_lt(0.5 * self.radius_squared) & counts)
    }

    /// Eight photons from `index` on and before `last`, whatever their distance.
    #[inline(always)]
    pub(super) fn look<E>(&self, photons: &PhotonColumns<E>, index: usize, last: usize) -> LaneView {
        let [x, y, z] = &photons.position;
        let offset =
            [lanes(x, index) - self.center[0], lanes(y, index) - self.center[1], lanes(z, index) - self.center[2]];
        let code = i32x8::new(bytemuck::cast(eight(&photons.normal_and_segments, index)));
        let byte = |shift: i32| f32x8::from_i32x8((code << shift) >> 24);
        let cosine = dot([byte(24), byte(16), byte(8)], self.normal) & self.cosine_mask;
        let segments: i32x8 = (code >> 24) & self.segments_mask;
        let in_run = LANE.simd_lt(i32x8::splat((last - index).min(LANES) as i32));
        let allowed: i32x8 = in_run & !segments.simd_gt(self.most_segments);
        LaneView {
            distance_squared: dot(offset, offset),
            height: dot(offset, self.normal),
            suitable: cosine.simd_gt(LEAST_NORMAL_COSINE) & bytemuck::cast::<i32x8, f32x8>(allowed),
        }
    }
}

/// Eight photons as a query sees them.
pub(super) struct LaneView {
    /// Squared distance, m².
    pub(super) distance_squared: f32x8,
    /// Height over the tangent plane, m.
    pub(super) height: f32x8,
    /// All bits where a photon is in the run, faces the right way and is of a kind that counts.
    pub(super) suitable: f32x8,
}
