//! Reconstruction filters, by sampling them: a pixel's camera paths spread as the filter weighs, and all count the same
//! [Ernst, Stamminger & Greiner 2006, "Filter importance sampling"].
//!
//! | plugin | weight at distance x from the pixel's middle | parameters (pixels) |
//! |---|---|---|
//! | `box` | 1 within `radius` | `radius` (0.5) |
//! | `tent` | 1 - x/`radius` | `radius` (1) |
//! | `gaussian` | exp(-x²/2σ²) - exp(-8), up to 4σ | `stddev` σ (0.5) |
//! | `mitchell` | cubic up to 2 [Mitchell & Netravali 1988, "Reconstruction filters in computer graphics", eq. 8] | `B` (⅓) and `C` (⅓) |
//! | `catmullrom` | the same with 0 and ½ | – |
//! | `lanczos` | sinc(πx)·sinc(πx/`lobes`), up to `lobes` | `lobes` (3) |
//!
//! The last three have negative lobes: places are sampled by the absolute weight, and each path counts ±∫|f|/∫f. The signs are
//! noise even where a picture is even, so methods with smooth passes take `gaussian` instead: see `MethodEntry::negative_lobes`.
//!
//! At the edges of a picture, where no camera path starts outside, the part of a filter that lies inside stands for the whole.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::math::discrete::Discrete;
use crate::scene::description::Node;
use crate::scene::error::{SceneError, nearest_name, shown_number};
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
        /// By the filter's absolute weight.
        bins: Arc<Discrete>,
        /// What a sample counts, by bin: 1, or ±∫|f|/∫f where the filter has negative lobes; empty for all 1.
        counts: Arc<[f32]>,
        /// ∫f up to the left edge of each bin, and up to the end, as a share of the whole; with negative lobes not monotonic.
        integrals: Arc<[f32]>,
    },
}

const BINS: usize = 512;
/// The largest radius, pixels: beyond it a picture is nothing but blur.
const LARGEST: f64 = 64.0;
const NAMES: &[&str] = &["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"];

/// Reads a filter.
pub(super) fn read(node: &Node) -> Result<Filter, SceneError> {
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
        "mitchell" => {
            let [b, c] = [cubic_parameter(&mut fields, "B")?, cubic_parameter(&mut fields, "C")?];
            Filter::sampled(2.0, |x| cubic(x, b, c))
        }
        "catmullrom" => Filter::sampled(2.0, |x| cubic(x, 0.0, 0.5)),
        "lanczos" => {
            let lobes = lobes(&mut fields)?;
            Filter::sampled(lobes, |x| sinc(x) * sinc(x / lobes))
        }
        other => {
            let problem = format!("there is no rfilter \"{other}\"");
            return Err(SceneError::new(&node.location, problem, nearest_name(other, NAMES)));
        }
    };
    fields.finish()?;
    Ok(filter)
}

fn size(fields: &mut Fields<'_>, name: &'static str, default: f64) -> Result<f64, SceneError> {
    match fields.float(name)?.unwrap_or(default) {
        size if size > 0.0 && size <= LARGEST => Ok(size),
        size => {
            let problem = format!("\"{name}\" is {} pixels", shown_number(size));
            Err(fields.error(name, problem, format!("give a number above 0, up to {LARGEST}")))
        }
    }
}

/// B or C of the cubic filters; in this range they ring, blur or alias, but stay filters.
fn cubic_parameter(fields: &mut Fields<'_>, name: &'static str) -> Result<f64, SceneError> {
    match fields.float(name)?.unwrap_or(1.0 / 3.0) {
        parameter if (0.0..=1.0).contains(&parameter) => Ok(parameter),
        parameter => {
            Err(fields.error(name, format!("\"{name}\" is {}", shown_number(parameter)), "give a number from 0 to 1"))
        }
    }
}

fn lobes(fields: &mut Fields<'_>) -> Result<f64, SceneError> {
    match fields.integer("lobes")?.unwrap_or(3) {
        lobes @ 1..=16 => Ok(lobes as f64),
        lobes => Err(fields.error("lobes", format!("\"lobes\" is {lobes}"), "give a whole number from 1 to 16")),
    }
}

/// [Mitchell & Netravali 1988, eq. 8].
fn cubic(x: f64, b: f64, c: f64) -> f64 {
    let value = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x.powi(2) + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x.powi(3)
            + (6.0 * b + 30.0 * c) * x.powi(2)
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    };
    value / 6.0
}

/// sin πx / πx.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(PI * x) / (PI * x) }
}

impl Filter {
    /// `gaussian` with the standard deviation `deviation`, pixels.
    pub(super) fn gaussian(deviation: f64) -> Self {
        let weight = |x: f64| libm::exp(-0.5 * (x / deviation) * (x / deviation)) - libm::exp(-8.0);
        Self::sampled(4.0 * deviation, weight)
    }

