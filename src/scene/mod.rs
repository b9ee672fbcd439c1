//! From what a user wrote to what methods read: description, check, prepare.
//!
//! [`crate::import`] reads every format into one [`description`]; [`Scene::prepare`] checks it and builds what methods need.

pub mod bundle;
pub mod camera;
pub mod description;
pub mod error;
pub mod fields;
pub(crate) mod film;
pub mod geometry;
pub(crate) mod integrator;
pub mod light;
pub mod material;
pub(crate) mod medium;
pub(crate) mod names;
pub(crate) mod needs;
pub(crate) mod notice;
pub(crate) mod prepare;
mod sealed_lights;
pub(crate) mod texture;
mod unsupported;

pub use camera::Camera;
pub use error::SceneError;
pub use integrator::Integrator;
pub use medium::MediumIndex;
pub use prepare::Scene;
