//! Normalised radiance, taken from the estimate at any time.

/// A picture of linear Rec. 709 radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Row-major, top row first, W·sr⁻¹·m⁻².
    pub radiance: Vec<[f32; 3]>,
}
