//! Passes on this machine's threads. The one door through which farm workers reach the methods.

pub mod first_surface;
pub mod mattes;
mod part;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::estimate::declaration::{NON_FINITE, PHOTONS_EMITTED, PHOTONS_STORED, RAYS};
use crate::estimate::{Declaration, GroupSums, ProposalCount, RadiusField, Shard, ShardSums, Tally};
use crate::method::{
    self, CheckedMethod, EMISSION_GUIDE, FIRST_RADIUS_SQUARED, LIGHT_VISIBILITY, MethodError, Pass, PilotField,
};
use crate::scene::Scene;
use crate::scene::light::emission_guide;
use crate::scene::light::visibility::VisibilityError;
use crate::transport::Counters;
use crate::transport::counters::{Step, StepCounts};
use part::Part;

/// The caller asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What a pilot learnt that all passes of its job need.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guides {
    /// Where photons start, as numbers of an [`EmissionGuide`](emission_guide::EmissionGuide); empty for emission by power.
    pub emission: Vec<f32>,
    /// Which lights are seen where, as numbers of a [`LightVisibility`](crate::scene::light::LightVisibility); empty for picks that know nothing of it.
    pub visibility: Vec<f32>,
}

/// Guides that do not fit a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GuideError {
    /// Where photons start.
    #[error(transparent)]
    Emission(#[from] emission_guide::GuideError),
    /// Which lights are seen where.
    #[error(transparent)]
    Visibility(#[from] VisibilityError),
    /// The job cannot be prepared again.
    #[error(transparent)]
    Method(#[from] MethodError),
}

/// What the pilot finds out before the first pass; a worker runs it like a shard.
#[derive(Clone, Debug, PartialEq)]
pub struct Pilot {
    /// Numbers by name: first radii where the method gathers, and whatever else its passes need.
    pub fields: Vec<PilotField>,
    /// Counts by name, [`COST_PER_PASS`] among them.
    pub counts: Vec<(String, u64)>,
}

/// The name of a pilot's count of what one pass of the whole picture costs, in nominal microseconds of one core: counted rays, photons
/// and gathers times fixed constants, never measured time.
pub const COST_PER_PASS: &str = "cost_per_pass";

impl Pilot {
    /// A pilot that found `fields`, and that a pass costs so much.
    pub fn new(fields: Vec<PilotField>, cost_per_pass: u64) -> Self {
        Self { fields, counts: vec![(COST_PER_PASS.to_owned(), cost_per_pass)] }
    }

    /// A field by name.
    pub fn field(&self, name: &str) -> Option<&[f32]> {
        self.fields.iter().find(|field| field.name == name).map(|field| field.values.as_slice())
    }

    /// A count by name.
    pub fn count(&self, name: &str) -> Option<u64> {
        self.counts.iter().find(|(counted, _)| counted == name).map(|(_, count)| *count)
    }

    /// First gather radius² per pixel of the whole picture, m²; empty where the method gathers nothing.
    pub fn radius_squared(&self) -> &[f32] {
        self.field(FIRST_RADIUS_SQUARED).unwrap_or_default()
    }

    /// What passes need beside radii.
    pub fn guides(&self) -> Guides {
        let values = |name: &str| self.field(name).unwrap_or_default().to_vec();
        Guides { emission: values(EMISSION_GUIDE), visibility: values(LIGHT_VISIBILITY) }
    }

    /// See [`COST_PER_PASS`].
    pub fn cost_per_pass(&self) -> u64 {
        self.count(COST_PER_PASS).unwrap_or(1)
    }
}

/// A job ready to be traced on this machine: prepared scene, checked method, seed, and what its pilot learnt. Every function is pure.
#[derive(Clone)]
pub struct Renderer {
    checked: CheckedMethod,
    seed: u64,
    /// Of all light.
    whole: Part,
    /// Of the light of each group by name, where they are kept apart.
    groups: Vec<(String, Part)>,
    declaration: Arc<Declaration>,
}

impl Renderer {
    /// Prepares `method` for `scene`.
    pub fn new(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Self, MethodError> {
        let declaration = method::declaration(method);
        let whole = Part::new(scene, method, seed)?;
        Ok(Self { checked: method.clone(), seed, whole, groups: Vec::new(), declaration })
    }

    /// The same job with the light of each group kept apart. The method is prepared once for each group, for a scene in which nothing else
    /// emits: no method knows of groups, and all of them follow the same camera paths.
    ///
    /// # Errors
    /// See [`method::check_light_groups`].
    pub fn with_light_groups(self) -> Result<Self, MethodError> {
        let scene = &self.whole.scene;
        let names = scene.lights.groups().names().to_vec();
        method::check_light_groups(Some(&self.checked), &names)?;
        let part = |(index, name): (usize, &String)| {
            let lit = Arc::new(scene.with_lights(scene.lights.only(index)));
            Ok((name.clone(), Part::new(lit, &self.checked, self.seed)?))
        };
        let groups = names.iter().enumerate().map(part).collect::<Result<Vec<_>, MethodError>>()?;
        let declaration = Arc::new(Declaration::clone(&self.declaration).with_light_groups(&names));
        Ok(Self { groups, declaration, ..self })
    }

    /// The same job as its pilot found that it is best traced: see [`Pilot::guides`]. Whoever traces any of a job's
    /// passes must trace them so.
    ///
    /// # Errors
    /// Numbers that do not fit the scene's lights.
    pub fn guided(&self, guides: &Guides) -> Result<Self, GuideError> {
        let guided = |part: &Part| part.guided(guides, &self.checked, self.seed);
        let groups = self.groups.iter().map(|(name, part)| Ok((name.clone(), guided(part)?)));
        Ok(Self { whole: guided(&self.whole)?, groups: groups.collect::<Result<_, GuideError>>()?, ..self.clone() })
    }

    /// What its tallies hold.
    pub fn declaration(&self) -> &Arc<Declaration> {
        &self.declaration
    }

    /// Finds which lights are seen where, where photons should start, first radii and costs, on the calling rayon pool. Light groups have
    /// all of it in common.
    pub fn pilot(&self, cancel: &AtomicBool) -> Result<Pilot, Cancelled> {
        let scene = &self.whole.scene;
        let visibility = match self.checked.light_sampling() {
            Some(sampling) => sampling.learn(scene, self.seed, cancel).ok_or(Cancelled)?,
            None => None,
        };
        let guides = Guides { visibility: visibility.unwrap_or_default(), ..Guides::default() };
        // The numbers were read once already.
        let seeing = self.whole.guided(&guides, &self.checked, self.seed).unwrap_or_else(|_| self.whole.clone());
        let mut found = seeing.method.pilot(cancel).ok_or(Cancelled)?;
        if !guides.visibility.is_empty() {
            found.fields.push(PilotField { name: LIGHT_VISIBILITY.to_owned(), values: guides.visibility });
        }
        let cost = nominal_cost(&found.counters, scene.pixel_count());
        Ok(Pilot::new(found.fields, cost * self.groups.len().max(1) as u64))
    }

    /// Traces a shard with the radii of `field` (one per pixel of the shard's region where the method gathers), on the calling rayon pool.
    pub fn trace(&self, shard: Shard, field: &RadiusField, cancel: &AtomicBool) -> Result<Tally, Cancelled> {
        let width = self.whole.scene.width;
        let mut total = Counters::default();
        let mut tally = if self.groups.is_empty() {
            let (sums, counters) = self.trace_part(&self.whole, shard, field, cancel)?;
            total += counters;
            Tally::from_sums(shard, width, &self.declaration, &sums)
        } else {
            let mut groups = Vec::new();
            for (name, part) in &self.groups {
                let (sums, counters) = self.trace_part(part, shard, field, cancel)?;
                total += counters;
                let photons_emitted = counters.photons_emitted;
                groups.push(GroupSums { group: name.clone(), sums, photons_emitted });
            }
            Tally::from_groups(shard, width, &self.declaration, &groups)
        };
        set_counts(&mut tally, &total);
        Ok(tally)
    }

    /// Traces the passes of a shard.
    fn trace_part(
        &self,
        part: &Part,
        shard: Shard,
        field: &RadiusField,
        cancel: &AtomicBool,
    ) -> Result<(ShardSums, Counters), Cancelled> {
        let mut sums = ShardSums::zero_declared(shard.region.pixel_count(part.scene.width), &self.declaration);
        let mut total = Counters::default();
        for index in shard.pass_indices() {
            let scale = field.scale_of_pass(self.declaration.radius_rule, self.declaration.alpha, index);
            let pass = Pass {
                index,
                region: shard.region,
                radius_squared: &field.radius_squared,
                scale,
                typical_radius_squared: field.typical_radius_squared * scale,
                guide: part.guide.as_deref(),
            };
            total += part.method.trace_pass(&pass, &mut sums, cancel).ok_or(Cancelled)?;
        }
        Ok((sums, total))
    }
}

/// Sets what is counted over a whole shard.
fn set_counts(tally: &mut Tally, total: &Counters) {
    tally.set_scalar(PHOTONS_EMITTED, total.photons_emitted as f64);
    tally.set_scalar(PHOTONS_STORED, total.photons_stored as f64);
    tally.set_scalar(RAYS, total.rays as f64);
    tally.set_scalar(NON_FINITE, total.non_finite as f64);
    let StepCounts { proposed, accepted } = total.steps;
    for (step, (proposed, accepted)) in Step::ALL.iter().zip(proposed.into_iter().zip(accepted)) {
        tally.set_proposals(step.name(), ProposalCount { proposed, accepted });
    }
}

/// Nanoseconds of one core for each thing counted, as measured once (docs/measured/PERFORMANCE.md); only their order matters.
const NANOSECONDS_PER_RAY: u64 = 90;
const NANOSECONDS_PER_PHOTON: u64 = 60;
const NANOSECONDS_PER_PIXEL: u64 = 250;

fn nominal_cost(counters: &Counters, pixels: usize) -> u64 {
    let nanoseconds = counters.rays * NANOSECONDS_PER_RAY
        + counters.photons_stored * NANOSECONDS_PER_PHOTON
        + pixels as u64 * NANOSECONDS_PER_PIXEL;
    nanoseconds / 1000 + 1
}
