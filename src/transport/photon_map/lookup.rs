//! What methods ask of a structure that holds photons. Loops over photons are compiled for each structure.

use super::{GatherQuery, Gathered, Nearest, Photon};
use crate::math::Rgb;

/// Photons that are found by where they lie. Their indices are places in the structure; any order will do that depends on nothing but the
/// photons.
pub trait PhotonLookup: Sync {
    /// Shows the index of every photon that counts to `visit`, in ascending order, and whether it lies inside half the
    /// disc's area.
    fn visit_disc(&self, query: &GatherQuery, visit: impl FnMut(usize, bool));

    /// Finds the photons that are nearer than the `count`-th of those that count for `query` (at least 2), or all within
    /// its radius where these are fewer.
    fn nearest(&self, query: &GatherQuery, count: usize, found: &mut Nearest);

    /// The photon with an index.
    fn photon(&self, index: usize) -> Photon;

    /// How many photons there are.
    fn len(&self) -> usize;

    /// Memory that it takes, bytes.
    fn bytes(&self) -> usize;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The flux of the photon with an index, W.
    #[inline]
    fn flux(&self, index: usize) -> Rgb {
        Rgb::from_array(self.photon(index).flux)
    }

    /// The octahedral code of the direction that the photon with an index came from.
    #[inline]
    fn direction(&self, index: usize) -> u32 {
        self.photon(index).direction
    }

    /// Sums the flux of all photons that count.
    fn gather(&self, query: &GatherQuery) -> Gathered {
        let mut gathered = Gathered::default();
        self.visit_disc(query, |index, is_inner| gathered.add_photon(self.flux(index), is_inner));
        gathered
    }
}

/// Photons that know how far they came.
pub trait OriginLookup: PhotonLookup {
    /// How far the photon with an index came on its last segment, m.
    fn origin_distance(&self, index: usize) -> f32;
}
