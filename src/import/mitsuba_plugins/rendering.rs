//! Sensors, films, filters, samplers and integrators.

use super::{Class, Parameters, Plugin, approximated, passed_over, refused, same};
use crate::import::compatibility::Support;
use crate::scene::description::PluginClass;

const CLIP: Parameters = same("near_clip far_clip");
const DEPTHS: Parameters = same("max_depth rr_depth");

pub(super) const SENSORS: Class = Class {
    class: PluginClass::Sensor,
    title: "Sensors",
    parameters: &[
        passed_over("shutter_open shutter_close", "nothing moves; a `timed_sunsky` asks for them"),
        refused("srf", "pictures are RGB"),
    ],
    plugins: &[
        Plugin::new(
            "batch",
            Support::Approximated,
            "each of its sensors is a camera by itself (`--camera`), as wide as its part of the film",
            &[passed_over("to_world", "its sensors have their own")],
        ),
        Plugin::new(
            "distant",
            Support::Same,
            "a shape as `target` is refused; a point is a disc of 10⁻⁵ of the scene's radius",
            &[same("to_world direction target")],
        ),
        Plugin::refused("irradiancemeter"),
        Plugin::same("orthographic", &[same("to_world"), CLIP, passed_over("focus_distance", "all depths are sharp")]),
        Plugin::same(
            "perspective",
            &[
                same("to_world fov fov_axis focal_length principal_point_offset_x principal_point_offset_y"),
                CLIP,
                passed_over("focus_distance", "all depths are sharp"),
            ],
        ),
        Plugin::new("radiancemeter", Support::Approximated, "a pixel 0.01° wide", &[same("to_world origin direction")]),
        Plugin::same("thinlens", &[same("to_world fov fov_axis focal_length aperture_radius focus_distance"), CLIP]),
    ],
};

pub(super) const FILMS: Class = Class {
    class: PluginClass::Film,
    title: "Films",
    parameters: &[],
    plugins: &[
        Plugin::same(
            "hdrfilm",
            &[
                same("width height crop_offset_x crop_offset_y crop_width crop_height sample_border"),
                passed_over("pixel_format component_format file_format", "files are RGB of 32 bits"),
                passed_over("banner compensate", "they change no pixel"),
            ],
        ),
        Plugin::refused("specfilm"),
    ],
};

pub(super) const FILTERS: Class = Class {
    class: PluginClass::ReconstructionFilter,
    title: "Reconstruction filters",
    parameters: &[],
    plugins: &[
        Plugin::same("box", &[]),
        Plugin::same("catmullrom", &[]),
        Plugin::same("gaussian", &[same("stddev")]),
        Plugin::same("lanczos", &[same("lobes")]),
        Plugin::same("mitchell", &[same("B C")]),
        Plugin::same("tent", &[same("radius")]),
    ],
};

/// Random numbers are our own, and `passes` says how many there are.
const fn sampler(name: &'static str, parameters: &'static [Parameters]) -> Plugin {
    Plugin::new(name, Support::PassedOver, "", parameters)
}

pub(super) const SAMPLERS: Class = Class {
    class: PluginClass::Sampler,
    title: "Samplers",
    parameters: &[passed_over("sample_count seed", "passes and seeds belong to a job")],
    plugins: &[
        sampler("independent", &[]),
        sampler("ldsampler", &[]),
        sampler("multijitter", &[passed_over("jitter", "")]),
        sampler("orthogonal", &[passed_over("jitter strength", "")]),
        sampler("stratified", &[passed_over("jitter", "")]),
    ],
};

const LIMITED: &str = "`path` of at most 6 segments, unless `max_depth` is given";
const INSIDE: &str = "the picture is that of the integrator inside";

pub(super) const INTEGRATORS: Class = Class {
    class: PluginClass::Integrator,
    title: "Integrators",
    parameters: &[
        same("hide_emitters"),
        passed_over("block_size samples_per_pass timeout", "they choose how Mitsuba works"),
    ],
    plugins: &[
        Plugin::new("aov", Support::PassedOver, INSIDE, &[passed_over("aovs", "photonfarm has layers of its own")]),
        Plugin::new("depth", Support::Refused, "it shows no light", &[]),
        Plugin::new(
            "direct",
            Support::Same,
            "`path` of two segments",
            &[approximated(
                "emitter_samples bsdf_samples shading_samples",
                "0 leaves that kind of sampling out; other counts change noise alone",
            )],
        ),
        Plugin::refused("direct_projective"),
        Plugin::new("moment", Support::PassedOver, INSIDE, &[]),
        Plugin::same("path", &[DEPTHS]),
        Plugin::new("prb", Support::Same, LIMITED, &[DEPTHS]),
        Plugin::new("prb_basic", Support::Same, LIMITED, &[DEPTHS]),
        Plugin::refused("prb_projective"),
        Plugin::new("prbvolpath", Support::Same, LIMITED, &[DEPTHS]),
        Plugin::new("ptracer", Support::Same, "`light_tracing`", &[DEPTHS]),
        Plugin::new("stokes", Support::PassedOver, INSIDE, &[]),
        Plugin::new("volpath", Support::Same, "`path`", &[DEPTHS]),
        Plugin::new("volpathmis", Support::Same, "`path`", &[DEPTHS]),
    ],
};
