//! `roughconductor`: a metal with a rough surface; one-sided, black from behind.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `material` | a measured metal by name, or `none` for a perfect mirror | see `measured_metals` | `none` |
//! | `eta`, `k` | real and imaginary index of refraction instead of `material` | ≥ 0 | – |
//! | `distribution`, `alpha`, `alpha_u`, `alpha_v`, `sample_visible` | roughness | see `microfacet` | `beckmann`, 0.1 |
//! | `specular_reflectance` | factor on the reflection | 0 to 1 | 1 |
//!
//! f = F·D·G/(4·cos θo·cos θi) [Walter et al. 2007, eq. 20], sampled by visible normals. Light that would bounce between
//! microfacets is lost: at α = 1 about half.

use super::microfacet::{self, Roughness};
use super::{Lobes, MaterialSample, SpecularLobes, View, conductor, fresnel};
use crate::math::{Rgb, Vec3};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A rough metal.
#[derive(Clone, Debug)]
pub struct RoughConductor {
    /// Real and imaginary index; `None` reflects everything.
    index: Option<(Rgb, Rgb)>,
    roughness: Roughness,
    specular_reflectance: Texture,
}

impl RoughConductor {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            index: conductor::read_index(fields)?,
            roughness: Roughness::read(fields, textures, true)?,
            specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)?,
        })
    }

    fn sees(&self, view: &View) -> bool {
        view.outgoing.z > 0.0 && view.lobes.any(self.roughness.lobes())
    }

    /// Mirrors at a visible normal.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if !self.sees(view) {
            return None;
        }
        let normal = self.roughness.at(&view.point).visible_normal(view.outgoing, [u[0], u[1]]);
        let direction = microfacet::reflect(view.outgoing, normal);
        MaterialSample::weighted(direction, self.respond(view, direction), 1.0)
    }

    /// The BSDF and the density.
    fn respond(&self, view: &View, incident: Vec3) -> (Rgb, f32) {
        if !self.sees(view) || incident.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let half = (view.outgoing + incident).normalize();
        let (value, pdf) = microfacet::reflection(&self.roughness.at(&view.point), view.outgoing, incident, half);
        let reflected = match self.index {
            Some((eta, k)) => fresnel::conductor(view.outgoing.dot(half).min(1.0), eta, k),
            None => Rgb::ONE,
        };
        (reflected * self.specular_reflectance.color(&view.point) * value, pdf)
    }

    /// F·D·G/(4·cos θo·cos θi) above the surface.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        self.respond(view, incident).0
    }

    /// That of mirroring at visible normals.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        self.respond(view, incident).1
    }

    /// One lobe, wide or narrow.
    pub fn lobes(&self) -> Lobes {
        self.roughness.lobes()
    }

    /// 1 for a narrow lobe, 0 for a wide one.
    pub fn followed_share(&self, _view: &View) -> f32 {
        if self.lobes().any(Lobes::FOLLOWED) { 1.0 } else { 0.0 }
    }

    /// None.
    pub fn specular_lobes(&self, _view: &View) -> SpecularLobes {
        SpecularLobes::default()
    }

    /// None: it varies.
    pub fn constant_value(&self, _view: &View) -> Option<Rgb> {
        None
    }
}
