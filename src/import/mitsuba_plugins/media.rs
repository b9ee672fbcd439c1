//! Participating media.

use super::{Class, Plugin, passed_over, refused, same};
use crate::scene::description::PluginClass;

pub(super) const MEDIA: Class = Class {
    class: PluginClass::Medium,
    title: "Participating media",
    parameters: &[],
    plugins: &[
        Plugin::same(
            "heterogeneous",
            &[
                same("sigma_t albedo scale"),
                passed_over("sample_emitters has_spectral_extinction", "they choose how Mitsuba samples"),
            ],
        ),
        Plugin::same(
            "homogeneous",
            &[
                same("sigma_t albedo scale"),
                passed_over("sample_emitters has_spectral_extinction", "they choose how Mitsuba samples"),
            ],
        ),
    ],
};

pub(super) const PHASES: Class = Class {
    class: PluginClass::Phase,
    title: "Phase functions",
    parameters: &[],
    plugins: &[
        Plugin::refused("blendphase"),
        Plugin::same("hg", &[same("g")]),
        Plugin::same("isotropic", &[]),
        Plugin::same("rayleigh", &[]),
        Plugin::refused("sggx"),
        Plugin::refused("tabphase"),
    ],
};

pub(super) const VOLUMES: Class = Class {
    class: PluginClass::Volume,
    title: "Volumes",
    parameters: &[],
    plugins: &[
        Plugin::same(
            "constvolume",
            &[same("value"), passed_over("to_world", "but for `sigma_t` of `heterogeneous`, whose box it places")],
        ),
        Plugin::same(
            "gridvolume",
            &[
                same("filename filter_type wrap_mode use_grid_bbox to_world"),
                passed_over("raw", "colors are linear Rec. 709"),
                passed_over("accel max_value", "they choose how Mitsuba samples"),
                refused("grid data", "a scene's volume is a file"),
            ],
        ),
    ],
};
