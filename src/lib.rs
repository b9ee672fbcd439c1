//! photonfarm: one photon-mapped picture on many machines.
//!
//! A scene in, a picture out:
//!
//! ```
//! use std::{path::Path, sync::Arc};
//!
//! use photonfarm::evaluation::Run;
//! use photonfarm::import::load_file;
//! use photonfarm::method::{self, MethodChoice};
//! use photonfarm::scene::Scene;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let size = [("size".to_owned(), "16".to_owned())];
//! let description = load_file(Path::new("scenes/cornell-diffuse/scene.xml"), &size)?;
//! let scene = Arc::new(Scene::prepare(&description)?);
//! let choice = MethodChoice { name: "path".to_owned(), parameters: serde_json::Map::new() };
//! let mut run = Run::start(&scene, &method::check(&choice, scene.pixel_count() as u64)?, 1)?;
//! run.pass()?;
//! let picture = run.picture();
//! assert_eq!((picture.width, picture.height), (16, 16));
//! assert!(picture.radiance.iter().flatten().any(|value| *value > 0.0));
//! # Ok(())
//! # }
//! ```
//!
//! The same by a farm, coordinator and worker in this process:
//!
//! ```
//! use photonfarm::farm::LocalFarm;
//! use photonfarm::farm::job::{JobRequest, StopRule};
//!
//! # #[tokio::main]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let farm = LocalFarm::builder().workers(1).threads(1).start().await?;
//! let scene = farm.client().add_scene(std::fs::read("tests/references/furnace-closed/scene.xml")?).await?;
//! let stop = StopRule { passes: Some(2), ..StopRule::default() };
//! let job = farm.client().submit(JobRequest { stop, ..JobRequest::of_scene(scene.hash) }).await?;
//! farm.client().watch(job)?.wait_for(|status| status.state.is_final()).await?;
//! let (picture, _) = farm.client().picture(job).await?;
//! farm.stop().await;
//! assert_eq!(picture.radiance.len(), (picture.width * picture.height) as usize);
//! # Ok(())
//! # }
//! ```
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
