//! How much brighter a picture is shown than it is.

use std::fmt;
use std::str::FromStr;

use crate::estimate::Picture;
use crate::math::Rgb;
use crate::math::color::luminance;

/// The luminance that an automatic exposure gives to a picture's log-average, the middle grey of [Reinhard et al. 2002, eq. 2].
const KEY: f64 = 0.18;
/// The share of pixels at either end that an automatic exposure leaves out: fireflies, and what is almost black.
const TRIMMED: f64 = 0.01;
/// The most stops either way.
const MOST_STOPS: f32 = 64.0;

/// How much brighter a picture is shown than it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Multiplied by two to the power of so many stops.
    Stops(f32),
    /// Multiplied by 0.18 over the log-average of its luminance [Reinhard et al. 2002].
    Auto,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl Exposure {
    /// Whether it can be applied: stops are numbers from −64 to 64.
    pub fn is_possible(self) -> bool {
        match self {
            Self::Stops(stops) => (-MOST_STOPS..=MOST_STOPS).contains(&stops),
            Self::Auto => true,
        }
    }

    /// What a picture's radiance is multiplied by. A picture without any light stays as it is under [`Exposure::Auto`].
    pub fn factor(self, picture: &Picture) -> f32 {
        match self {
            Self::Stops(stops) => libm::exp2f(stops),
            Self::Auto => log_average_luminance(picture).map_or(1.0, |average| (KEY / average) as f32),
        }
    }
}

/// The log-average luminance [Reinhard et al. 2002, eq. 1], exp(1/N Σ ln Y), over the N pixels that remain: a pixel without light, or
/// whose luminance is not finite, has no logarithm and is left out instead of getting a small offset; of the others the
/// darkest and the brightest 1 % are left out. `None` when no pixel has light.
fn log_average_luminance(picture: &Picture) -> Option<f64> {
    let luminances = picture.radiance.iter().map(|pixel| luminance(Rgb::from_array(*pixel)));
    // The key over a number below the normal ones would be infinite.
    let mut lit: Vec<f32> = luminances.filter(|luminance| luminance.is_normal() && *luminance > 0.0).collect();
    lit.sort_unstable_by(f32::total_cmp);
    let trimmed = (lit.len() as f64 * TRIMMED) as usize;
    let kept = &lit[trimmed..lit.len() - trimmed];
    let sum: f64 = kept.iter().map(|luminance| libm::log(f64::from(*luminance))).sum();
    (!kept.is_empty()).then(|| libm::exp(sum / kept.len() as f64))
}

/// A text that is no exposure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no exposure; give a number of stops, or auto")]
pub struct BadExposure(String);

impl FromStr for Exposure {
    type Err = BadExposure;

    fn from_str(text: &str) -> Result<Self, BadExposure> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => text.parse().map(Self::Stops).map_err(|_| BadExposure(text.to_owned())),
        }
    }
}

impl fmt::Display for Exposure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stops(stops) => write!(out, "{stops}"),
            Self::Auto => write!(out, "auto"),
        }
    }
}
