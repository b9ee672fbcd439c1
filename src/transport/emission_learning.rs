//! Learning where photons should start, from photons and what they are to the pixels that gather them.
//!
//! Let f_j(u) be the part of pixel j's brightness that the photon emitted at u brings, emission by power being uniform over u. With
//! N photons of density q the relative variances of all pixels sum to ∫ Σ_j f_j²/q du / N, which is least for q ∝ √(Σ_j f_j²). A guide is
//! constant in each of its cells, which takes the root of the mean of Σ_j f_j² over the cell. \[GPSK18\] Grittmann et al. 2018,
//! "Efficient caustic rendering with lightweight photon mapping", guide emission by what photons are to the picture, too.

use crate::scene::light::emission_guide::{BY_POWER, DIMENSIONS, EmissionPoint, GuideCell, GuideNode};

/// Photons that a mean over a cell counts beside its own, with the mean around it.
const PRIOR_PHOTONS: f64 = 1.0;
/// Photons, were they all worth the same, that a cell must have to be halved.
const LEAST_PHOTONS: f64 = 16.0;
/// The share of a light's photons that is spread evenly over all that it emits, whatever its cells say: where photons of use were missed
/// by chance, no photon weighs more than eight times as much as most of its light's.
const EVEN: f64 = 0.125;
/// Cells are not halved further when they have less than this share of all photons.
const LEAST_SHARE: f64 = 1.0 / 8192.0;

/// A photon path, and what it was worth.
#[derive(Clone, Copy, Debug)]
pub struct EmittedPath {
    /// Where it started.
    pub start: EmissionPoint,
    /// Σ over pixels of the square of the share of the pixel's brightness that it brought.
    pub worth: f64,
}

/// What was learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct Lesson {
    /// The guide's nodes as numbers, see [`GuideNode`].
    pub values: Vec<f32>,
    /// The mean relative variance of pixels by power over that with the guide, for as many photons.
    pub gain: f64,
    /// How many photons of the same worth would teach as much.
    pub photons: f64,
}

/// How finely photons are guided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideParts {
    /// Places and directions of each light.
    Cells,
    /// Lights as wholes: all that methods need to know which weigh ways of finding a path.
    Lights,
}

/// Learns from the `paths` of a pass, in whatever order, the guide for `light_count` lights; `by_power` is the probability
/// of a light. `None` when no path brought anything.
pub fn learn(
    paths: &[EmittedPath],
    parts: GuideParts,
    light_count: usize,
    by_power: impl Fn(u32) -> f32,
) -> Option<Lesson> {
    let mut paths: Vec<EmittedPath> = paths.to_vec();
    // Stable, so that sums have the order of the paths.
    paths.sort_by_key(|path| path.start.light);
    let mut learner = Learner { count: paths.len() as f64, parts, nodes: Vec::new(), cells: Vec::new() };
    let whole = Moments::of(&paths);
    if !(whole.sum > 0.0 && whole.sum.is_finite()) {
        return None;
    }
    let mean = whole.sum / learner.count;
    let mut rest = paths.as_mut_slice();
    for light in 0..light_count as u32 {
        let (own, others) = rest.split_at_mut(rest.partition_point(|path| path.start.light == light));
        rest = others;
        learner.cell(own, GuideCell::whole(light), f64::from(by_power(light)), mean);
    }
    Some(learner.finish(whole.photons()))
}

/// Sums over paths of their worth for uniform density.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    sum: f64,
    squares: f64,
}

impl Moments {
    fn of(paths: &[EmittedPath]) -> Self {
        let mut moments = Self::default();
        paths.iter().for_each(|path| moments.add(path));
        moments
    }

    fn add(&mut self, path: &EmittedPath) {
        let worth = worth_by_power(path);
        self.sum += worth;
        self.squares += worth * worth;
    }

    /// How many photons of the same worth would say as much.
    fn photons(&self) -> f64 {
        if self.squares > 0.0 { self.sum * self.sum / self.squares } else { 0.0 }
    }
}

/// What a path adds to ∫ Σ_j f_j² du: f_j is what it brought times its density, and it stands for one over its density of u.
fn worth_by_power(path: &EmittedPath) -> f64 {
    path.worth * f64::from(path.start.density)
}

