//! The plugins of Mitsuba 0.6, what Mitsuba 3 calls them, and which of their parameters mean the same.

use super::super::draft::Draft;
use super::cameras_and_methods as camera;
use super::light_and_shape as light;
use super::materials as material;
use super::{Outcome, Translation};
use super::{media, textures as texture};
use crate::scene::description::PluginClass::{
    self, Bsdf, Emitter, Film, Integrator, Medium, Phase, ReconstructionFilter, Sampler, Sensor, Shape, Texture, Volume,
};
use crate::scene::error::SceneError;

/// What a rule's parameters alone cannot say; runs when those, and the plugins inside, have their new names.
type Change = fn(Draft, &mut Translation) -> Result<Outcome, SceneError>;

/// How one plugin is translated.
pub(super) struct Rule {
    pub class: PluginClass,
    pub old: &'static str,
    pub new: &'static str,
    /// Parameters and slots that mean the same under their new names.
    kept: &'static [&'static str],
    /// Parameters that `change` reads by their old names.
    used: &'static [&'static str],
    pub change: Change,
}

impl Rule {
    pub(super) fn keeps(&self, name: &str) -> bool {
        self.kept.contains(&name) || of_class(self.class).0.contains(&name)
    }

    pub(super) fn uses(&self, name: &str) -> bool {
        self.used.contains(&name)
    }

    /// Whether the parameter never changes a picture here.
    pub(super) fn passes_over(&self, name: &str) -> bool {
        of_class(self.class).1.contains(&name)
    }

    /// All parameters that the rule knows.
    pub(super) fn parameters(&self) -> impl Iterator<Item = &'static str> {
        let (kept, passed_over) = of_class(self.class);
        [self.kept, self.used, kept, passed_over].into_iter().flatten().copied()
    }
}

/// Parameters of every plugin of a class: those that are kept, and those that never change a picture here, since they
/// choose how Mitsuba spends its time and memory or how it encodes files.
fn of_class(class: PluginClass) -> (&'static [&'static str], &'static [&'static str]) {
    match class {
        Shape => (&["toWorld", "flipNormals"], &["collapse"]),
        Bsdf => (&[], &["ensureEnergyConservation"]),
        Emitter => (&["toWorld"], &["samplingWeight", "cache", "resolution"]),
        Sensor => (&["toWorld", "nearClip", "farClip", "focusDistance", "shutterOpen", "shutterClose"], &[]),
        Film => (
            &["width", "height", "cropOffsetX", "cropOffsetY", "cropWidth", "cropHeight", "highQualityEdges"],
            &["banner", "attachLog", "fileFormat", "pixelFormat", "digits", "variable"],
        ),
        Sampler => (&["sampleCount"], &["dimension", "scramble"]),
        Texture => (&[], &["maxAnisotropy", "cache"]),
        Integrator => {
            (&[], &["granularity", "autoCancelGathering", "lightImage", "sampleDirect", "showWeighted", "bruteForce"])
        }
        _ => (&[], &[]),
    }
}

/// The new name of a parameter: words joined by `_`, apart from those that have another name altogether.
pub(super) fn new_name(old: &str) -> String {
    const OTHERS: [(&str, &str); 5] = [
        ("photonCount", "photons_per_pass"),
        ("maxPasses", "passes"),
        ("highQualityEdges", "sample_border"),
        ("B", "B"),
        ("C", "C"),
    ];
    if let Some((_, new)) = OTHERS.iter().find(|(known, _)| *known == old) {
        return (*new).to_owned();
    }
    let mut new = String::with_capacity(old.len() + 4);
    let mut after_small = false;
    for letter in old.chars() {
        if letter.is_ascii_uppercase() && after_small {
            new.push('_');
        }
        after_small = letter.is_ascii_lowercase();
        new.push(letter.to_ascii_lowercase());
    }
    new
}

/// A plugin of which nothing but names changed.
fn same(draft: Draft, _: &mut Translation) -> Result<Outcome, SceneError> {
    Ok(Outcome::Plugin(draft))
}

const fn plain(class: PluginClass, name: &'static str, kept: &'static [&'static str]) -> Rule {
    Rule { class, old: name, new: name, kept, used: &[], change: same }
}

const fn changed(
    class: PluginClass,
    names: [&'static str; 2],
    kept: &'static [&'static str],
    used: &'static [&'static str],
    change: Change,
) -> Rule {
    Rule { class, old: names[0], new: names[1], kept, used, change }
}

