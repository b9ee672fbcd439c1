//! How evenly flux lies in a disc: sums from which estimates tell whether it does.

use super::photon_map::GatherQuery;
use crate::math::{Frame, Rgb, Vec3};

/// Sums over the photons of discs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evenness {
    /// Σ w·cos φ and Σ w·sin φ: w is a photon's flux, mean of the channels, φ the direction in which it lies from the middle, W·sr⁻¹.
    pub slope: [f32; 2],
    /// Σ w², W²·sr⁻².
    pub squares: f32,
}

impl Evenness {
    /// Adds those of another disc.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        self.slope = [0, 1].map(|axis| self.slope[axis] + other.slope[axis]);
        self.squares += other.squares;
    }

    /// Whether all sums are finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.slope.iter().all(|slope| slope.is_finite()) && self.squares.is_finite()
    }
}

/// A disc whose evenness is measured. Its axes hang on the normal alone, so that they are the same for all discs on a plane.
pub(crate) struct MeasuredDisc {
    middle: Vec3,
    frame: Frame,
    sums: Evenness,
}

impl MeasuredDisc {
    /// The disc of a query.
    #[inline]
    pub(crate) fn new(query: &GatherQuery) -> Self {
        Self { middle: query.position, frame: Frame::from_normal(query.normal), sums: Evenness::default() }
    }

    /// Adds a photon at `position` that brings `flux`.
    #[inline]
    pub(crate) fn add(&mut self, position: Vec3, flux: Rgb) {
        let weight = flux.element_sum() / 3.0;
        let offset = self.frame.to_local(position - self.middle);
        let distance = (offset.x * offset.x + offset.y * offset.y).sqrt();
        if distance > 0.0 {
            let scaled = weight / distance;
            self.sums.slope = [self.sums.slope[0] + scaled * offset.x, self.sums.slope[1] + scaled * offset.y];
        }
        self.sums.squares += weight * weight;
    }

    /// The sums.
    #[inline]
    pub(crate) fn sums(self) -> Evenness {
        self.sums
    }
}
