//! Shapes.

use super::{Class, Plugin, passed_over, same};
use crate::import::compatibility::Support;
use crate::scene::description::PluginClass;

pub(super) const SHAPES: Class = Class {
    class: PluginClass::Shape,
    title: "Shapes",
    parameters: &[passed_over("silhouette_sampling_weight", "it belongs to derivatives")],
    plugins: &[
        Plugin::new("blender", Support::Refused, "it is a mesh in the memory of Blender", &[]),
        Plugin::new("bsplinecurve", Support::Approximated, "tubes with 24 sides", &[same("to_world filename")]),
        Plugin::same("cube", &[same("to_world flip_normals"), passed_over("face_normals", "its faces are flat")]),
        Plugin::same("cylinder", &[same("to_world flip_normals p0 p1 radius")]),
        Plugin::same("disk", &[same("to_world flip_normals")]),
        Plugin::refused("ellipsoids"),
        Plugin::refused("ellipsoidsmesh"),
        Plugin::same("instance", &[same("to_world")]),
        Plugin::new("linearcurve", Support::Approximated, "tubes with 24 sides", &[same("to_world filename")]),
        Plugin::same("merge", &[]),
        Plugin::same("obj", &[same("to_world filename face_normals flip_normals flip_tex_coords")]),
        Plugin::same("ply", &[same("to_world filename face_normals flip_normals flip_tex_coords")]),
        Plugin::same("rectangle", &[same("to_world flip_normals"), passed_over("face_normals", "it is flat")]),
        Plugin::refused("sdfgrid"),
        Plugin::same("serialized", &[same("to_world filename shape_index face_normals flip_normals flip_tex_coords")]),
        Plugin::same("shapegroup", &[]),
        Plugin::same("sphere", &[same("to_world flip_normals center radius")]),
    ],
};
