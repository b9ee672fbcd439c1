//! Paths that are made from two ends, and the weights that let every way of finding a path share in it.
//!
//! A light subpath y₀ … y_j and a camera subpath x₀ … x_i become one path in five ways, the **techniques**:
//!
//! | technique | the path is | segments |
//! |---|---|---|
//! | [`Techniques::HIT`] | a camera subpath that hits a light by chance | i |
//! | [`Techniques::DIRECT`] | a camera subpath and a point sampled on a light | i + 1 |
//! | [`Techniques::CONNECT`] | both subpaths and a segment between their ends | i + j + 1 |
//! | [`Techniques::CAMERA`] | a light subpath and a segment to the camera | j + 1 |
//! | [`Techniques::MERGE`] | both subpaths, whose ends lie within a radius of each other | i + j |
//!
//! All but merging is bidirectional path tracing [Veach 1997, chapter 10]; merging counts as a technique whose density is
//! that of both subpaths times π r², the probability that the ends meet [Georgiev, Křivánek, Davidovič & Slusallek 2012,
//! "Light transport simulation with vertex connection and merging", eq. 11]. [`weights`] has the equations.
//!
//! Methods choose techniques and let [`LightWalk`] and [`CameraWalk`] do the rest; none has a walk or a weight of its own.

mod camera_walk;
mod joining;
mod light_walk;
mod media;
mod selection;
mod stored_vertex;
mod vertex;
pub(crate) mod weights;

pub use camera_walk::CameraWalk;
pub use joining::{Merging, SeenVertex, connect, direct_light, for_each_pixel, merge, to_camera};
pub use light_walk::LightWalk;
pub use selection::{Selection, Show};
pub use stored_vertex::{MergePhoton, MergeRecord, StoredVertex};
pub use vertex::Vertex;
pub use weights::{Heuristic, Measure, Techniques, Weighting};
