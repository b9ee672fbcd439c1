//! Values as colors: a palette whose equal steps look equally different, on a linear or a logarithmic scale.

use super::drawing::Color;
use super::scale::{LogScale, linear_ticks};
use crate::estimate::picture_files::srgb_byte;

/// Where there is no value.
pub(super) const NO_VALUE: Color = [150, 150, 150];
/// Of all values so many are below the scale that is chosen for them, and as many above: a few stray ones do not stretch it.
const OUTSIDE: f64 = 0.005;
/// Positive values that spread over a larger ratio than this are shown on a logarithmic scale.
const WIDE: f64 = 30.0;

/// How values are spread over the colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Equal differences look alike.
    Linear,
    /// Equal ratios look alike. What is not above 0 has no value.
    Logarithmic,
}

/// What is asked of a scale; what is not follows from the values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaleRequest {
    /// How values are spread; else logarithmic where they are positive and differ much.
    pub spacing: Option<Spacing>,
    /// The value of the first color.
    pub low: Option<f64>,
    /// The value of the last color.
    pub high: Option<f64>,
}

/// Which value has which color. Values outside have the color of the nearer end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    spacing: Spacing,
    low: f64,
    high: f64,
}

/// A scale that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// There is nothing to show.
    #[error("no pixel has a value{}", if *.logarithmic { " above 0" } else { "" })]
    NoValue {
        /// Whether a logarithmic scale was asked for.
        logarithmic: bool,
    },
    /// The ends are in the wrong order.
    #[error("the scale would go from {low} to {high}; give a low end below the high end")]
    Ends {
        /// First value.
        low: f64,
        /// Last value.
        high: f64,
    },
    /// Logarithms of what is not above 0.
    #[error("a logarithmic scale cannot begin at {low}; give a low end above 0, or a linear scale")]
    NotPositive {
        /// First value.
        low: f64,
    },
}

impl ColorScale {
    /// From `low` to `high`, both finite.
    pub fn new(spacing: Spacing, low: f64, high: f64) -> Result<Self, ScaleError> {
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(ScaleError::Ends { low, high });
        }
        if spacing == Spacing::Logarithmic && low <= 0.0 {
            return Err(ScaleError::NotPositive { low });
        }
        Ok(Self { spacing, low, high })
    }

    /// A scale for `values`, which shows nearly all of them.
    pub fn covering(values: &[f32], request: ScaleRequest) -> Result<Self, ScaleError> {
        let mut finite: Vec<f64> = values.iter().map(|value| f64::from(*value)).filter(|v| v.is_finite()).collect();
        finite.sort_unstable_by(f64::total_cmp);
        let positive = &finite[finite.partition_point(|value| *value <= 0.0)..];
        let spacing = request.spacing.unwrap_or_else(|| {
            let [low, high] = range(positive).unwrap_or([1.0; 2]);
            let all = finite.first().is_some_and(|least| *least >= 0.0);
            if all && high > WIDE * low { Spacing::Logarithmic } else { Spacing::Linear }
        });
        let logarithmic = spacing == Spacing::Logarithmic;
        let [mut low, high] =
            range(if logarithmic { positive } else { &finite }).ok_or(ScaleError::NoValue { logarithmic })?;
        // What begins near 0 begins at 0.
        if !logarithmic && low > 0.0 && low < 0.3 * high {
            low = 0.0;
        }
        // One value alone stands in the middle.
        let (low, high) = match low < high {
            true => (low, high),
            false if logarithmic => (low / 2.0, high * 2.0),
            false if low == 0.0 => (-0.5, 0.5),
            false => (low - low.abs() / 2.0, low + low.abs() / 2.0),
        };
        Self::new(spacing, request.low.unwrap_or(low), request.high.unwrap_or(high))
    }

    /// Where a value lies from the first color, 0, to the last, 1, and beyond; `None` where it has no place.
    pub(super) fn share(&self, value: f32) -> Option<f64> {
        let value = f64::from(value);
        let share = match self.spacing {
            Spacing::Linear => (value - self.low) / (self.high - self.low),
            Spacing::Logarithmic if value > 0.0 => (value / self.low).ln() / (self.high / self.low).ln(),
            Spacing::Logarithmic => return None,
        };
        share.is_finite().then_some(share)
    }

    /// The color of a value.
    pub(super) fn color(&self, value: f32) -> Color {
        self.share(value).map_or(NO_VALUE, palette)
    }

    /// Round values and where they lie, 0 to 1.
    pub(super) fn ticks(&self) -> Vec<(f64, f64)> {
        let Self { spacing, low, high } = *self;
        let ticks = match spacing {
            Spacing::Linear => linear_ticks(low, high),
            Spacing::Logarithmic => LogScale { low, high, pixels: [0.0, 1.0] }.ticks(),
        };
        ticks.into_iter().filter_map(|tick| Some((tick, self.share(tick as f32)?.clamp(0.0, 1.0)))).collect()
    }
}

