//! Files of other programs become the scenes that they mean.

mod batches;
mod byte_order_marks;
mod cases_of_formats;
mod ceng795;
mod gltf;
mod gltf_errors;
mod messages;
mod mgf;
mod mitsuba;
mod mitsuba_cases;
mod mitsuba_old;
mod mitsuba_plugins;
mod motion;
mod pbrt;
mod small_scenes;
