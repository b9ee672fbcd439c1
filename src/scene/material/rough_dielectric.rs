//! `roughdielectric`: a rough boundary between two transparent media, such as frosted glass.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `int_ior` | index of refraction inside (behind the normal), a number or a name | > 0 | `bk7` (1.5046) |
//! | `ext_ior` | the same outside, not equal to `int_ior` | > 0 | `air` (1.000277) |
//! | `distribution`, `alpha`, `alpha_u`, `alpha_v`, `sample_visible` | roughness | see `microfacet` | `beckmann`, 0.1 |
//! | `specular_reflectance`, `specular_transmittance` | factors on reflection and transmission | 0 to 1 | 1 |
//!
//! Reflection and refraction at microfacets [Walter et al. 2007, eq. 20 and 21], sampled by visible normals and Fresnel's
//! probability. As at the smooth boundary, refraction scales radiance, but not flux, by the squared index ratio.

use super::dielectric::read_index;
use super::microfacet::{self, Roughness};
use super::{Lobes, MaterialSample, SpecularLobes, TransportMode, View, flip, fresnel};
use crate::math::{Rgb, Vec3};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A rough boundary between two transparent media.
#[derive(Clone, Debug)]
pub struct RoughDielectric {
    /// Index inside over index outside.
    relative_index: f32,
    roughness: Roughness,
    specular_reflectance: Texture,
    specular_transmittance: Texture,
}

impl RoughDielectric {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            relative_index: read_relative_index(fields, "bk7")?,
            roughness: Roughness::read(fields, textures, true)?,
            specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)?,
            specular_transmittance: textures.share(fields, "specular_transmittance", 1.0)?,
        })
    }

    /// The same seen from the front: the material is its own mirror image with the inverse index.
    fn facing(&self, view: &View, direction: Vec3) -> (Vec3, Vec3, f32) {
        if view.outgoing.z >= 0.0 {
            (view.outgoing, direction, self.relative_index)
        } else {
            (flip(view.outgoing), flip(direction), 1.0 / self.relative_index)
        }
    }

    /// Reflects or refracts at a visible normal.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if !view.lobes.any(self.roughness.lobes()) || view.outgoing.z == 0.0 {
            return None;
        }
        let (outgoing, _, relative_index) = self.facing(view, view.outgoing);
        let normal = self.roughness.at(&view.point).visible_normal(outgoing, [u[0], u[1]]);
        let boundary = fresnel::dielectric(outgoing.dot(normal).clamp(0.0, 1.0), relative_index);
        let refracted = u[2] >= boundary.reflected;
        let direction = match refracted {
            true => refract(outgoing, normal, boundary.cosine_refracted, relative_index),
            false => microfacet::reflect(outgoing, normal),
        };
        if refracted == (direction.z > 0.0) {
            return None;
        }
        let direction = if view.outgoing.z >= 0.0 { direction } else { flip(direction) };
        let relative_index = if refracted { relative_index } else { 1.0 };
        MaterialSample::weighted(direction, self.respond(view, direction), relative_index)
    }

    /// The BSDF and the density.
    fn respond(&self, view: &View, incident: Vec3) -> (Rgb, f32) {
        if !view.lobes.any(self.roughness.lobes()) || view.outgoing.z == 0.0 || incident.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let (outgoing, incident, relative_index) = self.facing(view, incident);
        let microfacets = self.roughness.at(&view.point);
        if incident.z > 0.0 {
            let half = (outgoing + incident).normalize();
            let reflected = fresnel::dielectric(outgoing.dot(half).clamp(0.0, 1.0), relative_index).reflected;
            let (value, pdf) = microfacet::reflection(&microfacets, outgoing, incident, half);
            return (self.specular_reflectance.color(&view.point) * reflected * value, reflected * pdf);
        }
        let Some(refraction) = microfacet::refraction(&microfacets, outgoing, incident, relative_index) else {
            return (Rgb::ZERO, 0.0);
        };
        let passed = 1.0 - refraction.reflected;
        let value = passed * refraction.flux_value * refraction_scale(view.mode, relative_index);
        (self.specular_transmittance.color(&view.point) * value, passed * refraction.pdf)
    }

    /// Reflection on one side, refraction on the other.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        self.respond(view, incident).0
    }

    /// That of reflecting and refracting at visible normals.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        self.respond(view, incident).1
    }

    /// Two lobes of one kind, wide or narrow.
    pub fn lobes(&self) -> Lobes {
        self.roughness.lobes() | Lobes::TRANSMISSIVE
    }

    /// 1 for narrow lobes, 0 for wide ones.
    pub fn followed_share(&self, _view: &View) -> f32 {
        if self.roughness.lobes().any(Lobes::FOLLOWED) { 1.0 } else { 0.0 }
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

/// Reads `int_ior` over `ext_ior`, which must differ.
pub(crate) fn read_relative_index(fields: &mut Fields<'_>, interior: &str) -> Result<f32, SceneError> {
    let relative_index = read_index(fields, "int_ior", interior)? / read_index(fields, "ext_ior", "air")?;
    if relative_index == 1.0 {
        let problem = "\"int_ior\" and \"ext_ior\" are equal: such a boundary does nothing";
        return Err(fields.error("int_ior", problem, "give different indices, or use \"null\""));
    }
    Ok(relative_index)
}

/// `outgoing` (on the front) refracted at `normal`.
#[inline]
pub(crate) fn refract(outgoing: Vec3, normal: Vec3, cosine_refracted: f32, relative_index: f32) -> Vec3 {
    let inverse = 1.0 / relative_index;
    (outgoing.dot(normal) * inverse - cosine_refracted) * normal - outgoing * inverse
}

/// What refraction does to what a path carries: radiance scales by the inverse squared index along the path.
#[inline]
pub(crate) fn refraction_scale(mode: TransportMode, relative_index: f32) -> f32 {
    match mode {
        TransportMode::Radiance => 1.0 / (relative_index * relative_index),
        TransportMode::Flux => 1.0,
    }
}
