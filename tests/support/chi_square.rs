//! Pearson's χ² test, and numbers for it.

use std::f64::consts::TAU;

use photonfarm::math::Vec3;
use photonfarm::math::random::{PathRandom, Stream};

/// The chance that any of the tests of this crate that use [`Histogram`] fails although the code is right.
const SIGNIFICANCE: f64 = 1e-3;
/// An upper bound on the number of such tests.
const TESTS: f64 = 1024.0;
/// Bins that expect fewer samples are pooled.
const LEAST_EXPECTED: f64 = 5.0;

/// Four numbers in [0, 1) for each sample; `family` keeps tests apart.
pub(crate) fn numbers(family: u32, sample: u32) -> [f32; 4] {
    PathRandom::new(0x5eed_c411, Stream::Camera, family, sample).block(0)
}

/// The level of one test by Šidák's correction.
pub(crate) fn level_of_one_test() -> f64 {
    1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / TESTS)
}

/// Counts in bins, to be compared with what is expected there.
pub(crate) struct Histogram {
    counts: Vec<u64>,
}

impl Histogram {
    pub(crate) fn new(bins: usize) -> Self {
        Self { counts: vec![0; bins] }
    }

    pub(crate) fn add(&mut self, bin: usize) {
        self.counts[bin] += 1;
    }

    pub(crate) fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Panics unless the counts agree with probabilities proportional to `shares`, which sum to 1.
    pub(crate) fn assert_shares(&self, shares: &[f64], what: &str) {
        let total = self.total() as f64;
        let (mut statistic, mut bins) = (0.0, 0u32);
        let (mut pooled_count, mut pooled_expected) = (0.0, 0.0);
        for (count, share) in self.counts.iter().zip(shares) {
            let (count, expected) = (*count as f64, share * total);
            if expected < LEAST_EXPECTED {
                pooled_count += count;
                pooled_expected += expected;
            } else {
                statistic += (count - expected).powi(2) / expected;
                bins += 1;
            }
        }
        if pooled_expected >= LEAST_EXPECTED {
            statistic += (pooled_count - pooled_expected).powi(2) / pooled_expected;
            bins += 1;
        } else {
            // So few are expected that a handful more would be wrong.
            assert!(pooled_count <= pooled_expected + 20.0, "{what}: {pooled_count} samples where none can be");
        }
        assert!(bins > 1, "{what}: too few samples for a test");
        let chance = upper_incomplete_gamma(f64::from(bins - 1) / 2.0, statistic / 2.0);
        assert!(
            chance > level_of_one_test(),
            "{what}: χ² = {statistic:.1} with {} degrees of freedom has p = {chance:.2e}",
            bins - 1
        );
    }
}

/// Tests points of the unit square for uniformity.
pub(crate) fn assert_uniform(points: impl Iterator<Item = [f64; 2]>, what: &str) {
    const SIDE: usize = 16;
    let mut histogram = Histogram::new(SIDE * SIDE);
    let bin = |x: f64| ((x * SIDE as f64) as usize).min(SIDE - 1);
    points.for_each(|[x, y]| histogram.add(bin(x) * SIDE + bin(y)));
    histogram.assert_shares(&[1.0 / (SIDE * SIDE) as f64; SIDE * SIDE], what);
}

/// The angle of (x, y) as a share of a turn.
pub(crate) fn turn(x: f32, y: f32) -> f64 {
    (f64::from(y).atan2(f64::from(x)) / TAU).rem_euclid(1.0)
}

/// Tests local unit directions (`None` where sampling failed) against `pdf` by solid angle. The bins cover the cone round
/// +z whose cosine is `least_cosine`; whatever is outside of it, and failures, are one more bin.
pub(crate) fn assert_directions(
    samples: impl Iterator<Item = Option<Vec3>>,
    pdf: impl Fn(Vec3) -> f64,
    least_cosine: f64,
    what: &str,
) {
    const RINGS: usize = 12;
    const SECTORS: usize = 24;
    const FINE: usize = 24;
    let mut histogram = Histogram::new(RINGS * SECTORS + 1);
    let height = 1.0 - least_cosine;
    for sample in samples {
        let bin = sample.filter(|direction| f64::from(direction.z) >= least_cosine).map(|direction| {
            let ring = ((1.0 - f64::from(direction.z)) / height * RINGS as f64) as usize;
            let sector = (turn(direction.x, direction.y) * SECTORS as f64) as usize;
            ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)
        });
        histogram.add(bin.unwrap_or(RINGS * SECTORS));
    }
    let mut shares = vec![0.0; RINGS * SECTORS + 1];
    let part = TAU * height / (RINGS * SECTORS * FINE * FINE) as f64;
    for i in 0..RINGS * FINE {
        for j in 0..SECTORS * FINE {
            let z = 1.0 - height * (i as f64 + 0.5) / (RINGS * FINE) as f64;
            let angle = TAU * (j as f64 + 0.5) / (SECTORS * FINE) as f64;
            let sine = (1.0 - z * z).max(0.0).sqrt();
            let direction = Vec3::new((sine * angle.cos()) as f32, (sine * angle.sin()) as f32, z as f32);
            shares[i / FINE * SECTORS + j / FINE] += part * pdf(direction);
        }
    }
    let inside: f64 = shares.iter().sum();
    assert!(inside < 1.01, "{what}: the density integrates to {inside}");
    shares[RINGS * SECTORS] = (1.0 - inside).max(0.0);
    histogram.assert_shares(&shares, what);
}

/// Q(a, x) = Γ(a, x)/Γ(a), by series or continued fraction [Press et al. 2007, "Numerical recipes", 6.2].
fn upper_incomplete_gamma(a: f64, x: f64) -> f64 {
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..10_000 {
            term *= x / (a + f64::from(n));
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let mut c = f64::MAX;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for n in 1..10_000 {
        let factor = -f64::from(n) * (f64::from(n) - a);
        b += 2.0;
        d = 1.0 / (factor * d + b);
        c = b + factor / c;
        fraction *= d * c;
    }
    front * fraction
}
