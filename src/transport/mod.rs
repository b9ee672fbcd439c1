//! How light and importance travel: walks, direct light, the photon map and density estimates.
//!
//! Knows nothing of jobs, workers or HTTP. Everything here is a pure function of the scene and of addressed random numbers.

pub mod bidirectional;
pub mod camera_walk;
pub mod caustic_splitting;
pub mod counters;
pub mod density_estimate;
pub mod direct_light;
pub mod direct_photons;
pub mod emission_learning;
pub mod evenness;
pub mod first_radius;
pub mod hit_point;
pub mod importance_map;
pub mod irradiance;
pub mod kernel;
pub mod light_path;
pub mod light_plan;
pub mod light_sights;
pub mod light_trials;
pub mod limits;
pub mod metropolis;
pub mod multiple_importance;
pub mod neighbor_choice;
pub mod occlusion;
pub mod photon_map;
pub mod photon_tracing;
pub mod plausibility;
pub mod projection;
pub mod receiver;
pub mod shading;
pub mod specular_chain;
pub mod visibility;
pub mod visibility_learning;
pub mod walk;

pub use counters::Counters;
pub use limits::Limits;
