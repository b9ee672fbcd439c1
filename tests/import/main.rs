//! Files of other programs become the scenes that they mean.

#[path = "../support/chi_square.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod chi_square;
#[path = "../support/gltf_file.rs"]
mod gltf_file;

mod batches;
mod byte_order_marks;
mod cases_of_formats;
mod ceng795;
mod gltf;
mod gltf_errors;
mod messages;
mod mgf;
mod mitsuba_cases;
mod mitsuba_plugins;
mod motion;
mod pbrt;
mod small_scenes;
