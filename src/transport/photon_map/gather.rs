//! The density estimate's inner loop: photons in a disc around a point.
//!
//! A photon counts when it lies within the radius, near the tangent plane and on a surface that faces the same way.
//! [`PhotonMap::gather`] sums eight photons at a time without branches; [`PhotonMap::visit`] is its plain twin, for materials
//! that look at each photon.

use super::photon::SCATTERED;
use super::{Photon, PhotonMap};
use crate::math::{Rgb, Vec3};

/// How far a photon may lie off the tangent plane, in radii.
const FLATNESS: f32 = 0.25;
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
    /// Photons on the other side of the surface count too; only [`PhotonMap::visit`] knows this.
    pub both_sides: bool,
}

impl GatherQuery {
    /// What of a photon's top byte is compared with `most_segments`: scattered photons exceed it where they do not count.
    #[inline]
    fn segments_mask(&self) -> u32 {
        if self.caustics_only { 0xff } else { 0xff & !SCATTERED }
    }
}

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Sum of flux, W.
    pub flux: Rgb,
    /// Number of photons.
    pub photons: f32,
}

const LANES: usize = 8;
type Lanes = [f32; LANES];
const LANE: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];

#[derive(Default)]
struct LaneSums {
    flux: [Lanes; 3],
    photons: Lanes,
}

impl PhotonMap {
    /// Sums the flux of all photons that count.
    #[inline]
    pub fn gather(&self, query: &GatherQuery) -> Gathered {
        let mut sums = LaneSums::default();
        self.for_each_run(query, |first, last| self.sum_run(first, last, query, &mut sums));
        let total = |lanes: &Lanes| lanes.iter().sum::<f32>();
        Gathered {
            flux: Rgb::new(total(&sums.flux[0]), total(&sums.flux[1]), total(&sums.flux[2])),
            photons: total(&sums.photons),
        }
    }

    /// Shows every photon that counts to `visit`, in the map's order.
    pub fn visit(&self, query: &GatherQuery, mut visit: impl FnMut(&Photon)) {
        self.for_each_run(query, |first, last| {
            for index in first..last {
                let photon = self.photon(index);
                if counts(&photon, query) {
                    visit(&photon);
                }
            }
        });
    }

    /// Calls `run` with the index range of each run of photons that may count.
    #[inline]
    fn for_each_run(&self, query: &GatherQuery, mut run: impl FnMut(usize, usize)) {
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

    // Indexed loops over a constant number of lanes become vector instructions.
    #[expect(clippy::needless_range_loop)]
    #[inline]
    fn sum_run(&self, first: usize, last: usize, query: &GatherQuery, sums: &mut LaneSums) {
        let [x, y, z] = &self.photons.position;
        let [red, green, blue] = &self.photons.flux;
        let flatness = FLATNESS * query.radius_squared.sqrt();
        let segments_mask = query.segments_mask();
        let mut index = first;
        while index < last {
            let here = index..index + LANES;
            let columns = (&x[here.clone()], &y[here.clone()], &z[here.clone()]);
            let normals = &self.photons.normal_and_segments[here.clone()];
            let left = (last - index).min(LANES) as i32;
            let mut mask = [0.0; LANES];
            for lane in 0..LANES {
                let dx = columns.0[lane] - query.position.x;
                let dy = columns.1[lane] - query.position.y;
                let dz = columns.2[lane] - query.position.z;
                let distance_squared = dx * dx + dy * dy + dz * dz;
                let height = dx * query.normal.x + dy * query.normal.y + dz * query.normal.z;
                let code = normals[lane];
                let cosine = ((code << 24) as i32 >> 24) as f32 * query.normal.x
                    + ((code << 16) as i32 >> 24) as f32 * query.normal.y
                    + ((code << 8) as i32 >> 24) as f32 * query.normal.z;
                let counts = (distance_squared < query.radius_squared)
                    & (height.abs() <= flatness)
                    & (cosine > LEAST_NORMAL_COSINE)
                    & (code >> 24 & segments_mask <= query.most_segments)
                    & (LANE[lane] < left);
                mask[lane] = if counts { 1.0 } else { 0.0 };
            }
            // One loop per sum: together they would be shuffled between registers.
            for lane in 0..LANES {
                sums.photons[lane] += mask[lane];
            }
            for (sum, flux) in sums.flux.iter_mut().zip([&red[here.clone()], &green[here.clone()], &blue[here]]) {
                for lane in 0..LANES {
                    sum[lane] += mask[lane] * flux[lane];
                }
            }
            index += LANES;
        }
    }

    fn photon(&self, index: usize) -> Photon {
        let columns = &self.photons;
        Photon {
            position: [0, 1, 2].map(|axis| columns.position[axis][index]),
            direction: columns.direction[index],
            normal_and_segments: columns.normal_and_segments[index],
            flux: [0, 1, 2].map(|channel| columns.flux[channel][index]),
        }
    }
}

/// Whether a photon counts: the plain twin of the test in the lane loop.
fn counts(photon: &Photon, query: &GatherQuery) -> bool {
    let offset = Vec3::from_array(photon.position) - query.position;
    let byte = |shift: u32| (photon.normal_and_segments >> shift) as u8 as i8 as f32;
    let cosine = Vec3::new(byte(0), byte(8), byte(16)).dot(query.normal);
    offset.length_squared() < query.radius_squared
        && offset.dot(query.normal).abs() <= FLATNESS * query.radius_squared.sqrt()
        && if query.both_sides { cosine.abs() } else { cosine } > LEAST_NORMAL_COSINE
        && photon.normal_and_segments >> 24 & query.segments_mask() <= query.most_segments
}
