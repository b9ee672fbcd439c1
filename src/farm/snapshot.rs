//! A job's merged state as bytes: what was merged so far need not be traced again, and what comes later has the same bits as if nothing had
//! happened.
//!
//! ```text
//! "photonfarm snapshot 1\n"   length of the header (u64)   header (JSON)   block   block   …
//! ```
//!
//! A block is a length (u64) and byte planes as on the wire. All numbers are little-endian. Blocks: pixels, sums of either twin, then one per
//! radius field.

use bytemuck::Pod;
use serde::{Deserialize, Serialize};

use super::rules::plan::Plan;
use super::rules::terms::MeasuredError;
use super::wire::planes;
use crate::estimate::merging::RegionProgress;
use crate::estimate::{Estimate, PixelEstimate, PixelSums, RadiusField, RadiusRule};

/// How every snapshot of this version begins.
const MAGIC: &[u8] = b"photonfarm snapshot 1\n";

/// Which radius field it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldKey {
    /// The epoch for which it was taken.
    pub epoch: u32,
    /// Index of its region.
    pub region: u32,
}

/// A radius field that is still needed.
#[derive(Clone, Debug, PartialEq)]
pub struct SnapshotField {
    /// Which one.
    pub key: FieldKey,
    /// Its radii.
    pub field: RadiusField,
}

/// A job's merged state.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// The job's cut.
    pub plan: Plan,
    /// What is merged.
    pub estimate: Estimate,
    /// Shards merged.
    pub merged: u64,
    /// Shards merged when the error is looked at next.
    pub next_look: u64,
    /// The last estimate of the error.
    pub error: Option<MeasuredError>,
    /// Radius fields that later shards need.
    pub fields: Vec<SnapshotField>,
}

/// A snapshot that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the snapshot cannot be read: {0}")]
pub struct BadSnapshot(String);

/// All of a snapshot that is not a large array.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    plan: Plan,
    progress: Vec<RegionProgress>,
    non_finite: u64,
    radius_rule: RadiusRule,
    alpha: f64,
    merged: u64,
    next_look: u64,
    error: Option<MeasuredError>,
    fields: Vec<FieldHeader>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldHeader {
    key: FieldKey,
    base_pass: u32,
    typical_radius_squared: f32,
    pixels: usize,
}

impl Snapshot {
    /// To bytes.
    pub fn encode(&self) -> Vec<u8> {
        let Self { plan, estimate, merged, next_look, error, fields } = self;
        let field = |field: &SnapshotField| FieldHeader {
            key: field.key,
            base_pass: field.field.base_pass,
            typical_radius_squared: field.field.typical_radius_squared,
            pixels: field.field.radius_squared.len(),
        };
        let header = Header {
            plan: plan.clone(),
            progress: estimate.progress.clone(),
            non_finite: estimate.non_finite,
            radius_rule: estimate.radius_rule(),
            alpha: estimate.alpha(),
            merged: *merged,
            next_look: *next_look,
            error: *error,
            fields: fields.iter().map(field).collect(),
        };
        // Plain data with string keys always has a JSON form.
        let header = serde_json::to_vec(&header).unwrap_or_default();
        let mut bytes = MAGIC.to_vec();
        append(&mut bytes, &header);
        append(&mut bytes, &planes::compress::<4>(bytemuck::cast_slice(&estimate.pixels)));
        for twin in &estimate.twins {
            append(&mut bytes, &planes::compress::<14>(bytemuck::cast_slice(twin)));
        }
        for SnapshotField { field, .. } in fields {
            append(&mut bytes, &planes::compress::<1>(bytemuck::cast_slice(&field.radius_squared)));
        }
        bytes
    }

