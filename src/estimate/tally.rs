//! What a shard returns: the planes and scalars that its method declares, as sums and counts.

use std::sync::Arc;

use super::declaration::{ACCEPTED, Declaration, PHOTONS_EMITTED, PROPOSED, PlaneDeclaration, PlaneRule, ScalarRule};
use super::shard::Shard;
use super::shard_sums::{PixelTally, ShardSums, set_plane};

/// Proposals of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProposalCount {
    /// All of them.
    pub proposed: u64,
    /// Those that became the chain's next state.
    pub accepted: u64,
}

/// What a shard returns.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// What was traced.
    pub shard: Shard,
    /// Picture width in pixels.
    pub width: u32,
    /// What planes and scalars there are.
    pub declaration: Arc<Declaration>,
    /// As declared; each holds its channels one after the other, each channel the region's pixels in row order.
    pub planes: Vec<Vec<f32>>,
    /// As declared.
    pub scalars: Vec<f64>,
}

impl Tally {
    /// Bytes of memory that its numbers take.
    pub fn bytes(&self) -> u64 {
        let planes: usize = self.planes.iter().map(|plane| size_of_val(plane.as_slice())).sum();
        (planes + size_of_val(self.scalars.as_slice())) as u64
    }
}

/// A tally that does not fit its shard or its declaration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TallyError {
    /// The size of a plane is wrong.
    #[error("tally has {found} values where its shard has {expected}")]
    WrongSize {
        /// Values the shard has.
        expected: usize,
        /// Values that came.
        found: usize,
    },
    /// Planes or scalars are missing or left over.
    #[error("tally does not have the planes and scalars that its method declares")]
    NotAsDeclared,
    /// A value is infinite, not a number or, for a count, negative.
    #[error("tally holds an impossible value ({value}) in {plane} of pixel {pixel}")]
    ImpossibleValue {
        /// The plane.
        plane: String,
        /// Index in the region.
        pixel: usize,
        /// The value as text.
        value: String,
    },
    /// A scalar is not finite or, for a count, not a whole number.
    #[error("tally holds an impossible number of {scalar} ({value})")]
    ImpossibleScalar {
        /// The scalar.
        scalar: String,
        /// The value as text.
        value: String,
    },
    /// Flux was gathered although no photon was emitted.
    #[error("tally holds flux but says that no photon was emitted")]
    NothingEmitted,
}

/// Counts are whole numbers below this, where double precision still holds each of them.
const COUNT_LIMIT: f64 = (1u64 << 53) as f64;

impl Tally {
    /// A tally of zeros for `shard` in a picture `width` pixels wide.
    pub fn zero(shard: Shard, width: u32, declaration: &Arc<Declaration>) -> Self {
        let pixels = shard.region.pixel_count(width);
        let planes = declaration.planes.iter().map(|plane| vec![0.0; plane.channels * pixels]).collect();
        let scalars = vec![0.0; declaration.scalars.len()];
        Self { shard, width, declaration: declaration.clone(), planes, scalars }
    }

    /// The declared planes of what pixels added up; planes that there are no sums for are 0.
    pub fn from_sums(shard: Shard, width: u32, declaration: &Arc<Declaration>, sums: &ShardSums) -> Self {
        let pixels = sums.tallies.len();
        let plane = |declared| sums.plane(declared).unwrap_or_else(|| vec![0.0; declared.channels * pixels]);
        let planes = declaration.planes.iter().map(plane).collect();
        let scalars = vec![0.0; declaration.scalars.len()];
        Self { shard, width, declaration: declaration.clone(), planes, scalars }
    }

    /// What every method's pixels added up; what is not declared is 0.
    pub fn pixels(&self) -> Vec<PixelTally> {
        let mut pixels = vec![PixelTally::default(); self.shard.region.pixel_count(self.width)];
        for (declared, plane) in self.declaration.planes.iter().zip(&self.planes) {
            set_plane(&mut pixels, declared, plane);
        }
        pixels
    }

