//! Methods, materials, formats and references agree with each other within what noise explains.

mod formats;
mod materials;
mod methods;
mod photon_map;
mod references;
