//! What is computed is what closed forms say.

#[path = "../support/rendered.rs"]
mod rendered;
#[path = "../support/scene_files.rs"]
mod scene_files;
#[path = "../support/scene_text.rs"]
mod scene_text;
#[path = "../support/shape_text.rs"]
mod shape_text;

mod directional_area_lights;
mod distant_sensor;
mod film;
mod filters;
mod first_surface;
mod geometry;
mod instances;
mod media;
mod normal_maps;
mod parameterization;
mod radiance_meter;
mod sun_sky;
mod timed_sun_sky;
