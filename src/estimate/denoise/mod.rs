//! A picture with less noise, made of its two independent halves and of what its pixels see first.
//!
//! The even and the odd passes of a job are two independent pictures of the same thing, its twins. Each is filtered with weights that the
//! **other** one tells (dual buffers), so that no noise chooses its own neighbours and bright outliers keep their energy
//! [Rousselle et al. 2012]. Every pixel gets two estimates from a window of 15 × 15 pixels:
//!
//! - a **mean** of the pixels whose surroundings look the same beyond any doubt, and
//! - a **linear fit** of the light to albedo, normal and place, over all pixels that may look the same
//!   [Bitterli et al. 2016].
//!
//! What each is wrong by follows from the twins, too: a filtered twin against the other one unfiltered. The better one is taken, and its error told.
//!
//! | file | what |
//! |---|---|
//! | [`twins`] | the halves of an estimate |
//! | `planes` | pictures with a margin, cut into tiles |
//! | `similarity` | how alike two pixels' surroundings are |
//! | `fits` | the two estimates of every pixel |
//! | `choice` | which of them is taken |
//! | `own_error` | how wrong the result is |
//! | `box_mean` | means over squares |
//!
//! All sums run in a fixed order inside a pixel, and threads share nothing but what they read: any number of them gives the same bits.

mod box_mean;
mod choice;
mod fits;
mod own_error;
mod planes;
mod similarity;
pub(crate) mod twins;

use super::Picture;
pub use fits::{FEATURE_REACH, RIDGE, SLOPE_PRIOR, WINDOW};
pub use similarity::{MOST_DISSIMILAR, PATCH};
pub use twins::Twins;

/// Red, green and blue as planes, row-major, top row first.
pub type Color = [Vec<f32>; 3];

/// What pixels see first, as planes.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// The share of light that is scattered.
    pub albedo: Color,
    /// The shading normal.
    pub normal: Color,
    /// The place, m.
    pub position: Color,
}

/// A picture with less noise, and how wrong it is by what the twins tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Denoised {
    /// The picture.
    pub picture: Picture,
    /// Its standard error in every pixel, W·sr⁻¹·m⁻²: root mean square of the channels, over the 9 × 9 pixels around. It lies where the filtered twins
    /// differ, and is as large in all as `relmse`.
    pub standard_error: Vec<f32>,
    /// The error of the whole picture: noise that is left and what the filter blurs count, what the method is wrong by in both twins alike does not.
    pub relmse: f64,
}

/// A picture that cannot be denoised.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DenoiseError {
    /// There is only one half.
    #[error(
        "denoising compares the even with the odd passes, and some part of the picture does not have both yet; wait for 2 passes"
    )]
    OneTwin,
    /// Sums overflowed.
    #[error("the picture holds a number that is infinite or none; it cannot be denoised")]
    NotFinite,
    /// Planes of different sizes.
    #[error("the {what} has {found} values where the picture has {expected} pixels")]
    WrongSize {
        /// Which plane.
        what: &'static str,
        /// Its values.
        found: usize,
        /// Pixels of the picture.
        expected: usize,
    },
}

/// Filters both twins and joins them. Runs on the calling rayon pool.
pub fn denoise(twins: &Twins, features: &Features) -> Result<Denoised, DenoiseError> {
    check(twins, features)?;
    let brightness = twins.mean();
    if brightness == 0.0 {
        return Ok(black(twins));
    }
    // Relative to the picture's mean, no square of a number overflows and small constants mean the same for every scene.
    let relative = twins.scaled(1.0 / brightness);
    let fits = fits::fit(&relative, &features.normalized());
    let filtered = choice::choose(&relative, fits);
    let error = own_error::measure(&relative, &filtered);
    let joined = relative.join(&filtered);
    let pixel = |index: usize| joined.each_ref().map(|channel| channel[index] * brightness);
    let radiance = (0..twins.pixel_count()).map(pixel).collect();
    let picture = Picture { width: twins.width as u32, height: twins.height as u32, radiance };
    let standard_error = error.per_pixel.iter().map(|error| error * brightness).collect();
    Ok(Denoised { picture, standard_error, relmse: error.relmse })
}

fn check(twins: &Twins, features: &Features) -> Result<(), DenoiseError> {
    let expected = twins.pixel_count();
    let planes = [
        ("even twin", &twins.radiance[0]),
        ("odd twin", &twins.radiance[1]),
        ("albedo", &features.albedo),
        ("normal", &features.normal),
        ("position", &features.position),
    ];
    for (what, plane) in planes.into_iter().flat_map(|(what, color)| color.iter().map(move |plane| (what, plane))) {
        if plane.len() != expected {
            return Err(DenoiseError::WrongSize { what, found: plane.len(), expected });
        }
        if !plane.iter().all(|value| value.is_finite()) {
            return Err(DenoiseError::NotFinite);
        }
    }
    Ok(())
}

fn black(twins: &Twins) -> Denoised {
    let pixels = twins.pixel_count();
    let picture = Picture { width: twins.width as u32, height: twins.height as u32, radiance: vec![[0.0; 3]; pixels] };
    Denoised { picture, standard_error: vec![0.0; pixels], relmse: 0.0 }
}

/// Numbers of what a pixel sees first.
const FEATURES: usize = 9;

impl Features {
    /// Each number less its mean over the picture and over its standard deviation; 0 where all pixels have the same.
    fn normalized(&self) -> [Vec<f32>; FEATURES] {
        let planes = self.albedo.iter().chain(&self.normal).chain(&self.position);
        let mut normalized = planes.map(|plane| {
            let count = plane.len() as f64;
            let mean = plane.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
            let variance = plane.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>() / count;
            // Less is rounding.
            let scale = if variance > 1e-12 * (1.0 + mean * mean) { 1.0 / variance.sqrt() } else { 0.0 };
            plane.iter().map(|value| ((f64::from(*value) - mean) * scale) as f32).collect()
        });
        std::array::from_fn(|_| normalized.next().unwrap_or_default())
    }
}
