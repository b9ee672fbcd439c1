//! Samples are distributed as their densities say.

#[path = "../support/chi_square.rs"]
mod chi_square;
#[path = "../support/scene_files.rs"]
mod scene_files;
#[path = "../support/scene_text.rs"]
mod scene_text;

mod distant_lights;
mod emission_guide;
mod light_images;
mod luminaires;
mod materials;
mod sampling;