    /// From bytes.
    ///
    /// # Errors
    /// Bytes of another version, or that do not fit each other.
    pub fn decode(bytes: &[u8]) -> Result<Self, BadSnapshot> {
        let mut rest = bytes.strip_prefix(MAGIC).ok_or_else(|| BadSnapshot("it is of another version".to_owned()))?;
        let header: Header =
            serde_json::from_slice(take(&mut rest)?).map_err(|problem| BadSnapshot(problem.to_string()))?;
        let Header { plan, progress, non_finite, radius_rule, alpha, merged, next_look, error, fields } = header;
        let (width, height) = (plan.width, plan.height);
        let count = width as usize * height as usize;
        let regions: Vec<_> = progress.iter().map(|progress| progress.region).collect();
        if regions != plan.regions {
            return Err(BadSnapshot("its regions are not those of its plan".to_owned()));
        }
        let pixels: Vec<PixelEstimate> = records::<4, _>(take(&mut rest)?, count)?;
        let mut twin = || records::<14, PixelSums>(take(&mut rest)?, count);
        let twins = [twin()?, twin()?];
        let field = |header: FieldHeader| {
            let radii: Vec<[f32; 1]> = decompress(take(&mut rest)?, header.pixels.min(count))?;
            let FieldHeader { key, base_pass, typical_radius_squared, .. } = header;
            let field = RadiusField { radius_squared: bytemuck::cast_vec(radii), base_pass, typical_radius_squared };
            Ok(SnapshotField { key, field })
        };
        let fields: Result<Vec<SnapshotField>, BadSnapshot> = fields.into_iter().map(field).collect();
        let first: Vec<f32> = vec![1.0; count];
        let mut estimate = Estimate::new(width, height, &plan.regions, &first, radius_rule, alpha);
        (estimate.pixels, estimate.twins, estimate.progress, estimate.non_finite) =
            (pixels, twins, progress, non_finite);
        Ok(Self { plan, estimate, merged, next_look, error, fields: fields? })
    }
}

fn append(bytes: &mut Vec<u8>, block: &[u8]) {
    bytes.extend_from_slice(&(block.len() as u64).to_le_bytes());
    bytes.extend_from_slice(block);
}

/// Takes the next block off the front of `rest`.
fn take<'a>(rest: &mut &'a [u8]) -> Result<&'a [u8], BadSnapshot> {
    let cut_off = || BadSnapshot("it is cut off".to_owned());
    let (length, after) = rest.split_first_chunk::<8>().ok_or_else(cut_off)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| cut_off())?;
    let (block, after) = after.split_at_checked(length).ok_or_else(cut_off)?;
    *rest = after;
    Ok(block)
}

fn decompress<const WORDS: usize>(block: &[u8], count: usize) -> Result<Vec<[f32; WORDS]>, BadSnapshot> {
    planes::decompress::<WORDS>(block, count).map_err(|problem| BadSnapshot(problem.to_string()))
}

/// Words as records of doubles. They are copied, since doubles want another alignment.
fn records<const WORDS: usize, T: Pod>(block: &[u8], count: usize) -> Result<Vec<T>, BadSnapshot> {
    let words = decompress::<WORDS>(block, count)?;
    let mut records = vec![T::zeroed(); count];
    bytemuck::cast_slice_mut::<T, u8>(&mut records).copy_from_slice(bytemuck::cast_slice(words.as_flattened()));
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_snapshot_keeps_every_bit() {
        let plan = Plan::new(70, 50, 100_000, Some(75), RadiusRule::Statistics);
        let count = 70 * 50;
        let first: Vec<f32> = (1..=count).map(|index| 1.0 / index as f32).collect();
        let mut estimate = Estimate::new(70, 50, &plan.regions, &first, RadiusRule::Statistics, 2.0 / 3.0);
        for (index, sums) in estimate.twins[1].iter_mut().enumerate() {
            sums.radiance = [1.0 / (index + 1) as f64, -0.0, f64::from_bits(0x7ff8_dead_beef_0001)];
        }
        estimate.non_finite = 3;
        let field = estimate.radius_field(plan.regions[0]);
        let fields = vec![SnapshotField { key: FieldKey { epoch: 2, region: 0 }, field }];
        let snapshot = Snapshot { plan, estimate, merged: 17, next_look: 20, error: None, fields };
        let bytes = snapshot.encode();
        let read = Snapshot::decode(&bytes).expect("just encoded");
        assert_eq!(read.encode(), bytes);
        assert_eq!((read.merged, read.fields == snapshot.fields), (17, true));
        for length in (0..bytes.len()).step_by(97) {
            assert!(Snapshot::decode(&bytes[..length]).is_err(), "{length} bytes");
        }
    }
}
