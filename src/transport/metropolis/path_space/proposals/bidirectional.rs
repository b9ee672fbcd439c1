//! Bidirectional changes: a part of the path goes, and subpaths from both ends of the gap are joined [Veach 1997, 11.4.2].

use super::{Gap, Kept, Known};
use crate::transport::metropolis::mutation::Source;
use crate::transport::metropolis::path_space::PathSpace;

/// The largest difference between the numbers of segments that go and come.
const LARGEST_CHANGE: usize = 8;

/// How probable it is that so many segments go, but for a factor: mostly two, so that one vertex is new.
fn removal(segments: usize) -> f64 {
    match segments {
        1 => 0.25,
        2 => 0.5,
        more => 0.5f64.powi(more.min(60) as i32),
    }
}

/// How probable it is that the path gets longer or shorter by so many segments, but for a factor.
fn change(difference: usize) -> f64 {
    match difference {
        0 => 0.5,
        1 => 0.15,
        more => 0.2 * 0.5f64.powi(more as i32),
    }
}

/// Picks among `count` weights with `u` in [0, 1).
fn pick(weights: impl Iterator<Item = f64> + Clone, u: f32) -> usize {
    let mut rest = f64::from(u) * weights.clone().sum::<f64>();
    let mut last = 0;
    for (index, weight) in weights.enumerate() {
        last = index;
        rest -= weight;
        if rest < 0.0 {
            break;
        }
    }
    last
}

/// Where so many segments of a path can go: the camera side keeps at least x_k, and never x₀.
fn places(segments: usize, removed: usize) -> usize {
    (segments + 2 - removed).min(segments)
}

impl PathSpace<'_> {
    /// What goes of a path with so many segments, and what comes. The lens is always kept, or moves as a whole.
    pub(super) fn gap(&self, segments: usize, source: &mut Source) -> Option<Gap> {
        let removed = 1 + pick((1..=segments + 1).map(removal), source.number());
        let places = places(segments, removed);
        let camera = 1 + ((source.number() * places as f32) as usize).min(places - 1);
        let light = segments + 2 - removed - camera;
        let (fewest, most) = self.added(segments, removed)?;
        let added = fewest + pick((fewest..=most).map(|added| change(added.abs_diff(removed))), source.number());
        let new = added - 1;
        let of_light = ((source.number() * (new + 1) as f32) as usize).min(new);
        Some(Gap { kept: Kept { light, camera }, light: of_light, camera: new - of_light })
    }

    /// As few and as many segments may come where so many go.
    fn added(&self, segments: usize, removed: usize) -> Option<(usize, usize)> {
        let kept = segments - removed.min(segments);
        // Where all goes, one segment more goes than there are: the one that would lead on from the light.
        let beyond = removed.saturating_sub(segments);
        let fewest = (self.lengths.shortest as usize + beyond).saturating_sub(kept);
        let fewest = fewest.max(removed.saturating_sub(LARGEST_CHANGE)).max(1);
        let most = removed + LARGEST_CHANGE;
        let most = self.lengths.longest.map_or(most, |longest| most.min(longest as usize + beyond - kept));
        (fewest <= most).then_some((fewest, most))
    }

    /// The density with which such a change makes `to` of `from`.
    pub(super) fn gap_density(&self, kept: Kept, from: Known<'_>, to: Known<'_>) -> f64 {
        let (before, after) = (from.path.segments(), to.path.segments());
        let removed = before + 2 - kept.light - kept.camera;
        let added = after + 2 - kept.light - kept.camera;
        let Some((fewest, most)) = self.added(before, removed) else { return 0.0 };
        if !(fewest..=most).contains(&added) {
            return 0.0;
        }
        let all_removals: f64 = (1..=before + 1).map(removal).sum();
        let all_changes: f64 = (fewest..=most).map(|added| change(added.abs_diff(removed))).sum();
        let lengths = removal(removed) / all_removals * change(added.abs_diff(removed)) / all_changes;
        lengths / places(before, removed) as f64 * self.two_subpaths(to.path, to.terms, kept)
    }
}
