//! Photons that know which light they came from.

use super::photon::PhotonWith;
use super::{KdTree, OriginLookup, PhotonMap};

/// The way of a photon that came straight from a light.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightSegment {
    /// Index of the light.
    pub light: u32,
    /// Its length, m.
    pub length: f32,
}

/// A photon that came straight from a light.
pub type LightPhoton = PhotonWith<LightSegment>;

/// Photons that know how far they came, and from which light.
pub trait LightLookup: OriginLookup {
    /// The index of the light that the photon with an index came from.
    fn light(&self, index: usize) -> u32;
}

impl OriginLookup for PhotonMap<LightSegment> {
    #[inline]
    fn origin_distance(&self, index: usize) -> f32 {
        self.extras()[index].length
    }
}

impl LightLookup for PhotonMap<LightSegment> {
    #[inline]
    fn light(&self, index: usize) -> u32 {
        self.extras()[index].light
    }
}

impl OriginLookup for KdTree<LightPhoton> {
    #[inline]
    fn origin_distance(&self, index: usize) -> f32 {
        self.record(index).extra.length
    }
}

impl LightLookup for KdTree<LightPhoton> {
    #[inline]
    fn light(&self, index: usize) -> u32 {
        self.record(index).extra.light
    }
}