/// A finished cell.
#[derive(Clone, Copy, Debug)]
struct LearntCell {
    /// Index of its node.
    node: usize,
    /// Index of its light.
    light: usize,
    /// Its share of the light's cube.
    volume: f64,
    /// Probability of emission by power.
    by_power: f64,
    /// ∫ Σ_j f_j² du over the cell, as found.
    integral: f64,
    /// Probability of emission that would be best, un-normalised.
    wanted: f64,
}

struct Learner {
    count: f64,
    parts: GuideParts,
    nodes: Vec<GuideNode>,
    cells: Vec<LearntCell>,
}

impl Learner {
    /// Writes the tree of a cell with these paths; `around` is the mean of Σ_j f_j² around it.
    fn cell(&mut self, paths: &mut [EmittedPath], cell: GuideCell, by_power: f64, around: f64) {
        let moments = Moments::of(paths);
        let integral = moments.sum / self.count;
        let mean = match by_power > 0.0 {
            true => {
                let own = paths.len() as f64;
                (own * (integral / by_power) + PRIOR_PHOTONS * around) / (own + PRIOR_PHOTONS)
            }
            false => 0.0,
        };
        if let Some((dimension, halves)) = self.best_halves(paths, &cell, &moments) {
            self.nodes.push(GuideNode::Halved(dimension as u8));
            let first = partition(paths, |path| cell.is_first_half(dimension, path.start.numbers[dimension]));
            let (first, second) = paths.split_at_mut(first);
            let [low, high] = halves;
            self.cell(first, low, 0.5 * by_power, mean);
            self.cell(second, high, 0.5 * by_power, mean);
            return;
        }
        let (node, light, volume) = (self.nodes.len(), cell.light as usize, f64::from(cell.volume()));
        self.cells.push(LearntCell { node, light, volume, by_power, integral, wanted: by_power * mean.sqrt() });
        self.nodes.push(GuideNode::Cell(0.0));
    }

    /// The dimension in which halves differ most, when they do so for more than chance.
    fn best_halves(
        &self,
        paths: &[EmittedPath],
        cell: &GuideCell,
        moments: &Moments,
    ) -> Option<(usize, [GuideCell; 2])> {
        let photons = moments.photons();
        if self.parts == GuideParts::Lights
            || photons < LEAST_PHOTONS
            || (paths.len() as f64) < LEAST_SHARE * self.count
        {
            return None;
        }
        let mut first = [Moments::default(); DIMENSIONS];
        for path in paths {
            for (dimension, half) in first.iter_mut().enumerate() {
                if cell.is_first_half(dimension, path.start.numbers[dimension]) {
                    half.add(path);
                }
            }
        }
        // Halves that differ by chance save an eighth of one over the photons.
        let mut best = (1.0 / photons, None);
        for (dimension, half) in first.iter().enumerate() {
            let (low, high) = (half.sum, (moments.sum - half.sum).max(0.0));
            let saved = 1.0 - (low.sqrt() + high.sqrt()) / (2.0 * moments.sum).sqrt();
            if let Some(halves) = cell.halves(dimension).filter(|_| saved > best.0) {
                best = (saved, Some((dimension, halves)));
            }
        }
        best.1
    }

    fn finish(mut self, photons: f64) -> Lesson {
        let wanted: f64 = self.cells.iter().map(|cell| cell.wanted).sum();
        let mut of_light = vec![0.0; self.cells.last().map_or(0, |cell| cell.light + 1)];
        self.cells.iter().for_each(|cell| of_light[cell.light] += cell.wanted);
        let (mut unguided, mut guided) = (0.0, 0.0);
        for cell in &self.cells {
            let weight = ((1.0 - EVEN) * cell.wanted + EVEN * cell.volume * of_light[cell.light]) / wanted;
            self.nodes[cell.node] = GuideNode::Cell(weight as f32);
            unguided += cell.integral;
            if cell.integral > 0.0 {
                guided += cell.integral * cell.by_power / (BY_POWER * cell.by_power + (1.0 - BY_POWER) * weight);
            }
        }
        Lesson { values: self.nodes.into_iter().map(f32::from).collect(), gain: unguided / guided, photons }
    }
}

/// Moves those paths to the front that belong there and keeps the order of both kinds; how many belong there.
fn partition(paths: &mut [EmittedPath], is_first: impl Fn(&EmittedPath) -> bool) -> usize {
    let (mut first, second): (Vec<EmittedPath>, Vec<EmittedPath>) = paths.iter().partition(|path| is_first(path));
    let count = first.len();
    first.extend(second);
    paths.copy_from_slice(&first);
    count
}
