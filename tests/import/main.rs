//! Files of other programs become the scenes that they mean.

mod cases_of_formats;
mod ceng795;
mod gltf;
mod gltf_errors;
mod mgf;
mod mitsuba_cases;
mod mitsuba_plugins;
mod mitsuba_scenes;
mod pbrt;
