//! A light of another group: it keeps its index in the table and emits nothing.

use super::{DirectSample, EmittedPhoton, LightImportance};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Geometry;

/// What stands for a light whose light is not wanted.
#[derive(Clone, Copy, Debug)]
pub struct Dark;

impl Dark {
    /// None.
    pub fn power(&self) -> Rgb {
        Rgb::ZERO
    }

    /// None at any place.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        LightImportance::Far { irradiance: 0.0 }
    }

    /// Nothing arrives anywhere.
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, _point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        None
    }

    /// No photon leaves.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, _place: [f32; 2], _direction: [f32; 2]) -> Option<EmittedPhoton> {
        None
    }
}
