//! Random choice among the parts of a material, and how a camera path splits between gathering and going on.

use super::Lobes;

/// Probabilities of `N` parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LobeChoice<const N: usize> {
    /// Sum to 1, or all 0 when there is nothing to choose.
    pub probabilities: [f32; N],
}

impl<const N: usize> LobeChoice<N> {
    /// A choice with probabilities in proportion to `weights`, each at least 0.
    #[inline]
    pub(crate) fn new(weights: [f32; N]) -> Self {
        let sum: f32 = weights.iter().sum();
        Self { probabilities: if sum > 0.0 { weights.map(|weight| weight / sum) } else { [0.0; N] } }
    }

    /// The part that `u` picks and a fresh number in [0, 1); `None` when there is nothing to choose.
    #[inline]
    pub(crate) fn pick(&self, u: f32) -> Option<(usize, f32)> {
        let last = self.probabilities.iter().rposition(|probability| *probability > 0.0)?;
        let mut start = 0.0;
        for (index, probability) in self.probabilities.iter().enumerate() {
            if *probability > 0.0 && (u < start + probability || index == last) {
                return Some((index, ((u - start) / probability).clamp(0.0, 1.0 - f32::EPSILON)));
            }
            start += probability;
        }
        None
    }
}

/// The probability to go on where about `followed` of the light is in lobes that paths follow and `gathered` in those
/// where they gather: 0 and 1 when there is only one, else between 1/64 and 63/64, so that no path weighs more than
/// 64-fold where the estimate is poor.
#[inline]
pub(crate) fn followed_share(followed: f32, gathered: f32) -> f32 {
    match (followed > 0.0, gathered > 0.0) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        (true, true) => (followed / (followed + gathered)).clamp(1.0 / 64.0, 63.0 / 64.0),
    }
}

/// The same for parts of some kinds that have some shares.
#[inline]
pub(crate) fn followed_share_of<const N: usize>(kinds: [Lobes; N], shares: [f32; N]) -> f32 {
    let sum = |lobes: Lobes| -> f32 { (0..N).filter(|part| kinds[*part].any(lobes)).map(|part| shares[part]).sum() };
    followed_share(sum(Lobes::FOLLOWED), sum(Lobes::WIDE))
}

/// The mean of three channels.
#[inline]
pub(crate) fn mean(rgb: crate::math::Rgb) -> f32 {
    (rgb.x + rgb.y + rgb.z) / 3.0
}