/// The least and the largest of sorted values, without the [`OUTSIDE`] ones.
fn range(sorted: &[f64]) -> Option<[f64; 2]> {
    let last = sorted.len().checked_sub(1)?;
    let skipped = (OUTSIDE * last as f64) as usize;
    Some([sorted[skipped], sorted[last - skipped]])
}

/// The color at `share` from 0 (dark violet) over blue and green to 1 (light yellow): a helix in Oklab [Ottosson 2020, "A perceptual
/// color space for image processing"], so lightness rises evenly and equal steps look equally different, to color-blind people by
/// lightness alone.
pub(super) fn palette(share: f64) -> Color {
    const LIGHTNESS: [f64; 2] = [0.22, 0.94];
    const HUE_DEGREES: [f64; 2] = [318.0, 105.0];
    /// As much as screens can show all along the way.
    const CHROMA: f64 = 0.1;
    let between = |[from, to]: [f64; 2]| from + share.clamp(0.0, 1.0) * (to - from);
    let (sin, cos) = between(HUE_DEGREES).to_radians().sin_cos();
    oklab_to_srgb([between(LIGHTNESS), CHROMA * cos, CHROMA * sin])
}

fn oklab_to_srgb([lightness, a, b]: [f64; 3]) -> Color {
    let cone = |from_a: f64, from_b: f64| (lightness + from_a * a + from_b * b).powi(3);
    let long = cone(0.396_337_777_4, 0.215_803_757_3);
    let medium = cone(-0.105_561_345_8, -0.063_854_172_8);
    let short = cone(-0.089_484_177_5, -1.291_485_548_0);
    let linear = [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ];
    linear.map(|value| srgb_byte(value as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_follow_from_the_values() {
        let covering = |values: &[f32]| ColorScale::covering(values, ScaleRequest::default());
        let wide: Vec<f32> = (0..1000).map(|i| 10f32.powf(i as f32 / 250.0)).collect();
        let scale = covering(&wide).expect("values");
        assert_eq!(scale.spacing, Spacing::Logarithmic);
        assert!(scale.low < 1.1 && scale.high > 9000.0, "{scale:?}");
        assert_eq!(scale.color(0.0), NO_VALUE);
        assert_eq!(scale.color(f32::NAN), NO_VALUE);
        assert_eq!(scale.color(1e9), palette(1.0));
        let narrow = covering(&[5.0, 6.0, f32::INFINITY, 7.0]).expect("values");
        assert_eq!(narrow, ColorScale { spacing: Spacing::Linear, low: 5.0, high: 7.0 });
        assert_eq!(narrow.ticks().first(), Some(&(5.0, 0.0)));
        assert_eq!(covering(&[-1.0, 0.0, 500.0]).map(|scale| scale.spacing), Ok(Spacing::Linear));
        assert_eq!(covering(&[3.0, 3.0]).map(|scale| scale.share(3.0)), Ok(Some(0.5)));
        assert_eq!(covering(&[0.0, 0.0]).map(|scale| scale.share(0.0)), Ok(Some(0.5)));
        assert_eq!(covering(&[f32::NAN]), Err(ScaleError::NoValue { logarithmic: false }));
    }

    #[test]
    fn impossible_scales_are_refused() {
        let request = |spacing, low, high| {
            ColorScale::covering(&[-2.0, 1.0, 2.0], ScaleRequest { spacing, low, high }).expect_err("impossible")
        };
        let logarithmic = Some(Spacing::Logarithmic);
        assert_eq!(request(logarithmic, Some(0.0), None), ScaleError::NotPositive { low: 0.0 });
        assert_eq!(request(None, Some(5.0), None), ScaleError::Ends { low: 5.0, high: 2.0 });
        assert!(matches!(request(None, None, Some(f64::NAN)), ScaleError::Ends { .. }));
        let none = ColorScale::covering(&[-1.0, 0.0], ScaleRequest { spacing: logarithmic, ..Default::default() });
        assert_eq!(none, Err(ScaleError::NoValue { logarithmic: true }));
    }

    /// CIE 1976 lightness, which is not the space that the palette is made in, rises all the way and never much faster than elsewhere.
    #[test]
    fn the_palette_rises_evenly_and_is_never_grey() {
        let lightness = |color: Color| {
            let linear = color.map(|byte| {
                let value = f64::from(byte) / 255.0;
                if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            });
            116.0 * (0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]).cbrt() - 16.0
        };
        let steps: Vec<f64> = (0..16)
            .map(|i| lightness(palette(f64::from(i + 1) / 16.0)) - lightness(palette(f64::from(i) / 16.0)))
            .collect();
        assert!(steps.iter().all(|step| (3.5..7.5).contains(step)), "{steps:?}");
        for share in 0..=100 {
            let color = palette(f64::from(share) / 100.0).map(i32::from);
            let spread = color.iter().max().zip(color.iter().min()).map_or(0, |(most, least)| most - least);
            assert!(spread > 40, "{color:?} at {share} %");
            assert!(color.iter().all(|byte| *byte < 255), "{color:?} is cut off at {share} %");
        }
    }
}
