//! Reconstruction filters, by sampling them: a pixel's camera paths spread as the filter weighs, and all count the same
//! [Ernst, Stamminger & Greiner 2006, "Filter importance sampling"].
//!
//! | plugin | weight at distance x from the pixel's middle | parameters (pixels) |
//! |---|---|---|
//! | `box` | 1 within `radius` | `radius` (0.5) |
//! | `tent` | 1 - x/`radius` | `radius` (1) |
//! | `gaussian` | exp(-x²/2σ²) - exp(-8), up to 4σ | `stddev` σ (0.5) |
//!
//! Filters with negative lobes (`mitchell`, `catmullrom`, `lanczos`) cannot be sampled so: a path would count negatively, and
//! photon statistics count whole photons. They are replaced by `gaussian`, with a notice.

use std::sync::Arc;

use crate::math::discrete::Discrete;
use crate::scene::description::Node;
use crate::scene::error::{SceneError, nearest_name};
use crate::scene::fields::Fields;

/// A reconstruction filter, the same along both axes.
#[derive(Clone, Debug)]
pub enum Filter {
    /// The pixel's own square.
    Box,
    /// Up to `radius` pixels from the middle, in bins of equal width.
    Sampled {
        /// Half the width of all bins, pixels.
        radius: f32,
        /// By the filter's weight.
        bins: Arc<Discrete>,
    },
}

const BINS: usize = 512;
/// The largest radius, pixels: beyond it a picture is nothing but blur.
const LARGEST: f64 = 64.0;
const SAMPLED: &[&str] = &["box", "tent", "gaussian"];
const WITH_NEGATIVE_LOBES: &[&str] = &["mitchell", "catmullrom", "lanczos"];

/// Reads a filter; a replacement is added to `notices`.
pub(super) fn read(node: &Node, notices: &mut Vec<String>) -> Result<Filter, SceneError> {
    let mut fields = Fields::new(node);
    let filter = match node.plugin.as_str() {
        "box" => match size(&mut fields, "radius", 0.5)? {
            0.5 => Filter::Box,
            radius => Filter::sampled(radius, |_| 1.0),
        },
        "tent" => {
            let radius = size(&mut fields, "radius", 1.0)?;
            Filter::sampled(radius, |x| 1.0 - x / radius)
        }
        "gaussian" => Filter::gaussian(size(&mut fields, "stddev", 0.5)?),
        name if WITH_NEGATIVE_LOBES.contains(&name) => {
            fields.ignore(&["A", "B", "C", "lobes", "radius"]);
            notices.push(format!(
                "{}: filter \"{name}\" has negative lobes, which photon statistics cannot weigh; it is replaced by \"gaussian\"",
                node.location
            ));
            Filter::gaussian(0.5)
        }
        other => {
            let known: Vec<&str> = SAMPLED.iter().chain(WITH_NEGATIVE_LOBES).copied().collect();
            let problem = format!("there is no rfilter \"{other}\"");
            return Err(SceneError::new(&node.location, problem, nearest_name(other, &known)));
        }
    };
    fields.finish()?;
    Ok(filter)
}

fn size(fields: &mut Fields<'_>, name: &'static str, default: f64) -> Result<f64, SceneError> {
    match fields.float(name)?.unwrap_or(default) {
        size if size > 0.0 && size <= LARGEST => Ok(size),
        size => {
            let problem = format!("\"{name}\" is {size} pixels");
            Err(fields.error(name, problem, format!("give a number above 0, up to {LARGEST}")))
        }
    }
}

impl Filter {
    fn gaussian(deviation: f64) -> Self {
        let weight = |x: f64| libm::exp(-0.5 * (x / deviation) * (x / deviation)) - libm::exp(-8.0);
        Self::sampled(4.0 * deviation, weight)
    }

    /// A filter with `weight` ≥ 0 at a distance up to `radius`, pixels.
    fn sampled(radius: f64, weight: impl Fn(f64) -> f64) -> Self {
        let middle = |bin: usize| radius * ((bin as f64 + 0.5) / BINS as f64 * 2.0 - 1.0);
        let weights: Vec<f64> = (0..BINS).map(|bin| weight(middle(bin).abs())).collect();
        match Discrete::new(&weights) {
            Some(bins) => Self::Sampled { radius: radius as f32, bins: Arc::new(bins) },
            None => Self::Box,
        }
    }

    /// The first and last pixel, not rounded, that a place on the film, pixels, may count in.
    #[inline]
    pub fn reach(&self, at: f32) -> (f32, f32) {
        match self {
            Self::Box => (at.floor(), at.floor()),
            Self::Sampled { radius, .. } => ((at - 0.5 - radius).floor(), (at - 0.5 + radius).ceil()),
        }
    }

    /// The density of [`Filter::place`] at a place from the pixel's left or upper edge, pixels⁻¹.
    #[inline]
    pub fn weight(&self, place: f32) -> f32 {
        match self {
            Self::Box => f32::from(u8::from((0.0..1.0).contains(&place))),
            Self::Sampled { radius, bins } => {
                let bin = ((place - 0.5) / radius + 1.0) * (0.5 * BINS as f32);
                if !(0.0..BINS as f32).contains(&bin) {
                    return 0.0;
                }
                bins.probability(bin as usize) * (0.5 * BINS as f32) / radius
            }
        }
    }

    /// A place from the pixel's left or upper edge, pixels: by the filter's weight, for `u` uniform in [0, 1).
    #[inline]
    pub fn place(&self, u: f32) -> f32 {
        match self {
            Self::Box => u,
            Self::Sampled { radius, bins } => {
                let (bin, rest) = bins.pick(u);
                0.5 + radius * ((bin as f32 + rest) * (2.0 / BINS as f32) - 1.0)
            }
        }
    }
}
