//! photonfarm: one photon-mapped picture on many machines.
//!
//! Data flows one way: a scene **description** is checked into a **prepared scene**, a **method** turns it into
//! **tallies** pass by pass, the coordinator **merges** them into an **estimate**, and the **picture** is read from it.
//!
//! | layer | what it knows | imports |
//! |---|---|---|
//! | [`math`] | vectors, frames, colour, distributions, random numbers, statistics | nothing |
//! | [`scene`] | description, check, prepare; geometry, materials, lights, cameras | math |
//! | [`import`] | one reader for each file format, all into one description | math, scene |
//! | [`transport`] | camera and photon walks, direct light, photon map, density estimates | math, scene |
//! | [`estimate`] | declarations, tally, merge rules, radius schedules, snapshots, picture | math |
//! | [`method`] | one file per method and one table | the above |
//! | [`render`] | passes on this machine's threads, cancellation | method and below |
//! | [`evaluation`] | error metrics, error over time, charts, the choice of a method | render and below |
//! | [`farm`] | job, schedule, coordinator, worker, wire | evaluation and below |
//! | [`api`] | REST and live events | farm |
//! | [`cli`] | one file per subcommand | all |

pub mod api;
pub mod cli;
pub mod estimate;
pub mod evaluation;
pub mod farm;
pub mod import;
pub mod math;
pub mod method;
pub mod render;
pub mod scene;
pub mod transport;
