//! Shapes, and the readers of mesh files.

pub mod obj;
pub mod ply;
pub mod triangle_mesh;
