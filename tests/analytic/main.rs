//! What is computed is what closed forms say.

mod directional_area_lights;
mod film;
mod filters;
mod first_surface;
mod geometry;
mod instances;
mod media;
mod normal_maps;
mod parameterization;
mod sun_sky;
