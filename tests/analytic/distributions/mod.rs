//! Samples are distributed as their densities say.

mod distant_lights;
mod emission_guide;
mod light_images;
mod luminaires;
mod materials;
mod sampling;
