//! A job's tallies on their way into its estimate: in shard order, each once, with the radii they were traced with.

use std::collections::BTreeMap;
use std::sync::Arc;

use prost::Message;

use super::job::StopRule;
use super::rules::plan::Plan;
use super::rules::progress::{MeasuredError, MergedTotals};
use super::wire::{messages, radius, result};
use crate::estimate::{Declaration, Estimate, EstimateError, RadiusField, Tally};
use crate::render::Pilot;

/// A radius field, as it is merged with and as it travels.
struct Field {
    field: RadiusField,
    message: Arc<[u8]>,
}

/// The merge state of a job whose pilot is done.
pub struct Merging {
    /// The job's cut.
    pub plan: Plan,
    /// What is merged.
    pub estimate: Estimate,
    /// Shards merged.
    merged: u64,
    /// Early tallies, as they came: compressed, and checked.
    waiting: BTreeMap<u64, messages::Tally>,
    /// By field epoch, then region.
    fields: BTreeMap<(u32, u32), Arc<Field>>,
    error: Option<MeasuredError>,
    /// The error bound at which the job is done.
    wanted_error: Option<f64>,
    /// Shards merged when the error is looked at next.
    next_look: u64,
}

/// The error is looked at again when this share of shards was added.
const LOOK_SHARE: u64 = 8;

impl Merging {
    /// Starts from what the pilot found.
    pub fn new(
        width: u32,
        height: u32,
        pilot: &Pilot,
        stop: &StopRule,
        declaration: Arc<Declaration>,
    ) -> Result<Self, EstimateError> {
        let plan = Plan::new(width, height, pilot.cost_per_pass(), stop.passes, declaration.radius_rule);
        let estimate = Estimate::new(width, height, &plan.regions, declaration, pilot.radius_squared())?;
        let mut merging = Self {
            plan,
            estimate,
            merged: 0,
            waiting: BTreeMap::new(),
            fields: BTreeMap::new(),
            error: None,
            wanted_error: stop.error,
            next_look: 2,
        };
        merging.take_fields(0);
        Ok(merging)
    }

    /// Takes the tally of shard `index`, then merges all that is in turn. `message` is the same tally as it came.
    ///
    /// # Errors
    /// A fault of the coordinator, since tallies and order were checked before: the job cannot go on.
    pub fn add(&mut self, index: u64, tally: &Tally, message: messages::Tally) -> Result<(), String> {
        if index != self.merged {
            self.waiting.insert(index, message);
            return Ok(());
        }
        self.merge(tally)?;
        while !self.is_good_enough()
            && let Some(message) = self.waiting.remove(&self.merged)
        {
            let planned = self.plan.shard(self.merged).ok_or("a shard past the end of the job")?;
            let declaration = self.estimate.declaration();
            let tally = result::decode_tally(&message, planned.shard, self.plan.width, declaration);
            let tally = tally.map_err(|problem| problem.to_string())?;
            self.merge(&tally)?;
        }
        Ok(())
    }

    fn merge(&mut self, tally: &Tally) -> Result<(), String> {
        let planned = self.plan.shard(self.merged).ok_or("a shard past the end of the job")?;
        let key = (planned.field_epoch, planned.region);
        let field = self.fields.get(&key).ok_or("a radius field that was dropped too early")?;
        self.estimate.merge(tally, &field.field).map_err(|problem| problem.to_string())?;
        self.merged += 1;
        self.look_at_error();
        let next_epoch = self.plan.epoch_of(self.merged);
        if next_epoch > self.plan.epoch_of(self.merged - 1) {
            self.begin_epoch(next_epoch);
        }
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
        let oldest = self.plan.field_epoch(epoch);
        self.fields.retain(|(epoch, _), _| *epoch >= oldest);
    }

    fn take_fields(&mut self, field_epoch: u32) {
        for (index, region) in self.plan.regions.iter().enumerate() {
            let field = self.estimate.radius_field(*region);
            let message = radius::encode(&field).encode_to_vec().into();
            self.fields.insert((field_epoch, index as u32), Arc::new(Field { field, message }));
        }
    }

    /// A radius field as it travels; `None` when it is not known yet or not needed any more.
    pub fn field_message(&self, field_epoch: u32, region: u32) -> Option<Arc<[u8]>> {
        self.fields.get(&(field_epoch, region)).map(|field| field.message.clone())
    }

    /// What is merged, in numbers.
    pub fn totals(&self) -> MergedTotals {
        MergedTotals {
            shards: self.merged,
            passes: self.estimate.passes(),
            photons_emitted: self.estimate.photons_emitted(),
            non_finite: self.estimate.non_finite(),
            error: self.error,
            good_enough: self.is_good_enough(),
        }
    }
}
