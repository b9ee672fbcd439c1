//! How irradiance changes where a place turns or moves \[WH92\], from what the rays of a hemisphere found.
//!
//! Weights of rings are means over a ring instead of values at a ray: in an even field all gradients vanish, up to rounding, and
//! tan θ at the horizon has a finite variance.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use super::{Arrival, HemisphereCells};
use crate::math::trigonometry::sin_cos_turn;
use crate::math::{Frame, Rgb, Vec3, color};

/// A gradient in the tangent plane, of each channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TangentGradient {
    /// Along the tangent.
    pub x: Rgb,
    /// Along the bitangent.
    pub y: Rgb,
}

impl TangentGradient {
    /// The change along a vector in world space, to first order.
    #[inline]
    pub fn along(&self, frame: &Frame, vector: Vec3) -> Rgb {
        self.x * vector.dot(frame.tangent) + self.y * vector.dot(frame.bitangent)
    }

    /// The length of the gradient of luminance.
    pub fn length(&self) -> f32 {
        let (x, y) = (color::luminance(self.x), color::luminance(self.y));
        (x * x + y * y).sqrt()
    }

    /// The same with `factor` times the length.
    pub(super) fn scaled(self, factor: f32) -> Self {
        Self { x: self.x * factor, y: self.y * factor }
    }

    /// Adds `value` in the direction at `turn` of a whole turn from the tangent.
    fn add(&mut self, turn: f32, value: Rgb) {
        let (sin, cos) = sin_cos_turn(turn - turn.floor());
        self.x += value * cos;
        self.y += value * sin;
    }
}

impl HemisphereCells {
    /// sin θ at the inner border of `ring`: √(ring/M).
    fn inner_sine(&self, ring: u32) -> f32 {
        (ring as f32 / self.rings() as f32).sqrt()
    }

    /// Mean tan θ in `ring`: with u = sin² θ, ∫ √(u/(1 − u)) du = asin √u − √(u(1 − u)).
    fn mean_tangent(&self, ring: u32) -> f32 {
        let integral = |ring: u32| match ring == self.rings() {
            true => FRAC_PI_2,
            false => {
                let sine = self.inner_sine(ring);
                libm::asinf(sine) - sine * (1.0 - sine * sine).max(0.0).sqrt()
            }
        };
        (integral(ring + 1) - integral(ring)) * self.rings() as f32
    }

    /// By rotation: the change of E along nᵢ × n where the normal turns from nᵢ to n, W·m⁻²·rad⁻¹.
    ///
    /// ```text
    /// ∇rE = π/(M·N) · Σk v̂k · Σj tan θj · Ljk          v̂k a quarter turn from the middle of sector k
    /// ```
    ///
    /// \[WH92\] print the sign of the opposite turn.
    pub fn rotation_gradient(&self, arrivals: &[Arrival]) -> TangentGradient {
        let tangents: Vec<f32> = (0..self.rings()).map(|ring| self.mean_tangent(ring)).collect();
        let mut gradient = TangentGradient::default();
        for (sector, arrivals) in (0..).zip(arrivals.chunks_exact(self.rings() as usize)) {
            let sum: Rgb = arrivals.iter().zip(&tangents).map(|(arrival, tangent)| arrival.radiance * *tangent).sum();
            gradient.add((sector as f32 + 0.5) / self.sectors() as f32 + 0.25, sum);
        }
        gradient.scaled(PI / self.count() as f32)
    }

    /// By translation: the change of E along a way in the tangent plane, W·m⁻³.
    ///
    /// Borders between cells move, and each moves with the nearer one of what is on its two sides:
    ///
    /// ```text
    /// ∇tE = Σk ûk·2π/N·Σj sin θj₋·cos² θj₋·(Ljk − Lj₋₁k)/min(rjk, rj₋₁k)       ûk the middle of sector k
    ///     + Σk v̂k₋·Σj (sin θj₊ − sin θj₋)·(Ljk − Ljk₋₁)/min(rjk, rjk₋₁)        v̂k₋ a quarter turn from its first border
    /// ```
    pub fn translation_gradient(&self, arrivals: &[Arrival]) -> TangentGradient {
        let rings = self.rings() as usize;
        let sectors: Vec<&[Arrival]> = arrivals.chunks_exact(rings).collect();
        let sines: Vec<f32> = (0..=self.rings()).map(|ring| self.inner_sine(ring)).collect();
        let turn = |sector: f32| sector / self.sectors() as f32;
        let mut gradient = TangentGradient::default();
        for (sector, here) in sectors.iter().enumerate() {
            let before = sectors[(sector + sectors.len() - 1) % sectors.len()];
            let mut radial = Rgb::ZERO;
            for ring in 1..rings {
                let sine = sines[ring];
                radial += border(&here[ring], &here[ring - 1]) * (sine * (1.0 - sine * sine));
            }
            let mut around = Rgb::ZERO;
            for ring in 0..rings {
                around += border(&here[ring], &before[ring]) * (sines[ring + 1] - sines[ring]);
            }
            gradient.add(turn(sector as f32 + 0.5), radial * (TAU / self.sectors() as f32));
            gradient.add(turn(sector as f32) + 0.25, around);
        }
        gradient
    }
}

/// The step of radiance over a border between cells, by the distance of the nearer side.
#[inline]
fn border(outer: &Arrival, inner: &Arrival) -> Rgb {
    (outer.radiance - inner.radiance) / outer.distance.min(inner.distance)
}
