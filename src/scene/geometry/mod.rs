//! Shapes: one file per kind, one row each in [`primitive`]'s table, all behind one accelerator.

pub(crate) mod accelerator;
pub mod block;
pub(crate) mod curve;
pub(crate) mod cylinder;
pub(crate) mod disk;
pub(crate) mod instance;
pub mod mesh;
pub mod obj;
pub(crate) mod obstacles;
pub mod one_sided_triangle;
pub(crate) mod parameterization;
pub mod ply;
pub mod primitive;
pub mod ray;
pub(crate) mod rectangle;
pub mod serialized;
pub(crate) mod sphere;
pub(crate) mod surface;
mod texture_point;
pub(crate) mod transform;
pub mod triangle;
pub mod triangle_mesh;

pub use instance::Instance;
pub use obstacles::{Layer, Obstacles};
pub use primitive::Primitive;
pub use ray::Ray;
pub use surface::{Geometry, Interaction, Shape};
pub use texture_point::{Detail, TexturePoint};
pub use triangle_mesh::TriangleMesh;
