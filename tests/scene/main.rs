//! Scenes: what is read, what is refused, and why.

#[path = "../support/description_tree.rs"]
mod description_tree;
#[path = "../support/rendered.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod rendered;
#[path = "../support/scene_files.rs"]
mod scene_files;

mod bad_input;
mod curves;
mod errors;
mod import;
mod import_old;
mod mesh_attributes;
mod method_parameters;
mod native_form;
mod own_scenes;
mod serialized_meshes;
mod textures;
