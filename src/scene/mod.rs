//! From what a user wrote to what methods read: description, check, prepare.
//!
//! [`crate::import`] reads every format into one [`description`]; [`Scene::prepare`] checks it and builds what methods need.

pub mod bundle;
pub mod camera;
pub mod description;
pub mod error;
pub mod fields;
pub mod film;
pub mod geometry;
pub mod integrator;
pub mod light;
pub mod material;
pub mod medium;
pub mod names;
pub mod needs;
pub mod notice;
pub mod prepare;
mod sealed_lights;
pub mod texture;
mod unsupported;

pub use camera::Camera;
pub use error::SceneError;
pub use integrator::Integrator;
pub use medium::MediumIndex;
pub use prepare::Scene;
