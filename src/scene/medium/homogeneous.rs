//! `homogeneous`: the same everywhere.

use crate::math::Rgb;

/// A medium that absorbs and scatters the same everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homogeneous {
    /// Absorption and scattering together, m⁻¹.
    extinction: Rgb,
    /// Scattering, m⁻¹.
    scattering: Rgb,
}

impl Homogeneous {
    /// With an extinction, m⁻¹, of which the share `albedo` is scattering.
    pub(super) fn new(extinction: Rgb, albedo: Rgb) -> Self {
        Self { extinction, scattering: extinction * albedo }
    }

    /// Whether it scatters light, rather than absorbing all that it takes.
    pub(super) fn scatters(&self) -> bool {
        self.scattering != Rgb::ZERO
    }

    /// The share of light that passes `distance`, m.
    #[inline]
    pub(super) fn transmittance(&self, distance: f32) -> Rgb {
        // Nothing times an infinite distance is nothing.
        let depth = |extinction: f32| if extinction == 0.0 { 0.0 } else { extinction * distance };
        Rgb::from_array(self.extinction.to_array().map(|extinction| libm::expf(-depth(extinction))))
    }

    /// Samples how far a ray of length `distance`, m, gets, by the extinction of one channel: their mean is the density
    /// [Pharr, Jakob & Humphreys 2016, 15.2.1]. The distance, where it is scattered before its end, and the weight.
    pub(super) fn fly(&self, distance: f32, u: f32) -> (Option<f32>, Rgb) {
        let channel = ((3.0 * u) as usize).min(2);
        let rest = (3.0 * u - channel as f32).clamp(0.0, 1.0 - f32::EPSILON);
        let mean = |rgb: Rgb| (rgb.x + rgb.y + rgb.z) / 3.0;
        let reached = match self.extinction[channel] {
            0.0 => f32::INFINITY,
            extinction => -libm::log1pf(-rest) / extinction,
        };
        let passing = self.transmittance(reached.min(distance));
        let weighted = |value: Rgb, density: f32| if density > 0.0 { value / density } else { Rgb::ZERO };
        if reached < distance {
            let density = mean(self.extinction * passing);
            (Some(reached), weighted(self.scattering * passing, density))
        } else {
            (None, weighted(passing, mean(passing)))
        }
    }
}
