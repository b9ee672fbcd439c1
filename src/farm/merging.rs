//! A job's tallies on their way into its estimate: in shard order, each once, with the radii they were traced with.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytes::Bytes;
use prost::Message;

use super::job::StopRule;
use super::rules::plan::Plan;
use super::rules::terms::{MeasuredError, MergedTotals};
use super::snapshot::{FieldKey, Snapshot, SnapshotField};
use super::wire::{guides, radius};
use crate::estimate::{Declaration, Estimate, EstimateError, RadiusField, Tally};
use crate::render::{Guides, Pilot};

/// A radius field, as it is merged with and as it travels.
struct Field {
    field: RadiusField,
    message: Bytes,
}

impl Field {
    fn new(field: RadiusField) -> Self {
        let message = radius::encode(&field).encode_to_vec().into();
        Self { field, message }
    }
}

/// The merge state of a job whose pilot is done.
pub struct Merging {
    /// The job's cut.
    pub plan: Plan,
    /// What is merged.
    pub estimate: Estimate,
    /// Shards merged.
    merged: u64,
    /// Early tallies.
    waiting: BTreeMap<u64, Tally>,
    fields: BTreeMap<FieldKey, Arc<Field>>,
    error: Option<MeasuredError>,
    /// The error bound at which the job is done.
    wanted_error: Option<f64>,
    /// Shards merged when the error is looked at next.
    next_look: u64,
    /// The state that a longer job would have passed through, once what is merged goes beyond it.
    resume: Option<Vec<u8>>,
    /// What passes need beside radii.
    guides: Guides,
}

/// The error is looked at again when this share of shards was added.
const LOOK_SHARE: u64 = 8;

impl Merging {
    /// Starts from what the pilot found.
    pub fn new(
        plan: Plan,
        pilot: &Pilot,
        wanted_error: Option<f64>,
        declaration: Arc<Declaration>,
    ) -> Result<Self, EstimateError> {
        let estimate = Estimate::new(plan.width, plan.height, &plan.regions, declaration, pilot.radius_squared())?;
        let mut merging = Self {
            plan,
            estimate,
            merged: 0,
            waiting: BTreeMap::new(),
            fields: BTreeMap::new(),
            error: None,
            wanted_error,
            next_look: 2,
            resume: None,
            guides: pilot.guides(),
        };
        merging.take_fields(0);
        merging.keep_for_longer_jobs();
        Ok(merging)
    }

    /// All that is needed to go on from here, to the same bits. Early tallies are not part of it: their shards are traced again.
    pub fn snapshot(&self) -> Snapshot {
        let field = |(key, field): (&FieldKey, &Arc<Field>)| SnapshotField { key: *key, field: field.field.clone() };
        Snapshot {
            plan: self.plan.clone(),
            estimate: self.estimate.clone(),
            merged: self.merged,
            next_look: self.next_look,
            error: self.error,
            fields: self.fields.iter().map(field).collect(),
            guides: self.guides.clone(),
        }
    }

    /// Goes on from a snapshot, to an end that may be another.
    pub fn restore(snapshot: Snapshot, stop: &StopRule) -> Self {
        let Snapshot { plan, estimate, merged, next_look, error, fields, guides } = snapshot;
        let fields = fields.into_iter().map(|SnapshotField { key, field }| (key, Arc::new(Field::new(field))));
        let mut merging = Self {
            plan: plan.with_passes(stop.passes),
            estimate,
            merged,
            waiting: BTreeMap::new(),
            fields: fields.collect(),
            error,
            wanted_error: stop.error,
            next_look,
            resume: None,
            guides,
        };
        merging.keep_for_longer_jobs();
        merging
    }

    /// Shards merged.
    pub fn merged(&self) -> u64 {
        self.merged
    }

    /// Whether every longer job passes through this state.
    pub fn is_of_longer_jobs(&self) -> bool {
        self.merged <= self.plan.shards_of_longer_jobs()
    }

    /// The last state that every longer job passes through, as bytes, where that is not the current one.
    pub fn resume_snapshot(&self) -> Option<&[u8]> {
        self.resume.as_deref().filter(|_| !self.is_of_longer_jobs())
    }

