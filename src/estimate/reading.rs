//! What is read from an estimate at any time: pictures, sums and radii of pixels.

use std::ops::Range;

use super::declaration::{Declaration, FLUX, INNER_FLUX, PHOTONS_EMITTED, PlaneDeclaration, PlaneRule, RADIANCE};
use super::merging::{Estimate, RegionProgress};
use super::picture::Picture;
use super::shard::Twin;
use super::shrinking::PixelEstimate;

/// What a pixel's passes add up to, of one twin or of both; 0 where the method does not declare it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSums {
    /// τ/R² = Σ Φᵢ/R²ᵢ, W·sr⁻¹·m⁻².
    pub flux_density: [f64; 3],
    /// Σ of radiance over passes, W·sr⁻¹·m⁻².
    pub radiance: [f64; 3],
    /// Σ Φ'ᵢ/R²ᵢ of the flux inside half the disc's area, mean of the channels, W·sr⁻¹·m⁻².
    pub inner_flux_density: f64,
}

/// What sums of passes are multiplied with to become means.
#[derive(Clone, Debug)]
pub struct Scale {
    /// For sums: one over the passes.
    pub per_pass: f64,
    /// For flux densities: one over π·E.
    pub per_photon: f64,
    /// The declared scalars, for ratios.
    scalars: Vec<f64>,
}

impl RegionProgress {
    /// The scale of the sums of `twins`; `None` when they have no pass.
    pub fn scale(&self, declaration: &Declaration, twins: &[Twin]) -> Option<Scale> {
        let passes: u32 = twins.iter().map(|twin| self.passes[*twin as usize]).sum();
        let sum = |index: usize| twins.iter().map(|twin| self.scalars[*twin as usize][index]).sum::<f64>();
        let scalars: Vec<f64> = (0..declaration.scalars.len()).map(sum).collect();
        let photons = declaration.scalar(PHOTONS_EMITTED).map_or(0.0, |index| scalars[index]);
        // Without photons there is no flux that this could scale.
        let per_photon = 1.0 / (std::f64::consts::PI * photons.max(1.0));
        (passes > 0).then(|| Scale { per_pass: 1.0 / f64::from(passes), per_photon, scalars })
    }
}

impl Estimate {
    /// Radiance as estimated so far: the sum of the means of the planes that are parts of the picture. Regions without a pass
    /// are black.
    pub fn picture(&self) -> Picture {
        self.picture_of(&[Twin::Even, Twin::Odd], |_| true)
    }

    /// The same of one twin alone.
    pub fn twin_picture(&self, twin: Twin) -> Picture {
        self.picture_of(&[twin], |_| true)
    }

    /// The part of [`Estimate::picture`] that is the light of a light group.
    pub fn light_group_picture(&self, group: &str) -> Picture {
        self.picture_of(&[Twin::Even, Twin::Odd], |plane| plane.light_group.as_deref() == Some(group))
    }

    fn picture_of(&self, twins: &[Twin], takes: impl Fn(&PlaneDeclaration) -> bool) -> Picture {
        let mut radiance = vec![[0.0f32; 3]; self.pixel_count()];
        for progress in &self.progress {
            let Some(scale) = progress.scale(&self.declaration, twins) else { continue };
            for row in self.rows_of(progress) {
                let channels = self.radiance_of(row.clone(), twins, &scale, &takes);
                for (index, output) in radiance[row].iter_mut().enumerate() {
                    *output = channels.each_ref().map(|channel| channel[index] as f32);
                }
            }
        }
        Picture { width: self.width, height: self.height, radiance }
    }

    /// The pixels of each row of a region.
    pub(super) fn rows_of(&self, progress: &RegionProgress) -> impl Iterator<Item = Range<usize>> + use<> {
        let width = self.width as usize;
        let rows = progress.region.row_start as usize..progress.region.row_end as usize;
        rows.map(move |row| row * width..(row + 1) * width)
    }

