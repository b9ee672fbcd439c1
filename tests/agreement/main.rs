//! Methods, materials, formats and references agree with each other within what noise explains.

#[path = "../support/progressive.rs"]
mod progressive;
#[path = "../support/scene_text.rs"]
mod scene_text;

mod batches;
mod caustic_splitting;
mod formats;
mod guided_emission;
mod irradiance_cache;
mod many_maps;
mod materials;
mod methods;
mod metropolis;
mod photon_chains;
mod photon_look_ups;
mod photon_map;
mod photon_map_direct;
mod photon_paths;
mod references;
mod visible_lights;
mod whole_paths;
