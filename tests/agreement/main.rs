//! Methods, materials, formats and references agree with each other within what noise explains, and fast loops with their plain twins to the bit.

#[path = "../support/chi_square.rs"]
#[expect(dead_code, reason = "only its numbers are used here")]
mod chi_square;
#[path = "../support/gltf_file.rs"]
#[expect(dead_code, reason = "not every kind of accessor is used")]
mod gltf_file;
#[path = "../support/progressive.rs"]
mod progressive;
#[path = "../support/scene_files.rs"]
mod scene_files;
#[path = "../support/scene_text.rs"]
mod scene_text;

mod batches;
mod block_twin;
mod caustic_splitting;
mod formats;
mod gather_twin;
mod guided_emission;
mod irradiance_cache;
mod light_groups;
mod many_maps;
mod materials;
mod methods;
mod metropolis;
mod multiple_importance;
mod photon_chains;
mod photon_look_ups;
mod photon_map;
mod photon_map_direct;
mod photon_paths;
mod references;
mod visible_lights;
mod whole_paths;
