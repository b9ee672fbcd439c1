//! Picking one of n things with given weights.

/// A discrete distribution with probabilities proportional to non-negative weights.
#[derive(Clone, Debug)]
pub struct Discrete {
    /// Cumulative probabilities; the last is exactly 1.
    cumulative: Vec<f32>,
    probabilities: Vec<f32>,
    /// Where the search for a number in each of equal parts of [0, 1) begins, a power of two of them [Chen & Asau 1974, "On generating
    /// random variates from an empirical distribution"]; empty for [`FEW`] things.
    guide: Vec<u32>,
    total: f64,
}

impl Discrete {
    /// Builds from `weights` ≥ 0. `None` when they are empty, sum to 0 or are not finite.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = weights
            .iter()
            .map(|weight| {
                sum += weight;
                (sum / total) as f32
            })
            .collect();
        let last_possible = weights.iter().rposition(|weight| *weight > 0.0)?;
        cumulative[last_possible..].fill(1.0);
        let probabilities = weights.iter().map(|weight| (weight / total) as f32).collect();
        let guide = guide(&cumulative);
        Some(Self { cumulative, probabilities, guide, total })
    }

    /// The sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The probability with which `index` is picked.
    pub fn probability(&self, index: usize) -> f32 {
        self.probabilities[index]
    }

    /// The probability of an index below `place`: a whole one and the part of the next that counts.
    pub fn share_below(&self, place: f32) -> f32 {
        let index = place as usize;
        if index >= self.cumulative.len() {
            return 1.0;
        }
        let below = if index == 0 { 0.0 } else { self.cumulative[index - 1] };
        below + (self.cumulative[index] - below) * (place - index as f32)
    }

    /// Picks an index with `u` in [0, 1) and gives back `u` rescaled to [0, 1) for further use.
    #[inline]
    pub fn pick(&self, u: f32) -> (usize, f32) {
        if self.cumulative.len() == 1 {
            return (0, u.clamp(0.0, ONE_MINUS_EPSILON));
        }
        let index = if self.guide.is_empty() { self.find(u) } else { self.find_by_guide(u) };
        let below = if index == 0 { 0.0 } else { self.cumulative[index - 1] };
        let width = self.cumulative[index] - below;
        (index, ((u - below) / width).clamp(0.0, ONE_MINUS_EPSILON))
    }

    #[inline]
    fn find(&self, u: f32) -> usize {
        self.cumulative.partition_point(|sum| *sum <= u).min(self.cumulative.len() - 1)
    }

    #[inline(never)]
    fn find_by_guide(&self, u: f32) -> usize {
        // Callers rescale numbers, and rounding may lead to 1.
        let u = u.min(ONE_MINUS_EPSILON);
        let mut index = self.guide[(u * self.guide.len() as f32) as u32 as usize] as usize;
        while self.cumulative[index] <= u {
            index += 1;
        }
        index
    }
}

/// Up to so many things are searched without a guide.
const FEW: usize = 16;

/// The first index above the beginning of each part, about half as many as there are indices.
fn guide(cumulative: &[f32]) -> Vec<u32> {
    if cumulative.len() <= FEW {
        return Vec::new();
    }
    let parts = cumulative.len().next_power_of_two() / 2;
    let first = |part: usize| cumulative.partition_point(|sum| *sum <= part as f32 / parts as f32) as u32;
    (0..parts).map(first).collect()
}

/// The largest `f32` below 1.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;
