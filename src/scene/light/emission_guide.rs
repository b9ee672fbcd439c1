//! Where photons are worth emitting: a density over all places and directions of all lights.
//!
//! What a light emits is a function of four numbers in [0, 1), two for the place and two for the direction, whatever kind of light it
//! is. A guide cuts that cube of every light into cells by halving it again and again, and says how often photons start in each cell.
//! Weights are exact whatever the guide says: cells are picked by whole 2⁻²⁴ths, as fine as random numbers are.
//!
//! \[PP98\] Peter & Pietrek 1998, "Importance driven construction of photon maps"; \[KW00\] Keller & Wald 2000, "Efficient
//! importance sampling techniques for the photon map", which keep an importance map on surfaces instead.

use super::LightTable;
use crate::math::discrete::ONE_MINUS_EPSILON;

/// The share of photons that is emitted by power, so that no light is lost: no photon weighs more than its inverse times as much as it would
/// without a guide.
pub const BY_POWER: f64 = 0.125;
/// The most halvings of a cube in one dimension.
pub const MOST_HALVINGS: u32 = 16;
/// The most cells of all lights.
const MOST_CELLS: usize = 1 << 20;
/// The most numbers of a guide.
pub const MOST_VALUES: usize = 2 * MOST_CELLS;
/// The dimensions of a light's cube.
pub const DIMENSIONS: usize = 4;
/// Random numbers are multiples of its inverse.
const PICKS: u32 = 1 << 24;

/// What photons of a light do with the four numbers of their emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionPoint {
    /// Index of the light.
    pub light: u32,
    /// Place (2) and direction (2), in [0, 1).
    pub numbers: [f32; DIMENSIONS],
    /// The density here over that of emission by power; 1 without a guide.
    pub density: f32,
}

/// One node of the trees of a guide as it is kept and sent: trees of all lights one after the other, each from its root, first halves first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuideNode {
    /// Halved across a dimension, 0 to 3.
    Halved(u8),
    /// A cell, and how often photons should start in it: any scale, at least 0.
    Cell(f32),
}

impl From<GuideNode> for f32 {
    fn from(node: GuideNode) -> Self {
        match node {
            GuideNode::Halved(dimension) => -1.0 - Self::from(dimension),
            GuideNode::Cell(weight) => weight,
        }
    }
}

impl GuideNode {
    fn read(value: f32) -> Result<Self, GuideError> {
        if value >= 0.0 && value.is_finite() {
            return Ok(Self::Cell(value));
        }
        match (0..DIMENSIONS as u8).find(|dimension| f32::from(Self::Halved(*dimension)) == value) {
            Some(dimension) => Ok(Self::Halved(dimension)),
            None => Err(GuideError::Node(value)),
        }
    }
}

/// Numbers that are no guide for the lights of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GuideError {
    /// A number that stands for nothing.
    #[error("the emission guide holds {0}, which is neither a cell nor a halving")]
    Node(f32),
    /// Too many or too few numbers.
    #[error("the emission guide does not hold one tree per light")]
    Trees,
    /// Too many cells, or too small ones.
    #[error("the emission guide has too many or too small cells")]
    TooFine,
    /// No cell has any weight.
    #[error("the emission guide leads nowhere")]
    Nowhere,
}

/// A cell of a light's cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuideCell {
    /// Index of the light.
    pub light: u32,
    /// Its lowest corner.
    pub low: [f32; DIMENSIONS],
    /// Its sides, powers of two.
    pub side: [f32; DIMENSIONS],
}

impl GuideCell {
    /// The whole cube of a light.
    pub fn whole(light: u32) -> Self {
        Self { light, low: [0.0; DIMENSIONS], side: [1.0; DIMENSIONS] }
    }

    /// Its share of the cube.
    pub fn volume(&self) -> f32 {
        self.side.iter().product()
    }

    /// Both halves across a dimension; `None` when it cannot be halved any more.
    pub fn halves(&self, dimension: usize) -> Option<[Self; 2]> {
        let half = 0.5 * self.side[dimension];
        if half * ((1 << MOST_HALVINGS) as f32) < 1.0 {
            return None;
        }
        let mut halves = [*self; 2];
        halves.iter_mut().for_each(|cell| cell.side[dimension] = half);
        halves[1].low[dimension] += half;
        Some(halves)
    }

    /// Whether a number lies in the first half across a dimension.
    #[inline]
    pub fn is_first_half(&self, dimension: usize, number: f32) -> bool {
        number < self.low[dimension] + 0.5 * self.side[dimension]
    }

    /// The point of the cell that four numbers in [0, 1) stand for.
    #[inline]
    fn point(&self, numbers: [f32; DIMENSIONS]) -> [f32; DIMENSIONS] {
        [0, 1, 2, 3].map(|axis| (self.low[axis] + self.side[axis] * numbers[axis]).min(ONE_MINUS_EPSILON))
    }
}

