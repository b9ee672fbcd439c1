//! `conductor`: a perfectly smooth metal; one-sided, black from behind.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `material` | a measured metal by name, or `none` for a perfect mirror | see `measured_metals` | `none` |
//! | `eta`, `k` | real and imaginary index of refraction instead of `material` | ≥ 0 | – |
//! | `specular_reflectance` | factor on the reflection | 0 to 1 | 1 |

use super::measured_metals::METALS;
use super::{Lobes, MaterialSample, SpecularLobes, View, fresnel};
use crate::math::Rgb;
use crate::scene::error::{SceneError, nearest_name};
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A smooth metal.
#[derive(Clone, Debug)]
pub struct Conductor {
    /// Real and imaginary index; `None` reflects everything.
    index: Option<(Rgb, Rgb)>,
    specular_reflectance: Texture,
}

/// Reads `material`, or `eta` and `k`; `None` is the perfect mirror.
pub(crate) fn read_index(fields: &mut Fields<'_>) -> Result<Option<(Rgb, Rgb)>, SceneError> {
    let to_single = |rgb: [f64; 3]| Rgb::new(rgb[0] as f32, rgb[1] as f32, rgb[2] as f32);
    let material = fields.string("material")?;
    let (eta, k) = (fields.rgb("eta")?, fields.rgb("k")?);
    match (material, eta, k) {
        (None, Some(eta), Some(k)) => Ok(Some((to_single(eta), to_single(k)))),
        (None, None, None) => Ok(None),
        (Some(name), None, None) => named_metal(name, fields),
        (Some(_), _, _) => {
            Err(fields.error("material", "a conductor has both \"material\" and \"eta\" or \"k\"", "give one of them"))
        }
        _ => Err(fields.error("eta", "a conductor has one of \"eta\" and \"k\"", "give both")),
    }
}

fn named_metal(name: &str, fields: &Fields<'_>) -> Result<Option<(Rgb, Rgb)>, SceneError> {
    if name == "none" {
        return Ok(None);
    }
    match METALS.iter().find(|(known, _, _)| *known == name) {
        Some((_, eta, k)) => Ok(Some((Rgb::from_array(*eta), Rgb::from_array(*k)))),
        None => {
            let known: Vec<&str> = METALS.iter().map(|(known, _, _)| *known).chain(["none"]).collect();
            let problem = format!("there is no measured metal \"{name}\"");
            Err(fields.error("material", problem, nearest_name(name, &known)))
        }
    }
}

impl Conductor {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let index = read_index(fields)?;
        Ok(Self { index, specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)? })
    }

    /// The mirrored direction.
    #[inline]
    pub fn sample(&self, view: &View, _u: [f32; 3]) -> Option<MaterialSample> {
        let outgoing = view.outgoing;
        if outgoing.z <= 0.0 || !view.lobes.any(Lobes::SPECULAR) {
            return None;
        }
        let reflected = match self.index {
            Some((eta, k)) => fresnel::conductor(outgoing.z, eta, k),
            None => Rgb::ONE,
        };
        Some(MaterialSample::mirrored(outgoing, reflected * self.specular_reflectance.color(&view.point)))
    }

    /// One specular lobe.
    pub fn lobes(&self) -> Lobes {
        Lobes::SPECULAR
    }

    /// The mirrored direction.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        [self.sample(view, [0.0; 3]), None, None, None]
    }
}

purely_specular!(Conductor);
