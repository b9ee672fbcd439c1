//! Scenes: their formats, what they mean, and what is refused.

#[path = "../support/chi_square.rs"]
#[expect(dead_code, reason = "only its numbers are used here")]
mod chi_square;
#[path = "../support/description_tree.rs"]
mod description_tree;
#[path = "../support/gltf_file.rs"]
mod gltf_file;
#[path = "../support/mitsuba_scenes.rs"]
mod mitsuba_scenes;
#[path = "../support/progressive.rs"]
mod progressive;
#[path = "../support/rendered.rs"]
mod rendered;
#[path = "../support/scene_files.rs"]
mod scene_files;
#[path = "../support/scene_text.rs"]
mod scene_text;
#[path = "../support/shape_text.rs"]
mod shape_text;

mod bad_input;
mod big_meshes;
mod curves;
mod errors;
mod import;
mod light_groups;
mod mesh_attributes;
mod method_parameters;
mod names;
mod native_form;
mod own_scenes;
mod serialized_meshes;
mod textures;
