//! What is computed is what closed forms say, and samples are distributed as their densities say.

#[path = "../support/chi_square.rs"]
mod chi_square;
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

mod directional_area_lights;
mod distant_sensor;
mod distributions;
mod energy_balance;
mod film;
mod filters;
mod first_surface;
mod furnace;
mod geometry;
mod instances;
mod light_choice;
mod mattes;
mod media;
mod normal_maps;
mod parameterization;
mod radiance_meter;
mod random_spectra;
mod sun_sky;
mod timed_sun_sky;