const SMOOTH: &[&str] = &["intIOR", "extIOR", "specularReflectance", "specularTransmittance"];
const ROUGH: &[&str] = &[
    "intIOR",
    "extIOR",
    "specularReflectance",
    "specularTransmittance",
    "alpha",
    "alphaU",
    "alphaV",
    "distribution",
    "sampleVisible",
];
const PLASTIC: &[&str] = &["intIOR", "extIOR", "specularReflectance", "diffuseReflectance", "nonlinear"];
const ROUGH_PLASTIC: &[&str] = &[
    "intIOR",
    "extIOR",
    "specularReflectance",
    "diffuseReflectance",
    "nonlinear",
    "alpha",
    "distribution",
    "sampleVisible",
];
const METAL: &[&str] = &["material", "eta", "k", "specularReflectance"];
const ROUGH_METAL: &[&str] =
    &["material", "eta", "k", "specularReflectance", "alpha", "alphaU", "alphaV", "distribution", "sampleVisible"];
const COAT: &[&str] =
    &["intIOR", "extIOR", "specularReflectance", "sigmaA", "thickness", "alpha", "distribution", "sampleVisible"];
const LDR: &[&str] = &["tonemapMethod", "gamma", "exposure", "key", "burn"];
const DEPTHS: &[&str] = &["maxDepth", "rrDepth"];
const PATH: &[&str] = &["maxDepth", "rrDepth", "hideEmitters"];
const PHOTONS: &[&str] = &["maxDepth", "rrDepth", "photonCount", "alpha", "maxPasses"];
const MEASURES: &[&str] = &["fov", "fovAxis", "focalLength"];
const SUN: &[&str] = &[
    "turbidity",
    "albedo",
    "sunDirection",
    "sunScale",
    "skyScale",
    "year",
    "month",
    "day",
    "hour",
    "minute",
    "second",
    "latitude",
    "longitude",
    "timezone",
];

