//! The names of all plugins: which tag makes which class, and which class a dictionary's type belongs to.
//!
//! Names that photonfarm cannot render are listed too: whoever reads the plugin says so better than "unknown" would.

use crate::scene::description::PluginClass;

const CLASSES: [PluginClass; 13] = [
    PluginClass::Scene,
    PluginClass::Integrator,
    PluginClass::Sensor,
    PluginClass::Film,
    PluginClass::ReconstructionFilter,
    PluginClass::Sampler,
    PluginClass::Shape,
    PluginClass::Bsdf,
    PluginClass::Emitter,
    PluginClass::Texture,
    PluginClass::Medium,
    PluginClass::Phase,
    PluginClass::Volume,
];

/// The plugins of each class: Mitsuba 3's, and photonfarm's methods and materials.
const PLUGINS: [(PluginClass, &[&str]); 13] = [
    (PluginClass::Scene, &["scene"]),
    (
        PluginClass::Integrator,
        &[
            "aov",
            "bdpm",
            "bdpt",
            "depth",
            "direct",
            "direct_projective",
            "mmlt",
            "moment",
            "path",
            "pbdpm",
            "photon_map",
            "ppm",
            "prb",
            "prb_basic",
            "prb_projective",
            "prbvolpath",
            "ptracer",
            "sppm",
            "stokes",
            "vcm",
            "volpath",
            "volpathmis",
        ],
    ),
    (
        PluginClass::Sensor,
        &[
            "batch",
            "distant",
            "irradiancemeter",
            "orthographic",
            "perspective",
            "radiancemeter",
            "spherical",
            "thinlens",
        ],
    ),
    (PluginClass::Film, &["hdrfilm", "specfilm"]),
    (PluginClass::ReconstructionFilter, &["box", "catmullrom", "gaussian", "lanczos", "mitchell", "tent"]),
    (PluginClass::Sampler, &["independent", "ldsampler", "multijitter", "orthogonal", "stratified"]),
    (
        PluginClass::Shape,
        &[
            "bsplinecurve",
            "cube",
            "cylinder",
            "disk",
            "ellipsoids",
            "ellipsoidsmesh",
            "instance",
            "linearcurve",
            "merge",
            "obj",
            "ply",
            "rectangle",
            "sdfgrid",
            "serialized",
            "shapegroup",
            "sphere",
        ],
    ),
    (
        PluginClass::Bsdf,
        &[
            "blendbsdf",
            "bumpmap",
            "circular",
            "conductor",
            "dielectric",
            "difftrans",
            "diffuse",
            "hair",
            "mask",
            "measured",
            "measured_polarized",
            "normalmap",
            "null",
            "plastic",
            "polarizer",
            "pplastic",
            "principled",
            "principledthin",
            "retarder",
            "roughconductor",
            "roughdielectric",
            "roughplastic",
            "thindielectric",
            "twosided",
            "ward",
        ],
    ),
    (
        PluginClass::Emitter,
        &[
            "area",
            "constant",
            "directional",
            "directionalarea",
            "envmap",
            "ies",
            "point",
            "projector",
            "spot",
            "sunsky",
            "timed_sunsky",
        ],
    ),
    (PluginClass::Texture, &["bitmap", "checkerboard", "mesh_attribute", "rawconstant", "scale", "volume"]),
    (PluginClass::Medium, &["heterogeneous", "homogeneous"]),
    (PluginClass::Phase, &["blendphase", "hg", "isotropic", "rayleigh", "sggx", "tabphase"]),
    (PluginClass::Volume, &["constvolume", "gridvolume"]),
];

/// The tags of all classes.
pub(super) fn tags() -> impl Iterator<Item = &'static str> {
    CLASSES.into_iter().map(PluginClass::tag)
}

/// The class that is written with an XML tag.
pub(super) fn class_of_tag(tag: &str) -> Option<PluginClass> {
    CLASSES.into_iter().find(|class| class.tag() == tag)
}

/// The class that a plugin belongs to.
pub(super) fn class_of_plugin(plugin: &str) -> Option<PluginClass> {
    PLUGINS.iter().find(|(_, names)| names.contains(&plugin)).map(|(class, _)| *class)
}

/// All plugins that [`class_of_plugin`] knows.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    PLUGINS.iter().flat_map(|(_, names)| names.iter().copied())
}
