//! `dielectric`: a perfectly smooth boundary between two transparent media, such as glass and air.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `int_ior` | index of refraction inside (behind the normal), a number or a name | > 0 | `bk7` (1.5046) |
//! | `ext_ior` | the same outside | > 0 | `air` (1.000277) |
//! | `specular_reflectance`, `specular_transmittance` | factors on reflection and transmission | 0 to 1 | 1 |
//!
//! Reflection is chosen with Fresnel's probability. Refraction scales radiance, but not flux, by the squared index ratio.

use super::refractive_indices::REFRACTIVE_INDICES;
use super::{Lobes, MaterialSample, SpecularLobes, TransportMode, View, fresnel};
use crate::math::Vec3;
use crate::scene::error::{SceneError, nearest_name, shown_number};
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A smooth boundary between two transparent media.
#[derive(Clone, Debug)]
pub struct Dielectric {
    /// Index inside over index outside.
    relative_index: f32,
    specular_reflectance: Texture,
    specular_transmittance: Texture,
}

/// Reads an index of refraction given as a number or a name.
pub(crate) fn read_index(fields: &mut Fields<'_>, name: &'static str, default: &str) -> Result<f32, SceneError> {
    let by_name = |wanted: &str| {
        let wanted = wanted.to_lowercase();
        REFRACTIVE_INDICES.iter().find(|(known, _)| *known == wanted).map(|(_, index)| *index)
    };
    let text = match fields.float(name) {
        Ok(Some(index)) if index > 0.0 => return Ok(index as f32),
        Ok(Some(index)) => {
            let problem = format!("\"{name}\" is {}: no medium has such an index of refraction", shown_number(index));
            return Err(fields.error(name, problem, "give a number above 0, for example 1.5"));
        }
        Ok(None) => default,
        Err(_) => fields.string(name)?.unwrap_or(default),
    };
    by_name(text).ok_or_else(|| {
        let known: Vec<&str> = REFRACTIVE_INDICES.iter().map(|(known, _)| *known).collect();
        fields.error(name, format!("there is no medium \"{text}\""), nearest_name(text, &known))
    })
}

impl Dielectric {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let interior = read_index(fields, "int_ior", "bk7")?;
        let exterior = read_index(fields, "ext_ior", "air")?;
        Ok(Self {
            relative_index: interior / exterior,
            specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)?,
            specular_transmittance: textures.share(fields, "specular_transmittance", 1.0)?,
        })
    }

    /// Chooses reflection or refraction with Fresnel's probability.
    #[inline]
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if !view.lobes.any(Lobes::SPECULAR) {
            return None;
        }
        let (boundary, relative_index) = self.boundary(view.outgoing);
        if u[2] < boundary.reflected {
            Some(self.reflection(view))
        } else {
            Some(self.refraction(view, boundary.cosine_refracted, relative_index))
        }
    }

    fn boundary(&self, outgoing: Vec3) -> (fresnel::DielectricBoundary, f32) {
        let relative_index = if outgoing.z >= 0.0 { self.relative_index } else { 1.0 / self.relative_index };
        (fresnel::dielectric(outgoing.z.abs(), relative_index), relative_index)
    }

    fn reflection(&self, view: &View) -> MaterialSample {
        MaterialSample::mirrored(view.outgoing, self.specular_reflectance.color(&view.point))
    }

    fn refraction(&self, view: &View, cosine: f32, relative_index: f32) -> MaterialSample {
        let outgoing = view.outgoing;
        let inverse = 1.0 / relative_index;
        let direction = Vec3::new(-outgoing.x * inverse, -outgoing.y * inverse, -cosine.copysign(outgoing.z));
        let scale = match view.mode {
            TransportMode::Radiance => inverse * inverse,
            TransportMode::Flux => 1.0,
        };
        MaterialSample {
            direction,
            weight: self.specular_transmittance.color(&view.point) * scale,
            pdf: 0.0,
            relative_index,
        }
    }

    /// Two specular lobes.
    pub fn lobes(&self) -> Lobes {
        Lobes::SPECULAR | Lobes::TRANSMISSIVE
    }

    /// Reflection and refraction, each weighted by its share.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        let (boundary, relative_index) = self.boundary(view.outgoing);
        let weighted = |sample: MaterialSample, share: f32| {
            (share > 0.0).then_some(MaterialSample { weight: sample.weight * share, ..sample })
        };
        let refraction = self.refraction(view, boundary.cosine_refracted, relative_index);
        let reflection = weighted(self.reflection(view), boundary.reflected);
        [reflection, weighted(refraction, 1.0 - boundary.reflected), None, None]
    }
}

purely_specular!(Dielectric);
