//! How far pictures are from references, and how fast methods get there.
//!
//! [`compare`] measures one picture. [`follow`] renders a [`Reference`]'s scene and keeps the picture at each time budget; each becomes a
//! [`Record`], a line of a results file. [`curves()`] sums such lines up, [`changes()`] compares two files, and [`chart`] draws them,
//! together with other programs' curves ([`read_peers`]).

mod changes;
pub mod chart;
mod curves;
mod difference;
mod flip;
mod machine;
mod metrics;
mod peers;
mod plane;
mod record;
mod reference;
mod run;
mod sample;
mod shown;
mod significance;
mod similarity;
mod stopwatch;
mod survey;
mod time_shares;

pub use changes::{Change, ChangeRule, Verdict, changes};
pub use curves::{Curve, CurvePoint, Reached, Spread, common_budget, curves};
pub use difference::signed_difference;
pub use machine::Machine;
pub use metrics::{CompareError, Metrics, ReferenceNoise, compare};
pub use peers::{PeerPoint, PeersError, read_peers};
pub use record::{Record, ResultsError, ResultsFile, RunKey, read_results};
pub use reference::{Reference, ReferenceError, ReferencePlace, reference_folders, standard_error_of};
pub use run::{Run, RunError, Snapshot, follow, on_threads};
pub use sample::{Measure, Sample};
pub use shown::exposure_factor;
pub use stopwatch::{PoolStopwatch, ProcessStopwatch, Spent, Stopwatch, StopwatchError};
pub use survey::{DEFAULT_ERROR, Survey, Trial, check_candidates, survey};
pub use time_shares::{TimeShares, time_shares};