/// A density over the emission of all lights.
#[derive(Clone, Debug)]
pub struct EmissionGuide {
    cells: Vec<GuideCell>,
    /// The first 2⁻²⁴th past each cell.
    ends: Vec<u32>,
    /// Density in each cell over that of emission by power.
    densities: Vec<f32>,
}

impl EmissionGuide {
    /// A guide for `lights` from its nodes as numbers.
    ///
    /// # Errors
    /// Numbers that are not one tree per light.
    pub fn new(values: &[f32], lights: &LightTable) -> Result<Self, GuideError> {
        let count = lights.lights().len();
        let (mut cells, mut weights) = (Vec::new(), Vec::new());
        let mut values = values.iter();
        for light in 0..count as u32 {
            let mut waiting = vec![GuideCell::whole(light)];
            while let Some(cell) = waiting.pop() {
                match GuideNode::read(*values.next().ok_or(GuideError::Trees)?)? {
                    GuideNode::Halved(dimension) => {
                        let [first, second] = cell.halves(dimension.into()).ok_or(GuideError::TooFine)?;
                        waiting.extend([second, first]);
                    }
                    GuideNode::Cell(weight) => {
                        cells.push(cell);
                        weights.push(f64::from(weight));
                    }
                }
                if cells.len() + waiting.len() > MOST_CELLS {
                    return Err(GuideError::TooFine);
                }
            }
        }
        if values.next().is_some() {
            return Err(GuideError::Trees);
        }
        Self::of_cells(cells, &weights, lights)
    }

    fn of_cells(cells: Vec<GuideCell>, weights: &[f64], lights: &LightTable) -> Result<Self, GuideError> {
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(GuideError::Nowhere);
        }
        // Lights of another group leave their share to the others.
        let is_lit = |cell: &GuideCell| !lights.lights()[cell.light as usize].is_dark();
        let lit: f64 = cells.iter().zip(weights).filter(|(cell, _)| is_lit(cell)).map(|(_, weight)| weight).sum();
        let by_weight = |weight: f64| if lit > 0.0 { (1.0 - BY_POWER) * weight / lit } else { 0.0 };
        let by_power = |cell: &GuideCell| f64::from(lights.emission_pick(cell.light)) * f64::from(cell.volume());
        let shares: Vec<f64> = cells
            .iter()
            .zip(weights)
            .map(|(cell, weight)| match by_power(cell) {
                // Such a light emits nothing, whatever its weight.
                0.0 => 0.0,
                by_power => BY_POWER * by_power + by_weight(*weight),
            })
            .collect();
        let ends = whole_picks(&shares);
        let begins = std::iter::once(0).chain(ends.iter().copied());
        let densities = cells
            .iter()
            .zip(begins.zip(&ends))
            .map(|(cell, (begin, end))| (f64::from(end - begin) / f64::from(PICKS) / by_power(cell)) as f32)
            .collect();
        Ok(Self { cells, ends, densities })
    }

    /// The cells.
    pub fn cells(&self) -> &[GuideCell] {
        &self.cells
    }

    /// Whether each light is one cell: then it says no more than how often photons come from each.
    pub fn picks_lights_alone(&self) -> bool {
        self.cells.iter().all(|cell| *cell == GuideCell::whole(cell.light))
    }

    /// The probability of each cell.
    pub fn probabilities(&self) -> impl Iterator<Item = f64> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, end)| f64::from(end - begin) / f64::from(PICKS))
    }

    /// The point that five numbers in [0, 1) stand for, of which `pick` picks the cell.
    // A call of its own: emission by power, which nearly all scenes have, carries none of it.
    #[inline(never)]
    pub fn point(&self, numbers: [f32; DIMENSIONS], pick: f32) -> EmissionPoint {
        let pick = (pick * PICKS as f32) as u32;
        let index = self.ends.partition_point(|end| *end <= pick).min(self.cells.len() - 1);
        let cell = &self.cells[index];
        EmissionPoint { light: cell.light, numbers: cell.point(numbers), density: self.densities[index] }
    }
}

/// Where each of `shares` ends when 2²⁴ picks are given to them: at least one to each that is not 0, the others in proportion.
fn whole_picks(shares: &[f64]) -> Vec<u32> {
    let total: f64 = shares.iter().sum();
    let possible = shares.iter().filter(|share| **share > 0.0).count() as u32;
    let last_possible = shares.iter().rposition(|share| *share > 0.0).unwrap_or(0);
    let free = f64::from(PICKS - possible);
    let (mut sum, mut given) = (0.0, 0);
    let mut ends: Vec<u32> = shares
        .iter()
        .map(|share| {
            sum += share;
            given += u32::from(*share > 0.0);
            given + (free * (sum / total)) as u32
        })
        .collect();
    ends[last_possible..].fill(PICKS);
    ends
}
