//! An estimate as bytes and back, to the same bits: whoever restores one goes on merging as if nothing had happened.
//!
//! ```text
//! "PFES" | version (u32) | header's length (u32) | header (JSON: EstimateHeader) | planes (f64)
//! ```
//!
//! Numbers are little-endian. The planes are those of [`Estimate::planes`]: the even twin's declared planes, the odd twin's, R² and N.
//! Nothing is compressed: sums in double precision hardly shrink, and copying them is all that a snapshot costs.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::declaration::Declaration;
use super::merging::{Estimate, EstimateError, RegionProgress};
use super::shrinking::Radii;

const MAGIC: &[u8; 4] = b"PFES";
/// Rises when the header or the order of planes changes.
const VERSION: u32 = 1;

/// All of an estimate but its planes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateHeader {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// What planes and scalars there are.
    pub declaration: Declaration,
    /// The regions with their passes and scalars.
    pub progress: Vec<RegionProgress>,
}

/// Bytes that are no snapshot of an estimate.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// They do not begin as a snapshot does.
    #[error("this is no snapshot of an estimate")]
    NoSnapshot,
    /// Another version of the program wrote it.
    #[error("the snapshot has format {found}; this program reads format {VERSION}")]
    OtherVersion {
        /// Its format.
        found: u32,
    },
    /// The header cannot be read.
    #[error("the snapshot's header cannot be read")]
    Header(#[from] serde_json::Error),
    /// Header and planes do not fit.
    #[error("the snapshot contradicts itself")]
    Contradiction(#[from] EstimateError),
}

impl Estimate {
    /// All but the planes.
    pub fn header(&self) -> EstimateHeader {
        EstimateHeader {
            width: self.width,
            height: self.height,
            declaration: Declaration::clone(&self.declaration),
            progress: self.progress.clone(),
        }
    }

    /// The planes: the even twin's sums as declared, the odd twin's, R² and N. Planes without values are empty.
    pub fn planes(&self) -> Vec<&[f64]> {
        let radii = [&self.radii.radius_squared, &self.radii.photons];
        self.twins.iter().flatten().chain(radii).map(Vec::as_slice).collect()
    }

    /// The inverse of [`Self::header`] and [`Self::planes`].
    pub fn from_parts(header: EstimateHeader, planes: Vec<Vec<f64>>) -> Result<Self, EstimateError> {
        header.declaration.check()?;
        let wrong = |plane, expected, found| Err(EstimateError::WrongSize { plane, expected, found });
        let sizes = header.plane_sizes();
        if planes.len() != sizes.len() {
            return wrong("the list of planes", sizes.len(), planes.len());
        }
        if let Some((size, plane)) = sizes.iter().zip(&planes).find(|(size, plane)| **size != plane.len()) {
            return wrong("a plane", *size, plane.len());
        }
        let scalars = header.declaration.scalars.len();
        let lists = header.progress.iter().flat_map(|progress| &progress.scalars);
        if let Some(list) = lists.into_iter().find(|list| list.len() != scalars) {
            return wrong("a list of scalars", scalars, list.len());
        }
        if let Some(region) = header
            .progress
            .iter()
            .map(|progress| progress.region)
            .find(|region| region.row_start > region.row_end || region.row_end > header.height)
        {
            return wrong("a region", header.height as usize, region.row_end as usize);
        }
        let declared = header.declaration.planes.len();
        let mut planes = planes.into_iter();
        let twins = [0, 1].map(|_| planes.by_ref().take(declared).collect());
        let [radius_squared, photons] = [0, 1].map(|_| planes.next().unwrap_or_default());
        let EstimateHeader { width, height, declaration, progress } = header;
        let declaration = Arc::new(declaration);
        Ok(Self { width, height, progress, declaration, twins, radii: Radii { radius_squared, photons } })
    }
}

impl EstimateHeader {
    /// Values in each of the estimate's planes.
    fn plane_sizes(&self) -> Vec<usize> {
        let pixels = self.width as usize * self.height as usize;
        let sums = self.declaration.planes.iter();
        let sums: Vec<usize> =
            sums.map(|plane| if plane.is_summed() { plane.channels.saturating_mul(pixels) } else { 0 }).collect();
        let when = |present: bool| if present { pixels } else { 0 };
        let radii = [when(self.declaration.has_radii()), when(self.declaration.shrinks_by_count())];
        sums.iter().chain(&sums).chain(&radii).copied().collect()
    }
}

/// Writes an estimate.
pub fn encode(estimate: &Estimate) -> Result<Vec<u8>, SnapshotError> {
    let (header, planes) = (serde_json::to_vec(&estimate.header())?, estimate.planes());
    let values: usize = planes.iter().map(|plane| plane.len()).sum();
    let mut bytes = Vec::with_capacity(12 + header.len() + values * 8);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(header.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&header);
    // The one target that the program is built for stores numbers as the file does.
    const { assert!(cfg!(target_endian = "little")) };
    planes.iter().for_each(|plane| bytes.extend_from_slice(bytemuck::cast_slice(plane)));
    Ok(bytes)
}

/// Reads what [`encode`] wrote. Memory is allocated for what the bytes hold, never for what they claim.
pub fn decode(bytes: &[u8]) -> Result<Estimate, SnapshotError> {
    let (magic, rest) = bytes.split_first_chunk::<4>().ok_or(SnapshotError::NoSnapshot)?;
    let (version, rest) = rest.split_first_chunk::<4>().ok_or(SnapshotError::NoSnapshot)?;
    if magic != MAGIC {
        return Err(SnapshotError::NoSnapshot);
    }
    let found = u32::from_le_bytes(*version);
    if found != VERSION {
        return Err(SnapshotError::OtherVersion { found });
    }
    let (length, rest) = rest.split_first_chunk::<4>().ok_or(SnapshotError::NoSnapshot)?;
    let parts = rest.split_at_checked(u32::from_le_bytes(*length) as usize);
    let (header, mut values) = parts.ok_or(SnapshotError::NoSnapshot)?;
    let header: EstimateHeader = serde_json::from_slice(header)?;
    let mut planes = Vec::new();
    for expected in header.plane_sizes() {
        let size = expected.saturating_mul(8);
        let cut_off = EstimateError::WrongSize { plane: "a plane", expected, found: values.len() / 8 };
        let (plane, rest) = values.split_at_checked(size).ok_or(cut_off)?;
        planes.push(bytemuck::pod_collect_to_vec(plane));
        values = rest;
    }
    if !values.is_empty() {
        let left_over = EstimateError::WrongSize { plane: "the rest", expected: 0, found: values.len() };
        return Err(left_over.into());
    }
    Ok(Estimate::from_parts(header, planes)?)
}
