//! What a shard's pixels add up while they are traced.

use bytemuck::{Pod, Zeroable};

use super::declaration::{
    Declaration, FLUX, FLUX_SLOPE, INNER_FLUX, PHOTONS, PlaneDeclaration, RADIANCE, SQUARED_FLUX,
};

/// The sums of one pixel. Methods add passes to it; the tally keeps the declared planes of it.
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
    /// Mean of the channels of the flux that was found inside half the disc's area, Σ Φ'ᵢ/ρᵢ, W·sr⁻¹. The bias is estimated from it.
    pub inner_flux: f32,
}

/// How evenly flux lies in the discs of one pixel, where radii shrink by [`RadiusRule::Uniformity`](super::radius::RadiusRule).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelEvenness {
    /// Σ over photons of their flux, mean of the channels, times the unit vector from the disc's middle to them, over ρᵢ, W·sr⁻¹.
    pub flux_slope: [f32; 2],
    /// Σ over photons of the square of their flux, mean of the channels, over ρᵢ², W²·sr⁻².
    pub squared_flux: f32,
}

/// The sums of all pixels of a region, in row order.
#[derive(Clone, Debug)]
pub struct ShardSums {
    /// Of every method.
    pub tallies: Vec<PixelTally>,
    /// Empty unless they are declared.
    pub evenness: Vec<PixelEvenness>,
}

impl From<Vec<PixelTally>> for ShardSums {
    /// Sums that nothing measured the evenness for.
    fn from(tallies: Vec<PixelTally>) -> Self {
        Self { tallies, evenness: Vec::new() }
    }
}

/// A row of [`ShardSums`].
pub struct RowSums<'a> {
    /// Of every method.
    pub tallies: &'a mut [PixelTally],
    /// Empty unless they are declared.
    pub evenness: &'a mut [PixelEvenness],
}

/// Planes, each with the word of its first channel and the number of channels.
type Planes = &'static [(&'static str, usize, usize)];

/// The planes of [`PixelTally`].
const OF_TALLIES: Planes = &[(RADIANCE, 0, 3), (FLUX, 3, 3), (PHOTONS, 6, 1), (INNER_FLUX, 7, 1)];
/// The planes of [`PixelEvenness`].
const OF_EVENNESS: Planes = &[(FLUX_SLOPE, 0, 2), (SQUARED_FLUX, 2, 1)];

impl ShardSums {
    /// Sums of nothing for so many pixels, of what every method has.
    pub fn zero(pixels: usize) -> Self {
        vec![PixelTally::zeroed(); pixels].into()
    }

    /// The same with all that is declared.
    pub fn zero_declared(pixels: usize, declaration: &Declaration) -> Self {
        let measures_evenness = OF_EVENNESS.iter().any(|(name, ..)| declaration.plane(name).is_some());
        let evenness = if measures_evenness { pixels } else { 0 };
        Self { evenness: vec![PixelEvenness::zeroed(); evenness], ..Self::zero(pixels) }
    }

    /// Its rows, each `width` pixels wide.
    pub fn rows(&mut self, width: usize) -> Vec<RowSums<'_>> {
        let mut evenness = self.evenness.chunks_mut(width);
        let rows = self.tallies.chunks_mut(width);
        rows.map(|tallies| RowSums { tallies, evenness: evenness.next().unwrap_or_default() }).collect()
    }

    /// A declared plane, its channels one after the other; `None` where there are no sums for it.
    pub(super) fn plane(&self, declared: &PlaneDeclaration) -> Option<Vec<f32>> {
        let of_tallies = channels(&self.tallies, OF_TALLIES, declared);
        of_tallies.or_else(|| channels(&self.evenness, OF_EVENNESS, declared).filter(|_| !self.evenness.is_empty()))
    }
}

fn channels<T: Pod>(pixels: &[T], planes: Planes, declared: &PlaneDeclaration) -> Option<Vec<f32>> {
    let first = first_word(planes, declared)?;
    let words: &[f32] = bytemuck::cast_slice(pixels);
    let mut plane = Vec::with_capacity(declared.channels * pixels.len());
    for channel in first..first + declared.channels {
        plane.extend(words.chunks_exact(size_of::<T>() / size_of::<f32>()).map(|pixel| pixel[channel]));
    }
    Some(plane)
}

/// Where the sums of a declared plane begin; `None` for one of another kind or another number of channels.
fn first_word(planes: Planes, declared: &PlaneDeclaration) -> Option<usize> {
    let is_same =
        |(name, _, channels): &&(&str, usize, usize)| *name == declared.kind() && *channels == declared.channels;
    planes.iter().find(is_same).map(|(_, first, _)| *first)
}

/// Sets the sums that a plane of a tally holds.
pub(super) fn set_plane(pixels: &mut [PixelTally], declared: &PlaneDeclaration, plane: &[f32]) {
    let Some(first) = first_word(OF_TALLIES, declared) else { return };
    let count = pixels.len();
    let words: &mut [f32] = bytemuck::cast_slice_mut(pixels);
    for (channel, values) in plane.chunks(count.max(1)).enumerate() {
        let channel = words.iter_mut().skip(first + channel).step_by(size_of::<PixelTally>() / size_of::<f32>());
        channel.zip(values).for_each(|(word, value)| *word = *value);
    }
}
