//! The hemisphere in cells, with a ray in each.

use crate::math::{Rgb, Vec3, warp};

/// What a ray found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Radiance that arrives along it, W·sr⁻¹·m⁻².
    pub radiance: Rgb,
    /// Distance to what it met, m; infinite where it left the scene.
    pub distance: f32,
}

impl Arrival {
    /// Nothing, from infinitely far.
    pub const NOTHING: Self = Self { radiance: Rgb::ZERO, distance: f32::INFINITY };
}

/// M rings, each with the same irradiance under an even sky, in N sectors. Cells are numbered along the rings of a sector, from the
/// zenith to the horizon, then by sectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemisphereCells {
    rings: u32,
    sectors: u32,
}

impl HemisphereCells {
    /// As many cells as possible, at most `rays` (at least 16), about as wide as they are high: N ≈ π·M.
    pub fn new(rays: u32) -> Self {
        let rings = ((rays as f32 * std::f32::consts::FRAC_1_PI).sqrt() + 0.5) as u32;
        Self { rings, sectors: rays / rings }
    }

    /// M.
    pub fn rings(&self) -> u32 {
        self.rings
    }

    /// N.
    pub fn sectors(&self) -> u32 {
        self.sectors
    }

    /// M·N.
    pub fn count(&self) -> u32 {
        self.rings * self.sectors
    }

    /// The local direction, normal z, with the place `u` in cell `cell`: density cos θ/π by solid angle over all cells.
    #[inline]
    pub fn direction(&self, cell: u32, u: [f32; 2]) -> Vec3 {
        let (sector, ring) = (cell / self.rings, cell % self.rings);
        warp::cosine_hemisphere([
            (ring as f32 + u[0]) / self.rings as f32,
            (sector as f32 + u[1]) / self.sectors as f32,
        ])
    }
}
