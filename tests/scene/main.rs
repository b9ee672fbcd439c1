//! Scenes: what is read, what is refused, and why.

mod bad_input;
mod curves;
mod errors;
mod import;
mod import_old;
mod mesh_attributes;
mod native_form;
mod own_scenes;
mod serialized_meshes;
mod textures;