/// Every plugin of Mitsuba 0.6 that a scene may hold.
#[rustfmt::skip] // one plugin per line
pub(super) const RULES: &[Rule] = &[
    plain(Bsdf, "blendbsdf", &["weight"]),
    changed(Bsdf, ["bumpmap", "bumpmap"], &[], &[], material::bump),
    changed(Bsdf, ["coating", "plastic"], &[], COAT, material::coating),
    changed(Bsdf, ["conductor", "conductor"], METAL, &["extEta"], material::conductor),
    plain(Bsdf, "dielectric", SMOOTH),
    plain(Bsdf, "difftrans", &["transmittance"]),
    changed(Bsdf, ["diffuse", "diffuse"], &["reflectance"], &["diffuseReflectance"], material::diffuse),
    changed(Bsdf, ["hk", "diffuse"], &[], &[], material::stand_in),
    changed(Bsdf, ["irawan", "diffuse"], &[], &["filename"], material::stand_in),
    plain(Bsdf, "mask", &["opacity"]),
    changed(Bsdf, ["mixturebsdf", "blendbsdf"], &[], &["weights"], material::mixture),
    changed(Bsdf, ["normalmap", "normalmap"], &[], &[], material::normal_map),
    plain(Bsdf, "null", &[]),
    changed(Bsdf, ["phong", "ward"], &["diffuseReflectance", "specularReflectance"], &["exponent"], material::phong),
    plain(Bsdf, "plastic", PLASTIC),
    changed(Bsdf, ["roughcoating", "roughplastic"], &[], COAT, material::coating),
    changed(Bsdf, ["roughconductor", "roughconductor"], ROUGH_METAL, &["extEta"], material::conductor),
    changed(Bsdf, ["roughdielectric", "roughdielectric"], ROUGH, &[], material::rough),
    changed(Bsdf, ["roughdiffuse", "diffuse"], &["reflectance"], &["diffuseReflectance", "alpha", "useFastApprox"], material::rough_diffuse),
    changed(Bsdf, ["roughplastic", "roughplastic"], ROUGH_PLASTIC, &[], material::rough),
    plain(Bsdf, "thindielectric", SMOOTH),
    plain(Bsdf, "twosided", &[]),
    plain(Bsdf, "ward", &["diffuseReflectance", "specularReflectance", "alpha", "alphaU", "alphaV", "variant"]),

    changed(Shape, ["cube", "cube"], &[], &[], light::shape),
    changed(Shape, ["cylinder", "cylinder"], &["p0", "p1", "radius"], &[], light::shape),
    changed(Shape, ["deformable", ""], &[], &["filename"], light::without_counterpart),
    changed(Shape, ["disk", "disk"], &[], &[], light::shape),
    changed(Shape, ["hair", ""], &[], &["filename"], light::without_counterpart),
    changed(Shape, ["heightfield", ""], &[], &["filename"], light::without_counterpart),
    plain(Shape, "instance", &[]),
    changed(Shape, ["obj", "obj"], &["filename", "faceNormals", "flipTexCoords", "material"], &[], light::shape),
    changed(Shape, ["ply", "ply"], &["filename", "faceNormals"], &[], light::shape),
    changed(Shape, ["rectangle", "rectangle"], &[], &[], light::shape),
    changed(Shape, ["serialized", "serialized"], &["filename", "shapeIndex", "faceNormals"], &[], light::shape),
    plain(Shape, "shapegroup", &[]),
    changed(Shape, ["sphere", "sphere"], &["center", "radius"], &[], light::shape),

    plain(Emitter, "area", &["radiance"]),
    changed(Emitter, ["collimated", ""], &[], &["power"], light::without_counterpart),
    plain(Emitter, "constant", &["radiance"]),
    plain(Emitter, "directional", &["irradiance", "direction"]),
    plain(Emitter, "envmap", &["filename", "scale"]),
    plain(Emitter, "point", &["intensity", "position"]),
    changed(Emitter, ["sky", "sunsky"], SUN, &[], light::sky),
    plain(Emitter, "spot", &["intensity", "cutoffAngle", "beamWidth", "texture"]),
    changed(Emitter, ["sun", "sunsky"], SUN, &[], light::sun),
    changed(Emitter, ["sunsky", "sunsky"], SUN, &[], light::sun_sky),

    changed(Texture, ["bitmap", "bitmap"], &["filename"], texture::BITMAP, texture::bitmap),
    changed(Texture, ["checkerboard", "checkerboard"], &["color0", "color1"], texture::UV, texture::checkerboard),
    changed(Texture, ["curvature", ""], &[], &["scale", "curvature"], texture::grey),
    changed(Texture, ["gridtexture", ""], &[], &["color0", "color1", "lineWidth"], texture::grid),
    plain(Texture, "scale", &["scale", "value"]),
    changed(Texture, ["vertexcolors", "mesh_attribute"], &[], &[], texture::vertex_colors),
    changed(Texture, ["wireframe", ""], &[], &["interiorColor", "edgeColor", "lineWidth", "stepWidth"], texture::wireframe),

    plain(Film, "hdrfilm", &["fileFormat", "pixelFormat", "componentFormat"]),
    changed(Film, ["ldrfilm", "hdrfilm"], &[], LDR, camera::tone_mapped_film),
    changed(Film, ["mfilm", "hdrfilm"], &[], &[], same),
    changed(Film, ["tiledhdrfilm", "hdrfilm"], &["pixelFormat", "componentFormat"], &[], same),

    plain(ReconstructionFilter, "box", &["radius"]),
    plain(ReconstructionFilter, "catmullrom", &[]),
    plain(ReconstructionFilter, "gaussian", &["stddev"]),
    plain(ReconstructionFilter, "lanczos", &["lobes"]),
    plain(ReconstructionFilter, "mitchell", &["B", "C"]),
    plain(ReconstructionFilter, "tent", &["radius"]),

    changed(Sampler, ["halton", "independent"], &[], &[], same),
    changed(Sampler, ["hammersley", "independent"], &[], &[], same),
    plain(Sampler, "independent", &[]),
    plain(Sampler, "ldsampler", &[]),
    changed(Sampler, ["sobol", "independent"], &[], &[], same),
    plain(Sampler, "stratified", &[]),

    plain(Sensor, "fluencemeter", &[]),
    plain(Sensor, "irradiancemeter", &[]),
    plain(Sensor, "orthographic", &[]),
    plain(Sensor, "perspective", MEASURES),
    plain(Sensor, "radiancemeter", &[]),
    plain(Sensor, "spherical", &[]),
    plain(Sensor, "telecentric", &["apertureRadius"]),
    plain(Sensor, "thinlens", &["fov", "fovAxis", "focalLength", "apertureRadius"]),
    changed(Sensor, ["perspective_rdist", "perspective"], MEASURES, &["kc"], camera::without_distortion),

    changed(Integrator, ["adaptive", ""], &[], &["maxError", "maxSampleFactor", "pValue", "verbose"], camera::inner_method),
    changed(Integrator, ["ao", ""], &[], &["shadingSamples", "rayLength"], camera::no_method),
    plain(Integrator, "bdpt", DEPTHS),
    changed(Integrator, ["bre", ""], &[], DEPTHS, camera::no_method),
    plain(Integrator, "direct", &["shadingSamples", "emitterSamples", "bsdfSamples", "hideEmitters"]),
    changed(Integrator, ["erpt", "bdpt"], DEPTHS, &[], camera::other_method),
    changed(Integrator, ["field", ""], &[], &["field", "undefined"], camera::no_method),
    changed(Integrator, ["irrcache", ""], &[], &[], camera::inner_method),
    changed(Integrator, ["mlt", "bdpt"], DEPTHS, &[], camera::other_method),
    changed(Integrator, ["motion", ""], &[], &[], camera::no_method),
    changed(Integrator, ["multichannel", ""], &[], &[], camera::no_method),
    plain(Integrator, "path", PATH),
    changed(Integrator, ["photonmapper", "photon_map"], DEPTHS, &[], same),
    changed(Integrator, ["ppm", "ppm"], PHOTONS, &["initialRadius"], camera::photons),
    changed(Integrator, ["pssmlt", "bdpt"], DEPTHS, &[], camera::other_method),
    plain(Integrator, "ptracer", DEPTHS),
    changed(Integrator, ["sppm", "sppm"], PHOTONS, &["initialRadius"], camera::photons),
    plain(Integrator, "vcm", &["maxDepth", "rrDepth", "initialRadius", "alpha"]),
    plain(Integrator, "volpath", PATH),
    changed(Integrator, ["volpath_simple", "volpath"], PATH, &[], same),
    changed(Integrator, ["vpl", "path"], DEPTHS, &["shadowMapResolution", "clamping"], camera::other_method),

    changed(Medium, ["heterogeneous", "heterogeneous"], &["scale"], &["density", "method"], media::heterogeneous),
    changed(Medium, ["homogeneous", "homogeneous"], &["sigmaT", "albedo", "scale"], &["sigmaA", "sigmaS", "material"], media::homogeneous),
    plain(Phase, "hg", &["g"]),
    plain(Phase, "isotropic", &[]),
    changed(Phase, ["kkay", "isotropic"], &[], &["ks", "kd", "exponent"], media::phase),
    changed(Phase, ["microflake", "isotropic"], &[], &["stddev"], media::phase),
    changed(Phase, ["mixturephase", "isotropic"], &[], &["weights"], media::phase),
    plain(Phase, "rayleigh", &[]),
    plain(Volume, "constvolume", &["value"]),
    changed(Volume, ["gridvolume", "gridvolume"], &["filename", "toWorld"], &["sendData"], media::grid),
    changed(Volume, ["hgridvolume", ""], &[], &["filename", "prefix", "postfix"], media::without_counterpart),
    changed(Volume, ["volcache", ""], &[], &["blockSize", "voxelWidth", "memoryLimit"], media::cached),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_joined_by_underscores() {
        let names = ["toWorld", "intIOR", "specularReflectance", "alphaU", "p0", "rrDepth", "cropOffsetX", "color0"];
        let new = names.map(new_name);
        let expected =
            ["to_world", "int_ior", "specular_reflectance", "alpha_u", "p0", "rr_depth", "crop_offset_x", "color0"];
        assert_eq!(new, expected);
    }

    #[test]
    fn every_plugin_has_one_rule() {
        for (index, rule) in RULES.iter().enumerate() {
            let twice = RULES[..index].iter().any(|other| (other.class, other.old) == (rule.class, rule.old));
            assert!(!twice, "{} has two rules", rule.old);
        }
    }
}
