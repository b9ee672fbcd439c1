//! Materials.

use super::{Class, Parameters, Plugin, passed_over, refused, same};
use crate::import::compatibility::Support;
use crate::scene::description::PluginClass;

const SAMPLE_VISIBLE: Parameters = passed_over("sample_visible", "it changes noise alone");
const CORRECTIONS: Parameters = same("flip_invalid_normals use_shadowing_function");

pub(super) const BSDFS: Class = Class {
    class: PluginClass::Bsdf,
    title: "Materials",
    parameters: &[],
    plugins: &[
        Plugin::new(
            "blendbsdf",
            Support::Same,
            "perfect mirrors and glass in it keep all of their light, of which Mitsuba 3.9.1 loses some",
            &[same("weight")],
        ),
        Plugin::same("bumpmap", &[same("scale"), CORRECTIONS]),
        Plugin::refused("circular"),
        Plugin::same("conductor", &[same("material eta k specular_reflectance")]),
        Plugin::same("dielectric", &[same("int_ior ext_ior specular_reflectance specular_transmittance")]),
        Plugin::same("diffuse", &[same("reflectance")]),
        Plugin::refused("hair"),
        Plugin::same("mask", &[same("opacity")]),
        Plugin::refused("measured"),
        Plugin::refused("measured_polarized"),
        Plugin::same("normalmap", &[CORRECTIONS]),
        Plugin::same("null", &[]),
        Plugin::same("plastic", &[same("int_ior ext_ior nonlinear diffuse_reflectance specular_reflectance")]),
        Plugin::refused("polarizer"),
        Plugin::refused("pplastic"),
        Plugin::same(
            "principled",
            &[
                same("base_color roughness anisotropic metallic spec_trans eta specular spec_tint sheen sheen_tint"),
                same("flatness clearcoat clearcoat_gloss"),
                passed_over(
                    "diffuse_reflectance_sampling_rate main_specular_sampling_rate clearcoat_sampling_rate",
                    "they change noise alone",
                ),
            ],
        ),
        Plugin::same(
            "principledthin",
            &[
                same("base_color roughness anisotropic spec_trans eta spec_tint sheen sheen_tint flatness diff_trans"),
                passed_over(
                    "diffuse_reflectance_sampling_rate specular_reflectance_sampling_rate",
                    "they change noise alone",
                ),
                passed_over(
                    "specular_transmittance_sampling_rate diffuse_transmittance_sampling_rate",
                    "they change noise alone",
                ),
            ],
        ),
        Plugin::refused("retarder"),
        Plugin::same(
            "roughconductor",
            &[same("material eta k specular_reflectance distribution alpha alpha_u alpha_v"), SAMPLE_VISIBLE],
        ),
        Plugin::same(
            "roughdielectric",
            &[
                same("int_ior ext_ior specular_reflectance specular_transmittance distribution alpha alpha_u alpha_v"),
                SAMPLE_VISIBLE,
            ],
        ),
        Plugin::same(
            "roughplastic",
            &[
                same("int_ior ext_ior nonlinear diffuse_reflectance specular_reflectance distribution alpha"),
                SAMPLE_VISIBLE,
                refused("alpha_u alpha_v", "Mitsuba refuses them too"),
            ],
        ),
        Plugin::same("thindielectric", &[same("int_ior ext_ior specular_reflectance specular_transmittance")]),
        Plugin::same("twosided", &[]),
    ],
};
