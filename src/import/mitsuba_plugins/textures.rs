//! Textures and spectra.

use super::{Class, Plugin, passed_over, refused, same};
use crate::import::compatibility::Support;
use crate::scene::description::PluginClass;

pub(super) const TEXTURES: Class = Class {
    class: PluginClass::Texture,
    title: "Textures",
    parameters: &[],
    plugins: &[
        Plugin::same(
            "bitmap",
            &[
                same("filename filter_type wrap_mode raw to_uv"),
                passed_over("format accel", "they choose how texels are stored"),
                refused("bitmap data", "they are objects of a program"),
            ],
        ),
        Plugin::same("checkerboard", &[same("color0 color1 to_uv")]),
        Plugin::new("mesh_attribute", Support::Same, "not beside a `bumpmap`", &[same("name scale")]),
        Plugin::same("rawconstant", &[same("value")]),
        Plugin::refused("volume"),
    ],
};

pub(super) const SPECTRA: Class = Class {
    class: PluginClass::Texture,
    title: "Spectra",
    parameters: &[],
    plugins: &[
        Plugin::new(
            "blackbody",
            Support::Approximated,
            "the color that Mitsuba's spectral modes show; its RGB mode refuses it",
            &[same("temperature wavelength_min wavelength_max")],
        ),
        Plugin::same("d65", &[same("color scale")]),
        Plugin::new(
            "irregular",
            Support::Approximated,
            "the color that Mitsuba's spectral modes show; its RGB mode refuses it",
            &[same("wavelengths values")],
        ),
        Plugin::new(
            "regular",
            Support::Approximated,
            "the color that Mitsuba's spectral modes show; its RGB mode refuses it",
            &[same("wavelength_min wavelength_max values")],
        ),
        Plugin::same("srgb", &[same("color"), passed_over("unbounded", "colors are taken as they are")]),
        Plugin::same("uniform", &[same("value"), passed_over("wavelength_min wavelength_max", "it stays grey")]),
    ],
};
