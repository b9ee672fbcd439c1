//! Markov chains over the random numbers of paths.
//!
//! [`path_chains`] bring light to the picture, [`photon_chains`] make photons. [`sample`] is a path with a length and a way of finding
//! it, made of recorded numbers; [`mutation`] changes such numbers.

pub mod mutation;
pub mod path_chains;
pub mod photon_chains;
pub mod sample;