    /// A plane by name.
    pub fn plane_mut(&mut self, name: &str) -> Option<&mut Vec<f32>> {
        self.declaration.plane(name).map(|index| &mut self.planes[index])
    }

    /// A scalar by name; 0 when it is not declared.
    pub fn scalar(&self, name: &str) -> f64 {
        self.declaration.scalar(name).and_then(|index| self.scalars.get(index)).copied().unwrap_or(0.0)
    }

    /// Sets the scalars that count proposals of a kind to chains. Nothing happens when the kind is not declared.
    pub fn set_proposals(&mut self, kind: &str, count: ProposalCount) {
        self.set_scalar(&format!("{kind}{PROPOSED}"), count.proposed as f64);
        self.set_scalar(&format!("{kind}{ACCEPTED}"), count.accepted as f64);
    }

    /// Sets a scalar. Nothing happens when it is not declared.
    pub fn set_scalar(&mut self, name: &str, value: f64) {
        if let Some(index) = self.declaration.scalar(name) {
            self.scalars[index] = value;
        }
    }

    /// Checks that every value is possible: right size, finite, counts not negative.
    pub fn check(&self) -> Result<(), TallyError> {
        let declared = &self.declaration;
        if (self.planes.len(), self.scalars.len()) != (declared.planes.len(), declared.scalars.len()) {
            return Err(TallyError::NotAsDeclared);
        }
        let pixels = self.shard.region.pixel_count(self.width);
        for (declared, plane) in declared.planes.iter().zip(&self.planes) {
            if plane.len() != declared.channels * pixels {
                return Err(TallyError::WrongSize { expected: declared.channels * pixels, found: plane.len() });
            }
        }
        self.check_scalars()?;
        let gathered = declared.planes.iter().zip(&self.planes).filter(|(plane, _)| plane.needs_radius());
        if self.scalar(PHOTONS_EMITTED) == 0.0 && !gathered.clone().all(|(_, plane)| is_dark(plane)) {
            return Err(TallyError::NothingEmitted);
        }
        declared.planes.iter().zip(&self.planes).try_for_each(|(declared, plane)| check_values(declared, plane, pixels))
    }

    fn check_scalars(&self) -> Result<(), TallyError> {
        for (declared, value) in self.declaration.scalars.iter().zip(&self.scalars) {
            let is_possible = match declared.rule {
                ScalarRule::Sum => value.is_finite(),
                ScalarRule::Count => (0.0..COUNT_LIMIT).contains(value) && value.fract() == 0.0,
            };
            if !is_possible {
                let (scalar, value) = (declared.name.clone(), value.to_string());
                return Err(TallyError::ImpossibleScalar { scalar, value });
            }
        }
        Ok(())
    }
}

fn is_dark(plane: &[f32]) -> bool {
    plane.iter().all(|value| *value == 0.0)
}

/// Checks on bits first, so that it runs as fast as memory is read.
fn check_values(declared: &PlaneDeclaration, plane: &[f32], pixels: usize) -> Result<(), TallyError> {
    const SIGN: u32 = 1 << 31;
    const INFINITY: u32 = 0x7f80_0000;
    let is_count = declared.rule == PlaneRule::Count;
    let bits: &[u32] = bytemuck::cast_slice(plane);
    let largest = bits.iter().fold(0, |largest, bits| largest.max(bits & !SIGN));
    let negative = is_count && bits.iter().fold(0, |signs, bits| signs | bits) & SIGN != 0;
    if largest < INFINITY && !negative {
        return Ok(());
    }
    let is_impossible = |value: &f32| !value.is_finite() || (is_count && *value < 0.0);
    match plane.iter().position(is_impossible) {
        None => Ok(()),
        Some(place) => Err(TallyError::ImpossibleValue {
            plane: declared.name.clone(),
            pixel: place % pixels,
            value: plane[place].to_string(),
        }),
    }
}
