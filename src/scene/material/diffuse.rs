//! `diffuse`: an ideal matte surface; one-sided, black from behind.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `reflectance` | share of light it reflects, per channel | 0 to 1 | 0.5 |
//!
//! f = reflectance/π; sampled by the cosine.

use std::f32::consts::FRAC_1_PI;

use super::{Lobes, MaterialSample, SpecularLobes, View};
use crate::math::{Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// An ideal matte surface.
#[derive(Clone, Debug)]
pub struct Diffuse {
    reflectance: Texture,
}

impl Diffuse {
    /// A grey of `reflectance`, 0 to 1.
    pub fn grey(reflectance: f32) -> Self {
        Self { reflectance: Texture::grey(reflectance) }
    }

    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        Ok(Self { reflectance: textures.share(fields, "reflectance", 0.5)? })
    }

    /// Samples by the cosine: the weight is the reflectance.
    #[inline]
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        let direction = warp::cosine_hemisphere([u[0], u[1]]);
        let pdf = warp::cosine_hemisphere_pdf(direction.z);
        (seen(view) && pdf > 0.0).then_some(MaterialSample {
            direction,
            weight: self.reflectance.color(&view.point),
            pdf,
            relative_index: 1.0,
        })
    }

    /// reflectance/π above the surface.
    #[inline]
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        if seen(view) && incident.z > 0.0 { self.reflectance.color(&view.point) * FRAC_1_PI } else { Rgb::ZERO }
    }

    /// cos θ/π above the surface.
    #[inline]
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        if seen(view) { warp::cosine_hemisphere_pdf(incident.z) } else { 0.0 }
    }

    /// One wide lobe.
    pub fn lobes(&self) -> Lobes {
        Lobes::WIDE
    }

    /// 0: there is nothing to follow.
    pub fn followed_share(&self, _view: &View) -> f32 {
        0.0
    }

    /// None.
    pub fn specular_lobes(&self, _view: &View) -> SpecularLobes {
        SpecularLobes::default()
    }

    /// reflectance/π.
    #[inline]
    pub fn constant_value(&self, view: &View) -> Option<Rgb> {
        Some(if seen(view) { self.reflectance.color(&view.point) * FRAC_1_PI } else { Rgb::ZERO })
    }
}

#[inline]
fn seen(view: &View) -> bool {
    view.outgoing.z > 0.0 && view.lobes.any(Lobes::WIDE)
}
