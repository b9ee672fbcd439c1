//! What a scene contains that costs a renderer something: told by `plan`, so that people see what they pay for.

use super::Scene;
use super::light::Light;
use super::material::Lobes;

/// What a scene contains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneNeeds {
    /// Triangles and other primitives, those of instances counted once.
    pub primitives: usize,
    /// Lights.
    pub lights: usize,
    /// Features that rendering it needs.
    pub used: Vec<&'static str>,
    /// Features that it does not need.
    pub unused: Vec<&'static str>,
}

/// A feature and whether a scene needs it.
type Feature = (&'static str, fn(&Scene) -> bool);

const FEATURES: &[Feature] = &[
    ("a choice among lights", |scene| scene.lights.lights().len() > 1),
    ("lights without extent", |scene| scene.lights.has_points()),
    ("light from outside", |scene| scene.lights.lights().iter().any(Light::is_distant)),
    ("mirrors or glass", |scene| scene.lobes().any(Lobes::SPECULAR)),
    ("narrow lobes", |scene| scene.lobes().any(Lobes::NARROW)),
    ("light through surfaces", |scene| scene.lobes().any(Lobes::TRANSMISSIVE)),
    ("texture coordinates", |scene| scene.geometry.needs_coordinates()),
    ("bump and normal maps", |scene| scene.turns_normals),
    ("participating media", |scene| !scene.media.is_empty()),
    ("instances", |scene| scene.geometry.has_instances()),
    ("a lens", |scene| scene.camera.has_lens()),
];

impl Scene {
    /// What it contains.
    pub fn needs(&self) -> SceneNeeds {
        let (used, unused): (Vec<&Feature>, Vec<&Feature>) = FEATURES.iter().partition(|(_, needs)| needs(self));
        let names = |features: Vec<&Feature>| features.into_iter().map(|(name, _)| *name).collect();
        SceneNeeds {
            primitives: self.geometry.primitive_count(),
            lights: self.lights.lights().len(),
            used: names(used),
            unused: names(unused),
        }
    }
}
