//! Kernels of density estimates: how much a photon counts by its distance from the middle of the disc.
//!
//! | kernel | weight at t = distance/radius | why |
//! |---|---|---|
//! | disc | 1 | the least noise for its radius |
//! | cone | 3·(1 − t) | sharper caustics [Jensen 1996]; his filter constant k is 1 |
//! | Epanechnikov | 2·(1 − t²) | the least squared error where the density is smooth [Silverman 1986, 4.2.1] |
//!
//! Each has mean 1 over the disc, `∫₀¹ K(t)·2t dt = 1`: an estimate is `Σ K(t)·flux/(π·radius²)` with all of them.

use serde::{Deserialize, Serialize};

/// The shape of a kernel on the unit disc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kernel {
    /// The same everywhere.
    Disc,
    /// Falls evenly to the rim.
    Cone,
    /// Falls with the square of the distance.
    #[default]
    Epanechnikov,
}

impl Kernel {
    /// The weight of a photon at `distance_squared` = t², 0 to 1.
    #[inline]
    pub fn weight(self, distance_squared: f32) -> f32 {
        match self {
            Self::Disc => 1.0,
            Self::Cone => 3.0 * (1.0 - distance_squared.sqrt()),
            Self::Epanechnikov => 2.0 * (1.0 - distance_squared),
        }
    }

    /// The weights of a photon at `distance_squared` = t² with this radius, and with the radius of half the disc's area.
    #[inline]
    pub fn weights(self, distance_squared: f32) -> [f32; 2] {
        let inner = if distance_squared < 0.5 { self.weight(2.0 * distance_squared) } else { 0.0 };
        [self.weight(distance_squared), inner]
    }
}
