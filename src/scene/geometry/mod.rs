//! Shapes: one file per kind, one row each in [`primitive`]'s table, all behind one accelerator.

pub mod accelerator;
pub mod block;
pub mod curve;
pub mod cylinder;
pub mod disk;
pub mod instance;
pub mod mesh;
pub mod obj;
pub mod obstacles;
pub mod one_sided_triangle;
pub mod parameterization;
pub mod ply;
pub mod primitive;
pub mod ray;
pub mod rectangle;
pub mod serialized;
pub mod sphere;
pub mod surface;
mod texture_point;
pub mod transform;
pub mod triangle;
pub mod triangle_mesh;

pub use instance::Instance;
pub use obstacles::{Layer, Obstacles};
pub use primitive::Primitive;
pub use ray::Ray;
pub use surface::{Geometry, Interaction, Shape};
pub use texture_point::{Detail, TexturePoint};
pub use triangle_mesh::TriangleMesh;
