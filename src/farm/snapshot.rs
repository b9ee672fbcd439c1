//! A job's merged state as bytes: what was merged so far need not be traced again, and what comes later has the same bits as if nothing had
//! happened.
//!
//! ```text
//! "photonfarm snapshot 1\n"   block: header (JSON)   block: estimate   block: radius field   block: radius field   …   block: emission guide   block: visibility of lights
//! ```
//!
//! A block is its length (u64, little-endian) and its bytes; the estimate's are those of [`estimate::snapshot`], those of a radius field and
//! of an emission guide are byte planes as on the wire. Jobs whose photons start by power have no guide.

use serde::{Deserialize, Serialize};

use super::rules::plan::Plan;
use super::rules::terms::MeasuredError;
use super::wire::planes;
use crate::estimate::{self, Estimate, RadiusField};
use crate::render::Guides;

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
    /// What passes need beside radii.
    pub guides: Guides,
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
    merged: u64,
    next_look: u64,
    error: Option<MeasuredError>,
    fields: Vec<FieldHeader>,
    /// Numbers of the emission guide.
    #[serde(default)]
    guide_values: usize,
    /// Numbers of the visibility of lights.
    #[serde(default)]
    visibility_values: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldHeader {
    key: FieldKey,
    base_pass: u32,
    typical_radius_squared: f32,
    pixels: usize,
}

impl BadSnapshot {
    fn because(problem: impl std::fmt::Display) -> Self {
        Self(problem.to_string())
    }
}

impl Snapshot {
    /// To bytes.
    pub fn encode(&self) -> Result<Vec<u8>, BadSnapshot> {
        let Self { plan, estimate, merged, next_look, error, fields, guides } = self;
        let field = |field: &SnapshotField| FieldHeader {
            key: field.key,
            base_pass: field.field.base_pass,
            typical_radius_squared: field.field.typical_radius_squared,
            pixels: field.field.radius_squared.len(),
        };
        let header = Header {
            plan: plan.clone(),
            merged: *merged,
            next_look: *next_look,
            error: *error,
            fields: fields.iter().map(field).collect(),
            guide_values: guides.emission.len(),
            visibility_values: guides.visibility.len(),
        };
        let mut bytes = MAGIC.to_vec();
        append(&mut bytes, &serde_json::to_vec(&header).map_err(BadSnapshot::because)?);
        append(&mut bytes, &estimate::snapshot::encode(estimate).map_err(BadSnapshot::because)?);
        for SnapshotField { field, .. } in fields {
            append(&mut bytes, &planes::compress(&field.radius_squared));
        }
        for values in [&guides.emission, &guides.visibility] {
            if !values.is_empty() {
                append(&mut bytes, &planes::compress(values));
            }
        }
        Ok(bytes)
    }

    /// From bytes.
    ///
    /// # Errors
    /// Bytes of another version, or that do not fit each other.
    pub fn decode(bytes: &[u8]) -> Result<Self, BadSnapshot> {
        let mut rest = bytes.strip_prefix(MAGIC).ok_or_else(|| BadSnapshot("it is of another version".to_owned()))?;
        let header: Header = serde_json::from_slice(take(&mut rest)?).map_err(BadSnapshot::because)?;
        let Header { plan, merged, next_look, error, fields, guide_values, visibility_values } = header;
        let estimate = estimate::snapshot::decode(take(&mut rest)?).map_err(BadSnapshot::because)?;
        let regions = estimate.progress.iter().map(|progress| progress.region);
        if (estimate.width, estimate.height) != (plan.width, plan.height) || !regions.eq(plan.regions.iter().copied()) {
            return Err(BadSnapshot("its estimate is not one of its plan".to_owned()));
        }
        let count = estimate.pixel_count();
        let field = |header: FieldHeader| {
            let FieldHeader { key, base_pass, typical_radius_squared, pixels } = header;
            let radius_squared =
                planes::decompress(take(&mut rest)?, pixels.min(count)).map_err(BadSnapshot::because)?;
            Ok(SnapshotField { key, field: RadiusField { radius_squared, base_pass, typical_radius_squared } })
        };
        let fields = fields.into_iter().map(field).collect::<Result<Vec<SnapshotField>, BadSnapshot>>()?;
        let mut values = |count: usize| match count {
            0 => Ok(Vec::new()),
            count => planes::decompress(take(&mut rest)?, count).map_err(BadSnapshot::because),
        };
        let guides = Guides { emission: values(guide_values)?, visibility: values(visibility_values)? };
        Ok(Self { plan, estimate, merged, next_look, error, fields, guides })
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::estimate::{Declaration, RadiusRule};

    #[test]
    fn a_snapshot_keeps_every_bit() {
        let plan = Plan::new(70, 50, 100_000, Some(75), RadiusRule::Statistics);
        let first: Vec<f32> = (1..=70 * 50).map(|index| 1.0 / index as f32).collect();
        let declaration = Arc::new(Declaration::gathering(RadiusRule::Statistics, 2.0 / 3.0));
        let estimate = Estimate::new(70, 50, &plan.regions, declaration, &first).expect("they fit");
        let field = estimate.radius_field(plan.regions[0]);
        let fields = vec![SnapshotField { key: FieldKey { epoch: 2, region: 0 }, field }];
        let guides = Guides { emission: vec![-1.0, 0.25, 0.75], visibility: vec![0.5, 1.0] };
        let snapshot = Snapshot { plan, estimate, merged: 17, next_look: 20, error: None, fields, guides };
        let bytes = snapshot.encode().expect("plain data");
        assert_eq!(Snapshot::decode(&bytes).as_ref(), Ok(&snapshot));
        for length in (0..bytes.len()).step_by(997) {
            assert!(Snapshot::decode(&bytes[..length]).is_err(), "{length} bytes");
        }
    }
}
