//! Axes and their round values.

use super::drawing::{Anchor, Drawing, FAINT_TONE, GRID, TEXT};

/// A range of values above 0 along a range of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogScale {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Pixels of `low` and `high`.
    pub(super) pixels: [f64; 2],
}

impl LogScale {
    /// Covers the values above 0 among `values` with a margin; a decade around 1 if there are none.
    pub(super) fn covering(values: impl Iterator<Item = f64>, pixels: [f64; 2]) -> Self {
        const MARGIN: f64 = 0.06;
        let (low, high) = values
            .filter(|value| *value > 0.0 && value.is_finite())
            .fold((f64::MAX, f64::MIN_POSITIVE), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low > high { (0.3, 3.0) } else { (low, high.max(1.5 * low)) };
        let margin = (high / low).powf(MARGIN);
        Self { low: low / margin, high: high * margin, pixels }
    }

    /// The value's pixel. Values outside lie on the range's ends.
    pub(super) fn place(&self, value: f64) -> f64 {
        let share = (value.clamp(self.low, self.high) / self.low).ln() / (self.high / self.low).ln();
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Round values within the range, three to eight of them where that is possible.
    pub(super) fn ticks(&self) -> Vec<f64> {
        const STEPS: [&[f64]; 4] = [&[1.0], &[1.0, 3.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]];
        let within = |steps: &[f64]| -> Vec<f64> {
            let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
            // Divided where that is exact, so that labels are round.
            let power = |value: f64, decade: i32| {
                if decade < 0 { value / 10f64.powi(-decade) } else { value * 10f64.powi(decade) }
            };
            let values = decades.flat_map(|decade| steps.iter().map(move |step| power(*step, decade)));
            values.filter(|value| (self.low..=self.high).contains(value)).collect()
        };
        let candidates = STEPS.map(within);
        let enough = candidates.iter().find(|ticks| ticks.len() >= 3).unwrap_or(&candidates[3]);
        // More than eight decades: leave some out.
        let every = enough.len().div_ceil(8).max(1);
        enough.iter().copied().step_by(every).collect()
    }
}

impl Drawing {
    /// Axes with their ticks and a grid, and what `x` counts.
    pub(super) fn axes(&mut self, x: &LogScale, y: &LogScale, counted: &str) {
        const SMALL: f64 = TEXT - 1.0;
        let ([left, right], [bottom, top]) = (x.pixels, y.pixels);
        for value in y.ticks() {
            let place = y.place(value);
            self.line(vec![[left, place], [right, place]], GRID, 0.75);
            self.text([left - 7.0, place], number(value), SMALL, FAINT_TONE, Anchor::End);
        }
        for value in x.ticks() {
            let place = x.place(value);
            self.line(vec![[place, bottom], [place, top]], GRID, 0.75);
            self.text([place, bottom + 13.0], number(value), SMALL, FAINT_TONE, Anchor::Middle);
        }
        self.line(vec![[left, top], [left, bottom], [right, bottom]], FAINT_TONE, 1.0);
        self.text([right, bottom + 30.0], counted, SMALL, FAINT_TONE, Anchor::End);
    }
}

/// Round values from `low` to `high` at equal distances, three to seven of them.
pub(super) fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    const MOST: f64 = 6.0;
    /// Shares of a step that rounding may cost.
    const ROUNDING: f64 = 1e-6;
    let power = 10f64.powf(((high - low) / MOST).log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power * MOST >= high - low).unwrap_or(10.0);
    let step = factor * power;
    let [first, last] = [(low / step - ROUNDING).ceil(), (high / step + ROUNDING).floor()];
    (0..=(last - first) as u32).map(|index| (first + f64::from(index)) * step).collect()
}

/// A number in as few letters as it needs.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e5).contains(&value.abs()) {
        let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 7.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::{LogScale, linear_ticks, number};

    #[test]
    fn ticks_are_round_and_places_proportional_to_logarithms() {
        let scale = LogScale { low: 0.9, high: 33.0, pixels: [0.0, 100.0] };
        assert_eq!(scale.ticks(), [1.0, 3.0, 10.0, 30.0]);
        assert_eq!(scale.place(0.9), 0.0);
        assert_eq!(scale.place(33.0), 100.0);
        assert!((scale.place((0.9f64 * 33.0).sqrt()) - 50.0).abs() < 1e-9);
        let narrow = LogScale { low: 0.011, high: 0.029, pixels: [0.0, 1.0] };
        assert!(narrow.ticks().len() >= 2, "{:?}", narrow.ticks());
    }

    #[test]
    fn linear_ticks_are_round() {
        let texts = |low, high| linear_ticks(low, high).into_iter().map(number).collect::<Vec<_>>();
        assert_eq!(texts(0.0, 1.0), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(texts(-1.0, 1.0), ["-1", "-0.5", "0", "0.5", "1"]);
        assert_eq!(texts(0.031, 0.052), ["0.035", "0.04", "0.045", "0.05"]);
        assert_eq!(texts(0.0, 7e7), ["0", "2e7", "4e7", "6e7"]);
        assert!((3..=7).contains(&linear_ticks(3.3e-9, 8.1e-9).len()));
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0001, 0.003, 0.5, 1.0, 30.0, 12.345, 1234.5, 3e-5, 1e6].map(number);
        assert_eq!(texts, ["0.0001", "0.003", "0.5", "1", "30", "12.3", "1234", "3e-5", "1e6"]);
    }
}
