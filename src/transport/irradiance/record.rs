//! What is known of irradiance at one place.

use std::f32::consts::PI;

use super::{Arrival, HemisphereCells, IrradianceQuery, TangentGradient};
use crate::math::{Frame, Rgb, Vec3, color};

/// The largest relative depth, in R, at which a place still lies beside a record and not behind it: positions are rounded.
const BESIDE: f32 = 0.01;
/// The least ε in a weight, in a: a place and a record may be the same.
const LEAST_ERROR: f32 = 1e-3;

/// What R is kept within, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiusRange {
    /// The least R; nearer surfaces count as this far.
    pub smallest: f32,
    /// The largest R.
    pub largest: f32,
}

/// Irradiance at one place, and how it changes around.
#[derive(Clone, Copy, Debug)]
pub struct IrradianceRecord {
    /// xᵢ, m.
    pub position: Vec3,
    /// Around nᵢ, the normal on the side on which light arrives.
    pub frame: Frame,
    /// Serves only places of the same group.
    pub group: u32,
    /// Eᵢ, W·m⁻².
    pub irradiance: Rgb,
    /// Rᵢ, m.
    pub radius: f32,
    /// ∇rEᵢ, W·m⁻²·rad⁻¹.
    pub rotation: TangentGradient,
    /// ∇tEᵢ, W·m⁻³.
    pub translation: TangentGradient,
}

impl IrradianceRecord {
    /// A record at a place with `frame` around its normal, of what arrives along one ray in each cell, in the order of cells.
    ///
    /// R is the harmonic mean of distances \[WRC88\], at most E/|∇tE|: further off, a gradient would take more than there is
    /// \[KG09\]. Where even the smallest R is too far for that, the gradient is shortened.
    pub fn new(
        position: Vec3,
        frame: Frame,
        group: u32,
        cells: HemisphereCells,
        arrivals: &mut [Arrival],
        range: RadiusRange,
    ) -> Self {
        for arrival in arrivals.iter_mut() {
            arrival.distance = arrival.distance.max(range.smallest);
        }
        let count = cells.count() as f32;
        let irradiance = arrivals.iter().map(|arrival| arrival.radiance).sum::<Rgb>() * (PI / count);
        let nearness: f32 = arrivals.iter().map(|arrival| 1.0 / arrival.distance).sum();
        let rotation = cells.rotation_gradient(arrivals);
        let translation = cells.translation_gradient(arrivals);
        let (brightness, slope) = (color::luminance(irradiance), translation.length());
        // Not `min` of quotients: nothing over nothing is no number.
        let steep = |radius: f32| slope * radius > brightness;
        let mut radius = (count / nearness).min(range.largest);
        if steep(radius) {
            radius = (brightness / slope).max(range.smallest);
        }
        let kept = if steep(radius) { brightness / (slope * radius) } else { 1.0 };
        Self { position, frame, group, irradiance, radius, rotation, translation: translation.scaled(kept) }
    }

    /// wᵢ at a place, where ε may be up to `error`; `None` where it does not count.
    #[inline]
    pub fn weight(&self, query: &IrradianceQuery, error: f32) -> Option<f32> {
        let offset = query.position - self.position;
        let turned = (1.0 - query.normal.dot(self.frame.normal)).max(0.0).sqrt();
        let own = offset.length() / self.radius + turned;
        let height = 0.5 * offset.dot(query.normal + self.frame.normal);
        let counts = query.group == self.group && own < error && height >= -BESIDE * self.radius;
        counts.then(|| 1.0 / own.max(LEAST_ERROR * error) - 1.0 / error)
    }

    /// Irradiance at a place by this record alone, W·m⁻².
    #[inline]
    pub fn extrapolated(&self, query: &IrradianceQuery) -> Rgb {
        self.irradiance
            + self.rotation.along(&self.frame, self.frame.normal.cross(query.normal))
            + self.translation.along(&self.frame, query.position - self.position)
    }
}
