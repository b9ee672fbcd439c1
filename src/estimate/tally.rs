//! What a shard returns: sums and counts per pixel.

use bytemuck::{Pod, Zeroable};

use super::shard::Shard;

/// The sums of one pixel over the passes of a shard. Eight little-endian `f32` on the wire.
///
/// A pass `i` gathers with radius² `R²ᵢ = ρᵢ·R²` where `R²` is the pixel's value in the shard's radius field and `ρᵢ` is the
/// same for all pixels; its counts and flux are divided by `ρᵢ` so that the sums all refer to `R²`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelTally {
    /// Σ of radiance that needs no density estimate (emission seen, sampled direct light), W·sr⁻¹·m⁻².
    pub radiance: [f32; 3],
    /// Σ Φᵢ/ρᵢ, Φ = T·Σ f_r·α: un-normalised reflected flux, W·sr⁻¹.
    pub flux: [f32; 3],
    /// Σ Mᵢ/ρᵢ: photons found.
    pub photons: f32,
    /// Mean of the channels of the flux that was found inside half the disc's area, Σ Φ'ᵢ/ρᵢ, W·sr⁻¹. Tells the bias.
    pub inner_flux: f32,
}

/// What a shard returns: one [`PixelTally`] per pixel of its region in row order, and totals.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// What was traced.
    pub shard: Shard,
    /// Picture width in pixels.
    pub width: u32,
    /// Row-major, `shard.region.pixel_count(width)` entries.
    pub pixels: Vec<PixelTally>,
    /// Photons emitted, counted whether or not they were stored.
    pub photons_emitted: u64,
    /// Photons stored in maps, for rates and memory planning.
    pub photons_stored: u64,
    /// Rays traced, camera and photon and shadow together.
    pub rays: u64,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
}

/// A tally that does not fit its shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TallyError {
    /// The pixel count is wrong.
    #[error("tally has {found} pixels where its shard has {expected}")]
    WrongSize {
        /// Pixels the shard has.
        expected: usize,
        /// Pixels that came.
        found: usize,
    },
    /// A value is infinite, not a number or, for a count, negative.
    #[error("tally holds an impossible value ({value}) in {plane} of pixel {pixel}")]
    ImpossibleValue {
        /// Which sum.
        plane: &'static str,
        /// Index in the region.
        pixel: usize,
        /// The value as text.
        value: String,
    },
    /// Flux was gathered although no photon was emitted.
    #[error("tally holds flux but says that no photon was emitted")]
    NothingEmitted,
}

impl Tally {
    /// A tally of zeros for `shard` in a picture `width` pixels wide.
    pub fn zero(shard: Shard, width: u32) -> Self {
        let pixels = vec![PixelTally::zeroed(); shard.region.pixel_count(width)];
        Self { shard, width, pixels, photons_emitted: 0, photons_stored: 0, rays: 0, non_finite: 0 }
    }

    /// Checks that every value is possible: right size, finite, counts not negative.
    pub fn check(&self) -> Result<(), TallyError> {
        let expected = self.shard.region.pixel_count(self.width);
        if self.pixels.len() != expected {
            return Err(TallyError::WrongSize { expected, found: self.pixels.len() });
        }
        let dark = |pixel: &PixelTally| pixel.photons == 0.0 && pixel.flux == [0.0; 3] && pixel.inner_flux == 0.0;
        if self.photons_emitted == 0 && !self.pixels.iter().all(dark) {
            return Err(TallyError::NothingEmitted);
        }
        if all_possible(&self.pixels) {
            return Ok(());
        }
        match self.pixels.iter().position(|pixel| !pixel.is_possible()) {
            None => Ok(()),
            Some(pixel) => Err(self.pixels[pixel].impossible_value(pixel)),
        }
    }
}

/// [`PixelTally::is_possible`] of all pixels at once, on bits, so that it runs as fast as memory is read.
fn all_possible(pixels: &[PixelTally]) -> bool {
    const SIGN: u32 = 1 << 31;
    const INFINITY: u32 = 0x7f80_0000;
    let largest = bytemuck::cast_slice::<_, u32>(pixels).iter().fold(0, |largest, bits| largest.max(bits & !SIGN));
    let negative = pixels.iter().fold(0, |signs, pixel| signs | pixel.photons.to_bits()) & SIGN != 0;
    largest < INFINITY && !negative
}

impl PixelTally {
    fn is_possible(&self) -> bool {
        let values: [f32; 8] = bytemuck::cast(*self);
        values.iter().all(|value| value.is_finite()) && self.photons >= 0.0
    }

    fn impossible_value(&self, pixel: usize) -> TallyError {
        let (photons, inner_flux) = ([self.photons], [self.inner_flux]);
        let groups: [(_, &[f32]); 4] =
            [("radiance", &self.radiance), ("flux", &self.flux), ("photons", &photons), ("inner flux", &inner_flux)];
        let groups = groups
            .map(|(plane, values)| (plane, values.iter().copied().find(|value| !value.is_finite() || *value < 0.0)));
        let (plane, value) = groups
            .into_iter()
            .find_map(|(plane, value)| value.map(|value| (plane, value)))
            .unwrap_or(("photons", self.photons));
        TallyError::ImpossibleValue { plane, pixel, value: value.to_string() }
    }
}
