//! The hierarchical hat basis of a scanline [Wald 1999, section 4.5; Keller 1999; Heinrich 1998].
//!
//! The base is the polygon through every 2ᴸ-th pixel and the last one. Level l = 1 … L halves its intervals: each new pixel, a node, adds its
//! *detail*, by which it differs from the line between its two neighbors on coarser levels, its parents. With all levels every pixel is a
//! node of one of them:
//!
//! ```text
//! f(x) = I(x) + d(x)      I(x) = (1 − w)·f(left parent) + w·f(right parent)      base: f(x) = d(x)
//! ```
//!
//! d is the mean of n_l samples, d_j(x) = f_j(x) − I_j(x), for which the node and its parents look at the same map j: low-frequency noise
//! of the map is about the same in all three. n_l falls from level to level, so the parents have a sample in every map that a node
//! looks at. Whatever n_l are, the sum has the right mean.

use crate::math::Rgb;

/// Levels of scanlines, and how often the pixels of each are sampled.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    /// Pixels of a scanline.
    width: u32,
    /// n_l from the base to the finest level; no level has more than the one before.
    samples: Vec<u32>,
}

/// Between which pixels a node interpolates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parents {
    left: u32,
    right: u32,
    /// w, in (0, 1): a half, or more in the last interval, which may be shorter.
    right_weight: f32,
}

/// A pixel while a pass is traced.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// f_j of the map j that was looked at last, W·sr⁻¹·m⁻²; after the last one f.
    pub(super) seen: Rgb,
    /// Σ f_j.
    pub(super) sum: Rgb,
    /// Σ d_j.
    pub(super) detail: Rgb,
    /// The mean of its own samples stands for f, those of all maps.
    pub(super) is_localized: bool,
}

impl Hierarchy {
    /// `levels` levels under the base, whose pixels have `coarsest` samples, down to `finest` (at most `coarsest`) by equal ratios.
    pub(super) fn new(width: u32, levels: u32, coarsest: u32, finest: u32) -> Self {
        let ratio = f64::from(finest) / f64::from(coarsest);
        let share = |level: u32| f64::from(level) / f64::from(levels.max(1));
        let samples = |level| (f64::from(coarsest) * libm::pow(ratio, share(level))).round() as u32;
        Self { width, samples: (0..=levels).map(samples).collect() }
    }

    /// As many maps as the base has samples.
    pub(super) fn maps(&self) -> u32 {
        self.samples[0]
    }

    /// n_l of the level of pixel `x`.
    pub(super) fn samples(&self, x: u32) -> u32 {
        self.samples[self.level(x)]
    }

    /// Samples that a pixel has on average.
    pub(super) fn mean_samples(&self) -> f64 {
        (0..self.width).map(|x| f64::from(self.samples(x))).sum::<f64>() / f64::from(self.width)
    }

    fn levels(&self) -> u32 {
        self.samples.len() as u32 - 1
    }

    /// The level on which pixel `x` is a node; 0 is the base.
    fn level(&self, x: u32) -> usize {
        let is_last = x + 1 == self.width;
        if is_last { 0 } else { (self.levels() - x.trailing_zeros().min(self.levels())) as usize }
    }

    /// The nodes of a level in ascending order.
    fn nodes(&self, level: usize) -> impl Iterator<Item = u32> {
        let last = self.width - 1;
        let distance = 1 << (self.levels() - level as u32);
        let (first, spacing) = if level == 0 { (0, distance) } else { (distance, 2 * distance) };
        (first..last).step_by(spacing as usize).chain((level == 0).then_some(last))
    }

    /// The parents of pixel `x`; none of the base.
    fn parents(&self, x: u32) -> Option<Parents> {
        let level = self.level(x);
        if level == 0 {
            return None;
        }
        let distance = 1 << (self.levels() - level as u32);
        let (left, right) = (x - distance, (x + distance).min(self.width - 1));
        Some(Parents { left, right, right_weight: distance as f32 / (right - left) as f32 })
    }

    /// I of what parents see: what pixel `x` of `row` is expected to see. Black on the base.
    fn interpolated(&self, row: &[Node], x: u32) -> Rgb {
        self.parents(x).map_or(Rgb::ZERO, |Parents { left, right, right_weight }| {
            row[left as usize].seen * (1.0 - right_weight) + row[right as usize].seen * right_weight
        })
    }

    /// Adds what the pixels of a scanline saw with map `map`.
    pub(super) fn add(&self, row: &mut [Node], map: u32) {
        for x in (0..self.width).filter(|x| self.samples(*x) > map) {
            let seen = row[x as usize].seen;
            let detail = seen - self.interpolated(row, x);
            let node = &mut row[x as usize];
            node.sum += seen;
            node.detail += detail;
        }
    }

    /// Sums up the scanline from the base to the finest level; f is `seen` then.
    pub(super) fn reconstruct(&self, row: &mut [Node]) {
        self.for_each_from_the_base(row, |node, interpolated, samples| {
            node.seen = match node.is_localized {
                true => node.sum / self.maps() as f32,
                false => interpolated + node.detail / samples as f32,
            };
        });
    }

    /// Localizes the nodes of a scanline whose detail is more than `contrast` times what is interpolated, summed over the channels; f is
    /// `seen` then.
    pub(super) fn localize(&self, row: &mut [Node], contrast: f32) {
        self.for_each_from_the_base(row, |node, interpolated, samples| {
            let detail = node.detail / samples as f32;
            node.seen = interpolated + detail;
            let is_base = samples == self.maps();
            node.is_localized = !is_base && detail.abs().element_sum() > contrast * interpolated.abs().element_sum();
        });
    }

