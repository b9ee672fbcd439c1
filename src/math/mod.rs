//! Vectors, frames, colour, distributions, random numbers and warps. Imports nothing of this crate.

pub mod color;
pub mod discrete;
pub(crate) mod frame;
pub(crate) mod grid_distribution;
pub(crate) mod lanes;
pub mod octahedral;
pub mod random;
pub(crate) mod trigonometry;
pub mod warp;

pub use color::Rgb;
pub use frame::Frame;
pub use glam::{Vec2, Vec3};
