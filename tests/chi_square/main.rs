//! Samples are distributed as their densities say.

mod distant_lights;
mod light_images;
mod luminaires;
mod materials;
mod sampling;
