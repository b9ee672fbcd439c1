//! Markov chains over the random numbers of paths.
//!
//! [`sample`] is a path with a length and a way of finding it, made of recorded numbers; [`mutation`] changes such numbers. Methods run the chains.

pub mod mutation;
pub mod sample;