    /// Shows every node of a scanline, what is interpolated there, and its number of samples; parents first.
    fn for_each_from_the_base(&self, row: &mut [Node], mut visit: impl FnMut(&mut Node, Rgb, u32)) {
        for (level, samples) in self.samples.iter().enumerate() {
            for x in self.nodes(level) {
                let interpolated = self.interpolated(row, x);
                visit(&mut row[x as usize], interpolated, *samples);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Hierarchy, Node};
    use crate::math::Rgb;

    fn hierarchies() -> impl Iterator<Item = Hierarchy> {
        let widths = [1, 2, 3, 5, 8, 9, 17, 24, 100, 129];
        widths.into_iter().flat_map(|width| [0, 1, 3, 7, 16].map(|levels| Hierarchy::new(width, levels, 38, 1)))
    }

    #[test]
    fn every_pixel_is_a_node_of_one_level_below_its_parents() {
        for hierarchy in hierarchies() {
            let mut nodes = Vec::new();
            for level in 0..hierarchy.samples.len() {
                nodes.extend(hierarchy.nodes(level));
                assert!(hierarchy.nodes(level).all(|x| hierarchy.level(x) == level), "{hierarchy:?}: level {level}");
            }
            nodes.sort_unstable();
            assert_eq!(nodes, Vec::from_iter(0..hierarchy.width), "{hierarchy:?}");
            for x in 0..hierarchy.width {
                let Some(parents) = hierarchy.parents(x) else { continue };
                assert!(parents.left < x && x < parents.right && parents.right < hierarchy.width);
                let coarser = |parent| hierarchy.level(parent) < hierarchy.level(x);
                assert!(coarser(parents.left) && coarser(parents.right), "{hierarchy:?}: {x} between {parents:?}");
            }
        }
    }

    #[test]
    fn samples_fall_by_equal_ratios() {
        let hierarchy = Hierarchy::new(513, 9, 38, 1);
        assert_eq!(hierarchy.samples, [38, 25, 17, 11, 8, 5, 3, 2, 1, 1]);
        assert_eq!(Hierarchy::new(5, 0, 7, 1).samples, [7], "the base alone has no other level to fall to");
        assert_eq!(Hierarchy::new(5, 1, 7, 7).samples, [7, 7]);
    }

    /// A row that sees `functions`, one a map, at every pixel that looks at it.
    fn reconstructed(hierarchy: &Hierarchy, functions: impl Fn(u32, u32) -> f32) -> Vec<f32> {
        let mut row = vec![Node::default(); hierarchy.width as usize];
        for map in 0..hierarchy.maps() {
            for x in (0..hierarchy.width).filter(|x| hierarchy.samples(*x) > map) {
                row[x as usize].seen = Rgb::splat(functions(x, map));
            }
            hierarchy.add(&mut row, map);
        }
        hierarchy.reconstruct(&mut row);
        row.iter().map(|node| node.seen.x).collect()
    }

    /// Lines that differ from map to map: details are nothing, and every pixel has the mean line of all maps.
    #[test]
    fn interpolation_is_exact_for_lines() {
        for hierarchy in hierarchies().filter(|hierarchy| hierarchy.levels() > 0) {
            let line = |x: u32, map: u32| 3.0 + 0.25 * map as f32 + (0.5 - 0.125 * map as f32) * x as f32;
            let mean = |x: u32| (0..38).map(|map| line(x, map)).sum::<f32>() / 38.0;
            for (x, found) in (0..).zip(reconstructed(&hierarchy, line)) {
                let expected = mean(x);
                assert!((found - expected).abs() <= 1e-3 * expected.abs().max(10.0), "{hierarchy:?}: {found} at {x}");
            }
        }
    }

    /// What does not differ from map to map is found whatever it is, piecewise linear or not.
    #[test]
    fn all_levels_together_are_the_function() {
        for hierarchy in hierarchies() {
            let function = |x: u32, _: u32| if x % 7 < 3 { x as f32 } else { 40.0 - 2.0 * x as f32 };
            for (x, found) in (0..).zip(reconstructed(&hierarchy, function)) {
                assert!((found - function(x, 0)).abs() < 1e-3, "{hierarchy:?}: {found} at {x}");
            }
        }
    }

    /// A step is localized at both of its sides, on every level down to them; what is even or rises evenly is not.
    #[test]
    fn steps_are_localized() {
        let hierarchy = Hierarchy::new(65, 6, 4, 1);
        let localized = |function: &dyn Fn(u32) -> f32| -> Vec<u32> {
            let seen = |x| Node { seen: Rgb::splat(function(x)), ..Node::default() };
            let mut row: Vec<Node> = (0..65).map(seen).collect();
            (0..4).for_each(|map| hierarchy.add(&mut row, map));
            hierarchy.localize(&mut row, 0.1);
            (0..65).filter(|x| row[*x as usize].is_localized).collect()
        };
        assert!(localized(&|_| 2.0).is_empty());
        assert!(localized(&|x| 2.0 + x as f32).is_empty());
        assert_eq!(localized(&|x| if x < 21 { 1.0 } else { 3.0 }), [16, 20, 21, 22, 24, 32]);
    }
}
