//! How light and importance travel: walks, direct light, the photon map and density estimates.
//!
//! Knows nothing of jobs, workers or HTTP. Everything here is a pure function of the scene and of addressed random numbers.

pub mod bidirectional;
pub(crate) mod camera_walk;
pub(crate) mod caustic_splitting;
pub mod counters;
pub(crate) mod density_estimate;
pub mod direct_light;
pub mod direct_photons;
pub mod emission_learning;
pub(crate) mod evenness;
pub(crate) mod first_radius;
pub(crate) mod hit_point;
pub(crate) mod importance_map;
pub mod irradiance;
pub mod kernel;
pub(crate) mod light_path;
pub(crate) mod light_plan;
pub mod light_sights;
pub(crate) mod light_trials;
pub(crate) mod limits;
pub mod metropolis;
pub(crate) mod multiple_importance;
pub(crate) mod neighbor_choice;
pub(crate) mod occlusion;
pub mod photon_map;
pub mod photon_tracing;
pub(crate) mod plausibility;
pub(crate) mod projection;
pub mod receiver;
pub mod shading;
pub(crate) mod specular_chain;
pub(crate) mod visibility;
pub mod visibility_learning;
pub(crate) mod walk;

pub use counters::Counters;
pub use limits::Limits;