    /// A filter with `weight` at a distance up to `radius`, pixels.
    fn sampled(radius: f64, weight: impl Fn(f64) -> f64) -> Self {
        let middle = |bin: usize| radius * ((bin as f64 + 0.5) / BINS as f64 * 2.0 - 1.0);
        let weights: Vec<f64> = (0..BINS).map(|bin| weight(middle(bin).abs())).collect();
        let absolute: Vec<f64> = weights.iter().map(|weight| weight.abs()).collect();
        let Some(bins) = Discrete::new(&absolute) else { return Self::Box };
        let counts: Vec<f32> = match weights.iter().all(|weight| *weight >= 0.0) {
            true => Vec::new(),
            false => {
                let count = bins.total() / weights.iter().sum::<f64>();
                weights.iter().map(|weight| count.copysign(*weight) as f32).collect()
            }
        };
        let whole: f64 = weights.iter().sum();
        let sums = weights.iter().scan(0.0, |sum, weight| {
            *sum += weight;
            Some((*sum / whole) as f32)
        });
        let integrals = std::iter::once(0.0).chain(sums).collect();
        Self::Sampled { radius: radius as f32, bins: Arc::new(bins), counts: counts.into(), integrals }
    }

    /// Whether some paths count negatively.
    pub fn has_negative_lobes(&self) -> bool {
        matches!(self, Self::Sampled { counts, .. } if !counts.is_empty())
    }

    /// The first and last pixel, not rounded, that a place on the film, pixels, may count in.
    #[inline]
    pub fn reach(&self, at: f32) -> (f32, f32) {
        match self {
            Self::Box => (at.floor(), at.floor()),
            Self::Sampled { radius, .. } => ((at - 0.5 - radius).floor(), (at - 0.5 + radius).ceil()),
        }
    }

    /// The filter at a place from the pixel's left or upper edge, with an integral of 1, pixels⁻¹: the density of
    /// [`Filter::sample`] times what a sample counts.
    #[inline]
    pub fn weight(&self, place: f32) -> f32 {
        match self {
            Self::Box => f32::from(u8::from((0.0..1.0).contains(&place))),
            Self::Sampled { radius, bins, counts, .. } => {
                let bin = ((place - 0.5) / radius + 1.0) * (0.5 * BINS as f32);
                if !(0.0..BINS as f32).contains(&bin) {
                    return 0.0;
                }
                let count = counts.get(bin as usize).copied().unwrap_or(1.0);
                bins.probability(bin as usize) * count * (0.5 * BINS as f32) / radius
            }
        }
    }

    /// A place from the pixel's left or upper edge, pixels, by the filter's absolute weight, for `u` uniform in [0, 1); and
    /// what a path through it counts.
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32) {
        match self {
            Self::Box => (u, 1.0),
            Self::Sampled { radius, bins, counts, .. } => {
                let (bin, rest) = bins.pick(u);
                let place = 0.5 + radius * ((bin as f32 + rest) * (2.0 / BINS as f32) - 1.0);
                (place, counts.get(bin).copied().unwrap_or(1.0))
            }
        }
    }

    /// [`Filter::weight`] of the part of the filter between two `edges`, places from the pixel's left or upper edge; that part has
    /// an integral of 1.
    #[inline]
    pub fn weight_within(&self, place: f32, edges: impl FnOnce() -> [f32; 2]) -> f32 {
        match self.part_within(edges) {
            None => self.weight(place),
            Some(edges) => self.weight(place) / self.integral(edges),
        }
    }

    /// [`Filter::sample`] of the part of the filter between two `edges`, places from the pixel's left or upper edge.
    #[inline]
    pub fn sample_within(&self, u: f32, edges: impl FnOnce() -> [f32; 2]) -> (f32, f32) {
        match self.part_within(edges) {
            None => self.sample(u),
            Some(edges) => self.sample_part(u, edges),
        }
    }

    /// The edges, if they leave out some of the filter.
    #[inline]
    fn part_within(&self, edges: impl FnOnce() -> [f32; 2]) -> Option<[f32; 2]> {
        let Self::Sampled { radius, .. } = self else { return None };
        let [first, last] = edges();
        (first > 0.5 - radius || last < 0.5 + radius).then_some([first, last])
    }

    #[inline(never)]
    fn sample_part(&self, u: f32, edges: [f32; 2]) -> (f32, f32) {
        let Self::Sampled { bins, counts, .. } = self else { return self.sample(u) };
        let [low, high] = edges.map(|edge| bins.share_below(self.bin_of(edge)));
        let (place, count) = self.sample(low + u * (high - low));
        // Where no weight is negative the two integrals are the same, up to rounding.
        let count = if counts.is_empty() { 1.0 } else { count * (high - low) / self.integral(edges) };
        // Rounding must not lead out of the picture.
        (place.clamp(edges[0], edges[1]), count)
    }

    /// The bin of a place from the pixel's left or upper edge, with the part of it that lies below.
    fn bin_of(&self, place: f32) -> f32 {
        match self {
            Self::Box => 0.0,
            Self::Sampled { radius, .. } => {
                (((place - 0.5) / radius + 1.0) * (0.5 * BINS as f32)).clamp(0.0, BINS as f32)
            }
        }
    }

    /// ∫f between two places from the pixel's left or upper edge, as a share of the whole.
    fn integral(&self, edges: [f32; 2]) -> f32 {
        let Self::Sampled { integrals, .. } = self else { return 1.0 };
        let [low, high] = edges.map(|edge| {
            let bin = self.bin_of(edge);
            let whole = (bin as usize).min(BINS - 1);
            integrals[whole] + (integrals[whole + 1] - integrals[whole]) * (bin - whole as f32)
        });
        high - low
    }
}
