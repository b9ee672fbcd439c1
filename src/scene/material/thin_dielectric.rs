//! `thindielectric`: a thin pane, such as a window modelled as one sheet: light passes straight on.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `int_ior` | index of refraction of the pane, a number or a name | > 0 | `bk7` (1.5046) |
//! | `ext_ior` | the same on both of its sides | > 0 | `air` (1.000277) |
//! | `specular_reflectance`, `specular_transmittance` | factors on reflection and transmission | 0 to 1 | 1 |
//!
//! With Fresnel's reflectance r of one face, all bounces inside add up to R = r + (1 − r)²·r·(1 + r² + …) = 2r/(1 + r)
//! [Stokes 1862].

use super::dielectric::read_index;
use super::{Lobes, MaterialSample, SpecularLobes, View, fresnel};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A thin pane.
#[derive(Clone, Debug)]
pub struct ThinDielectric {
    /// Index inside over index outside.
    relative_index: f32,
    specular_reflectance: Texture,
    specular_transmittance: Texture,
}

impl ThinDielectric {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            relative_index: read_index(fields, "int_ior", "bk7")? / read_index(fields, "ext_ior", "air")?,
            specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)?,
            specular_transmittance: textures.share(fields, "specular_transmittance", 1.0)?,
        })
    }

    fn reflected(&self, view: &View) -> f32 {
        let face = fresnel::dielectric(view.outgoing.z.abs(), self.relative_index).reflected;
        2.0 * face / (1.0 + face)
    }

    /// Chooses reflection or passing on by their shares.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if !view.lobes.any(Lobes::SPECULAR) {
            return None;
        }
        Some(if u[2] < self.reflected(view) {
            MaterialSample::mirrored(view.outgoing, self.specular_reflectance.color(&view.point))
        } else {
            MaterialSample::straight(view.outgoing, self.specular_transmittance.color(&view.point))
        })
    }

    /// Two specular lobes.
    pub fn lobes(&self) -> Lobes {
        Lobes::SPECULAR | Lobes::TRANSMISSIVE
    }

    /// Reflection and passing on, each weighted by its share.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        if !view.lobes.any(Lobes::SPECULAR) {
            return SpecularLobes::default();
        }
        let share = self.reflected(view);
        let mirrored = MaterialSample::mirrored(view.outgoing, self.specular_reflectance.color(&view.point) * share);
        let passing = self.specular_transmittance.color(&view.point) * (1.0 - share);
        [Some(mirrored), Some(MaterialSample::straight(view.outgoing, passing)), None, None]
    }
}

purely_specular!(ThinDielectric);
