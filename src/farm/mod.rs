//! One picture on many machines: jobs, schedule, coordinator, workers, wire.
//!
//! # One pass, from lease to picture
//!
//! 1. A user uploads a scene and submits a job. The [coordinator](CoordinatorHandle) checks both, [stores](store) the job, and tells the
//!    [`rules`]. It never traces: whatever has to be traced is leased to workers, also the trials of methods where the method is `auto`, and
//!    the first surfaces that [layers](CoordinatorHandle::picture_with_layers) need.
//! 2. A [`worker`] registers over [HTTP](http) and asks for a lease. The first work of a job is its **pilot**:
//!    first gather radii and the counted cost of a pass. From that follows the [plan](rules::plan), how passes are cut into shards
//!    and epochs. It depends on the scene and the job alone, never on workers or time.
//! 3. The next [lease](rules::lease) names a shard: some consecutive passes of a region of pixels. The worker fetches what it has not
//!    got yet, the scene by its hash and the radius field of the shard's epoch, and traces. Meanwhile it fetches the next
//!    lease, sends the last tally, and says by heartbeats that it lives.
//! 4. The tally travels as compressed byte planes ([`wire`]). The coordinator decodes and checks it without holding a
//!    lock. A tally that does not fit its shard is refused; a repeated one changes nothing; one whose lease expired is
//!    fenced, for someone else has the shard now. A worker that fails often is [set aside](rules::roster) for a while.
//! 5. Accepted tallies are [merged](merging) strictly in the plan's order; early ones wait. After the last shard of an
//!    epoch the new radii become the field of the epoch after the next, so nobody waits at a barrier.
//! 6. Watchers of the job see its status change; the picture can be read at any time. When the last shard is merged,
//!    or the time is over, the job is done.
//!
//! Since passes are pure functions and merges have one order, the picture has the same bits whoever traced what, however
//! often, and in whatever order it arrived.
//!
//! # Where to look
//!
//! | module | what it does |
//! |---|---|
//! | [`rules`] | who traces what: a state machine without clock, locks or I/O; [`rules::plan`] cuts a job |
//! | [`merging`], [`snapshot`] | a job's merge state: order of merges, radius fields; the same as bytes |
//! | [`store`] | what outlives the process: records in SQL, blobs in folders or buckets |
//! | [`coordinator`] | the loop between them: locks, a clock, users' requests, what is stored when |
//! | [`http`], [`wire`] | the workers' protocol |
//! | [`worker`] | the other end |
//! | [`dial`] | how this process opens connections to others |
//! | [`method_choice`], [`prepared_scenes`], [`tls`] | trials of methods; the scenes of this process; the cryptography of its clients |
//! | [`sequence`] | many frames of one scene: what each shows |
//! | [`webhooks`] | programs that are told of jobs |
//! | [`standby`] | coordinators that wait until they lead |
//! | [`local_farm`] | all of it inside a program |

pub mod access;
mod changed_scene;
pub mod coordinator;
pub mod cut;
pub mod dial;
pub(crate) mod error;
mod events;
pub mod http;
pub mod ids;
pub mod job;
pub(crate) mod local_farm;
mod locks;
pub(crate) mod login;
pub(crate) mod measured;
pub mod merging;
pub mod method_choice;
pub mod prepared_scenes;
pub mod rules;
pub mod sequence;
pub mod snapshot;
pub(crate) mod standby;
pub(crate) mod status_of_worker;
pub mod store;
mod text;
pub mod tls;
pub mod webhooks;
pub mod wire;
pub mod worker;

pub use coordinator::{
    CoordinatorHandle, CoordinatorOptions, LayeredPicture, Limits, SceneLayout, SceneSummary, UserLimits,
};
pub use error::FarmError;
pub use events::EVENTS;
pub use local_farm::LocalFarm;
