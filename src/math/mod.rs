//! Vectors, frames, colour, distributions, random numbers and statistics. Imports nothing of this crate.
