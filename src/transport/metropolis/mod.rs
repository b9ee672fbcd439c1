//! Markov chains of light paths.
//!
//! [`chains`] run over any [`Space`](chains::Space) of states: over the random numbers of bidirectional paths ([`primary_space`]), or over paths
//! themselves ([`path_space`]). [`photon_chains`] and [`photon_paths`] make photons. [`mutation`] changes numbers.

pub mod chains;
pub mod eye_subpaths;
pub mod mutation;
pub mod path_space;
pub(crate) mod photon_chains;
pub mod photon_paths;
pub(crate) mod primary_space;
pub(crate) mod sample;