    /// Keeps the state before the first shard that the job's end cuts short.
    fn keep_for_longer_jobs(&mut self) {
        let shared = self.plan.shards_of_longer_jobs();
        if self.merged == shared && shared < self.plan.shard_count() {
            self.resume = self.snapshot().encode().ok();
        }
    }

    /// Takes the tally of shard `index`, then merges all that is in turn.
    ///
    /// # Errors
    /// A fault of the coordinator, since tallies and order were checked before: the job cannot go on.
    pub fn add(&mut self, index: u64, tally: Tally) -> Result<(), String> {
        self.waiting.insert(index, tally);
        while !self.is_good_enough()
            && let Some(tally) = self.waiting.remove(&self.merged)
        {
            self.merge(&tally)?;
        }
        Ok(())
    }

    fn merge(&mut self, tally: &Tally) -> Result<(), String> {
        let planned = self.plan.shard(self.merged).ok_or("a shard past the end of the job")?;
        let key = FieldKey { epoch: planned.field_epoch, region: planned.region };
        let field = self.fields.get(&key).ok_or("a radius field that was dropped too early")?;
        self.estimate.merge(tally, &field.field).map_err(|problem| problem.to_string())?;
        self.merged += 1;
        self.look_at_error();
        let next_epoch = self.plan.epoch_of(self.merged);
        if next_epoch > self.plan.epoch_of(self.merged - 1) {
            self.begin_epoch(next_epoch);
        }
        self.keep_for_longer_jobs();
        Ok(())
    }

    /// Estimates the error after pairs of shards, so that both twins have their part. When, depends on the shards alone: a
    /// job that stops by its error has the same bits on any farm.
    fn look_at_error(&mut self) {
        if self.merged >= self.next_look {
            self.error = self.estimate.error().map(|error| MeasuredError { passes: self.estimate.passes(), error });
            self.next_look = (self.merged + (self.merged / LOOK_SHARE).max(1)).next_multiple_of(2);
        }
    }

    /// Whether the error bound that ends the job was met.
    fn is_good_enough(&self) -> bool {
        let bound = self.error.map(|measured| measured.error.bound);
        self.wanted_error.zip(bound).is_some_and(|(wanted, bound)| bound <= wanted)
    }

    /// All epochs before `epoch` are merged: their radii are those of epoch `epoch + lag`.
    fn begin_epoch(&mut self, epoch: u32) {
        let field_epoch = self.plan.field_epoch(epoch + self.plan.epoch_lag);
        if field_epoch > 0 {
            self.take_fields(field_epoch);
        }
        let oldest = self.plan.first_field_kept(epoch);
        self.fields.retain(|key, _| key.epoch >= oldest);
    }

    fn take_fields(&mut self, field_epoch: u32) {
        for (index, region) in self.plan.regions.iter().enumerate() {
            let field = self.estimate.radius_field(*region);
            let key = FieldKey { epoch: field_epoch, region: index as u32 };
            self.fields.insert(key, Arc::new(Field::new(field)));
        }
    }

    /// A radius field as it travels; `None` when it is not known yet or not needed any more.
    pub fn field_message(&self, field_epoch: u32, region: u32) -> Option<Bytes> {
        self.fields.get(&FieldKey { epoch: field_epoch, region }).map(|field| field.message.clone())
    }

    /// What passes need beside radii, as it travels.
    pub fn guides_message(&self) -> Bytes {
        guides::encode(&self.guides).encode_to_vec().into()
    }

    /// What is merged, in numbers.
    pub fn totals(&self) -> MergedTotals {
        MergedTotals {
            shards: self.merged,
            passes: self.estimate.passes(),
            photons_emitted: self.estimate.photons_emitted(),
            non_finite: self.estimate.non_finite(),
            acceptance: self.estimate.acceptance(),
            error: self.error,
            good_enough: self.is_good_enough(),
            early_bytes: self.waiting.values().map(Tally::bytes).sum(),
        }
    }
}
