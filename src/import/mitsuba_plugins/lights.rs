//! Emitters.

use super::{Class, Plugin, passed_over, refused, same};
use crate::import::compatibility::Support;
use crate::scene::description::PluginClass;

pub(super) const EMITTERS: Class = Class {
    class: PluginClass::Emitter,
    title: "Emitters",
    parameters: &[passed_over("sampling_weight", "lights are picked by their importance; 0 is refused")],
    plugins: &[
        Plugin::new(
            "area",
            Support::Same,
            "meshes with smooth normals shine where their triangles face, in Mitsuba where the normals do",
            &[same("radiance")],
        ),
        Plugin::same("constant", &[same("radiance"), passed_over("to_world", "it is the same in all directions")]),
        Plugin::same("directional", &[same("irradiance direction to_world")]),
        Plugin::new(
            "directionalarea",
            Support::Approximated,
            "only flat shapes; every method shows its light, of which Mitsuba's `path` shows none",
            &[same("radiance")],
        ),
        Plugin::same(
            "envmap",
            &[
                same("filename scale to_world"),
                passed_over("mis_compensation", "it changes noise alone"),
                refused("bitmap", "it is an object of a program"),
            ],
        ),
        Plugin::same("point", &[same("intensity position to_world")]),
        Plugin::same("projector", &[same("irradiance scale to_world fov fov_axis focal_length")]),
        Plugin::same("spot", &[same("intensity cutoff_angle beam_width texture to_world")]),
        Plugin::same(
            "sunsky",
            &[
                same("turbidity albedo sun_direction sun_scale sky_scale sun_aperture to_world"),
                same("latitude longitude timezone year month day hour minute second"),
                refused("complex_sun", "the sun is as bright at its rim as in its middle"),
            ],
        ),
        Plugin::new(
            "timed_sunsky",
            Support::Approximated,
            "the average over its instants as a map of 2048 columns; Mitsuba 3.9.1 shows the sun's radiance from all directions",
            &[
                same("turbidity albedo sun_scale sky_scale sun_aperture to_world"),
                same("latitude longitude timezone start_year start_month start_day end_year end_month end_day"),
                same("window_start_time window_end_time shutter_open shutter_close"),
                refused("complex_sun", "the sun is as bright at its rim as in its middle"),
            ],
        ),
    ],
};
