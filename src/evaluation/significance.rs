//! Whether two groups of numbers differ by more than chance.

/// Probability that Student's t with `freedom` degrees of freedom is farther from 0 than `t`:
/// the regularised incomplete beta function `I(ν/(ν + t²); ν/2, ½)` [Abramowitz & Stegun 1964, 26.7.1].
pub(super) fn student_two_sided(t: f64, freedom: f64) -> f64 {
    if t.is_infinite() {
        return 0.0;
    }
    incomplete_beta(freedom / 2.0, 0.5, freedom / (freedom + t * t))
}

/// By the continued fraction [A&S 26.5.8], on the side where it converges fast.
fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let log_factor = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * x.ln() + b * (1.0 - x).ln();
    log_factor.exp() / (a * continued_fraction(a, b, x))
}

/// `1 + d₁/(1 + d₂/(1 + …))`, from the inside out: for the arguments here 200 terms are many times what double precision needs.
fn continued_fraction(a: f64, b: f64, x: f64) -> f64 {
    (1..=200u32).rev().fold(1.0, |inner, index| {
        let m = f64::from(index / 2);
        let d = match index % 2 {
            1 => -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
            _ => m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
        };
        1.0 + d / inner
    })
}

/// Which of several tests still count when all of them together may go wrong with probability `level` [Holm 1979].
pub(super) fn holm(probabilities: &[f64], level: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]));
    let mut counts = vec![false; probabilities.len()];
    for (rank, index) in order.iter().enumerate() {
        if probabilities[*index] > level / (probabilities.len() - rank) as f64 {
            break;
        }
        counts[*index] = true;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::{holm, student_two_sided};

    #[test]
    fn tails_are_those_of_the_tables() {
        // Two-sided 5 % and 1 % points of the usual tables.
        for (t, freedom, expected) in
            [(12.706, 1.0, 0.05), (2.776, 4.0, 0.05), (4.604, 4.0, 0.01), (2.086, 20.0, 0.05), (2.576, 1e6, 0.01)]
        {
            let found = student_two_sided(t, freedom);
            assert!((found - expected).abs() < 1e-3 * expected.sqrt(), "t = {t}, ν = {freedom}: {found}");
        }
        assert_eq!(student_two_sided(0.0, 7.0), 1.0);
        assert_eq!(student_two_sided(f64::INFINITY, 7.0), 0.0);
    }

    #[test]
    fn holm_counts_small_ones_among_many() {
        assert_eq!(holm(&[0.004, 0.5, 0.02], 0.05), [true, false, true]);
        assert_eq!(holm(&[0.03, 0.5, 0.02], 0.05), [false, false, false]);
    }
}
