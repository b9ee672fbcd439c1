//! One channel of a picture, and filters over it.

/// Values of one channel, row-major.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f64>,
}

impl Plane {
    /// The plane whose values are `function` of the values of two planes of one size.
    pub(super) fn combined(&self, other: &Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| function(*a, *b)).collect();
        Self { values, ..*self }
    }

    /// Correlated with `columns` along the rows and with `rows` down the columns. Both have an odd number of weights, the middle one for
    /// the pixel itself; beyond the border the border's own pixels go on.
    pub(super) fn filtered(&self, columns: &[f64], rows: &[f64]) -> Self {
        let along = |x: usize, y: usize| self.weighted(columns, |offset| (offset.at(x, self.width), y));
        let across = self.with_values(along);
        across.with_values(|x, y| across.weighted(rows, |offset| (x, offset.at(y, self.height))))
    }

    fn with_values(&self, value: impl Fn(usize, usize) -> f64) -> Self {
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        Self { values: pixels.map(|(x, y)| value(x, y)).collect(), ..*self }
    }

    fn weighted(&self, weights: &[f64], place: impl Fn(Offset) -> (usize, usize)) -> f64 {
        let sum = weights.iter().enumerate().map(|(index, weight)| {
            let (x, y) = place(Offset { index, radius: weights.len() / 2 });
            weight * self.values[y * self.width + x]
        });
        sum.sum()
    }
}

/// A weight's distance from the middle one.
#[derive(Clone, Copy)]
struct Offset {
    index: usize,
    radius: usize,
}

impl Offset {
    /// The pixel this far from `position` of `size`.
    fn at(self, position: usize, size: usize) -> usize {
        (position + self.index).saturating_sub(self.radius).min(size - 1)
    }
}

/// `exp(−x²/2σ²)` for `x` from −`radius` to `radius`, not normalised.
pub(super) fn gaussian(deviation: f64, radius: usize) -> Vec<f64> {
    let value = |index: usize| {
        let x = index as f64 - radius as f64;
        (-x * x / (2.0 * deviation * deviation)).exp()
    };
    (0..=2 * radius).map(value).collect()
}

/// The weights divided by their sum.
pub(super) fn normalised(weights: Vec<f64>) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}