    /// The radiance of `pixels` that planes which `takes` takes bring, per channel.
    pub(super) fn radiance_of(
        &self,
        pixels: Range<usize>,
        twins: &[Twin],
        scale: &Scale,
        takes: impl Fn(&PlaneDeclaration) -> bool,
    ) -> [Vec<f64>; 3] {
        let mut radiance: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; pixels.len()]);
        for (index, plane) in self.declaration.planes.iter().enumerate() {
            if plane.in_picture && takes(plane) {
                for (channel, output) in radiance.iter_mut().enumerate() {
                    self.add_mean([index, channel], pixels.clone(), twins, scale, output);
                }
            }
        }
        radiance
    }

    /// The means of a plane by name over `twins`, channel after channel. `None` when it is not declared, not summed, or some region
    /// has no pass.
    pub fn mean(&self, name: &str, twins: &[Twin]) -> Option<Vec<f64>> {
        let index = self.declaration.plane(name).filter(|index| self.declaration.planes[*index].is_summed())?;
        let all = self.pixel_count();
        let mut means = vec![0.0; self.declaration.planes[index].channels * all];
        for progress in &self.progress {
            let scale = progress.scale(&self.declaration, twins)?;
            for row in self.rows_of(progress) {
                for (channel, means) in means.chunks_mut(all.max(1)).enumerate() {
                    self.add_mean([index, channel], row.clone(), twins, &scale, &mut means[row.clone()]);
                }
            }
        }
        Some(means)
    }

    /// Adds the means of a channel of a plane to `output`, which stands for `pixels`.
    fn add_mean(
        &self,
        [plane, channel]: [usize; 2],
        pixels: Range<usize>,
        twins: &[Twin],
        scale: &Scale,
        output: &mut [f64],
    ) {
        let sum = |plane: usize, channel: usize, pixel: usize| self.sum(plane, channel, pixel, twins);
        let pixels = output.iter_mut().zip(pixels);
        match &self.declaration.planes[plane].rule {
            PlaneRule::Sum => pixels.for_each(|(out, pixel)| *out += sum(plane, channel, pixel) * scale.per_pass),
            PlaneRule::FluxOverRadius => {
                pixels.for_each(|(out, pixel)| *out += sum(plane, channel, pixel) * scale.per_photon);
            }
            PlaneRule::SquaredFluxOverRadius => {
                let per_photon_squared = scale.per_photon * scale.per_photon;
                pixels.for_each(|(out, pixel)| *out += sum(plane, channel, pixel) * per_photon_squared);
            }
            PlaneRule::Ratio { denominator } => {
                let below = |pixel: usize| match self.declaration.plane(denominator) {
                    Some(below) => sum(below, channel.min(self.declaration.planes[below].channels - 1), pixel),
                    None => self.declaration.scalar(denominator).map_or(0.0, |index| scale.scalars[index]),
                };
                pixels.for_each(|(out, pixel)| *out += ratio(sum(plane, channel, pixel), below(pixel)));
            }
            PlaneRule::Count => {}
        }
    }

    /// The sum of a channel of a plane in a pixel.
    #[inline]
    fn sum(&self, plane: usize, channel: usize, pixel: usize, twins: &[Twin]) -> f64 {
        let place = channel * self.pixel_count() + pixel;
        twins.iter().fold(0.0, |sum, twin| sum + self.twins[*twin as usize][plane][place])
    }

    /// What the passes of `twins` add up to in a pixel.
    pub fn sums(&self, pixel: usize, twins: &[Twin]) -> PixelSums {
        let channel = |kind: &str, channel: usize| {
            let is_there = |index: &usize| channel < self.declaration.planes[*index].channels;
            let planes = self.declaration.planes_of_kind(kind).filter(is_there);
            planes.fold(0.0, |sum, plane| sum + self.sum(plane, channel, pixel, twins))
        };
        PixelSums {
            flux_density: [0, 1, 2].map(|c| channel(FLUX, c)),
            radiance: [0, 1, 2].map(|c| channel(RADIANCE, c)),
            inner_flux_density: channel(INNER_FLUX, 0),
        }
    }

    /// The sums of the planes of a kind of one twin, all channels; none where it is not declared.
    pub(super) fn plane_sums(&self, kind: &str, twin: Twin) -> impl Iterator<Item = &[f64]> {
        self.declaration.planes_of_kind(kind).map(move |index| self.twins[twin as usize][index].as_slice())
    }

    /// What decides a pixel's radius; 1 m² and no photons where the method gathers nothing.
    pub fn pixel(&self, index: usize) -> PixelEstimate {
        self.radii.pixel(index)
    }

    /// The same of all pixels.
    pub fn pixels(&self) -> Vec<PixelEstimate> {
        (0..self.pixel_count()).map(|index| self.pixel(index)).collect()
    }

    /// Bytes that the estimate takes for each pixel.
    pub fn bytes_per_pixel(&self) -> usize {
        let sums: usize = self.twins.iter().flatten().map(Vec::len).sum();
        let values = sums + self.radii.radius_squared.len() + self.radii.photons.len();
        values * size_of::<f64>() / self.pixel_count().max(1)
    }
}

fn ratio(above: f64, below: f64) -> f64 {
    if below == 0.0 { 0.0 } else { above / below }
}
