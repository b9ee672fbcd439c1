//! From what a user wrote to what methods read: description, check, prepare.

pub mod bundle;
pub mod description;
pub mod error;
pub mod fields;
pub mod geometry;
pub mod import;
