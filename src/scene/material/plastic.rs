//! `plastic`: a matte base under a smooth clear coat; one-sided, black from behind.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `diffuse_reflectance` | share of light that the base reflects | 0 to 1 | 0.5 |
//! | `specular_reflectance` | factor on the coat's reflection | 0 to 1 | 1 |
//! | `int_ior` | index of refraction of the coat, a number or a name | > 0 | `polypropylene` (1.49) |
//! | `ext_ior` | the same outside, not equal to `int_ior` | > 0 | `air` (1.000277) |
//! | `nonlinear` | whether light that bounces between base and coat takes the base's color each time | – | false |
//!
//! Light that passes the coat with Fresnel's transmittance both ways leaves as f = T(θo)·T(θi)·ρ/(π·η²·(1 − ρ'·F̄)), where
//! ρ' is the reflectance ρ if `nonlinear` and else 1, and F̄ the coat's mean reflectance from inside. F̄ is the fit of
//! [Egan & Hilgeman 1973] that Mitsuba uses, for equal pictures: it is 0.1 % too high at η = 1.5, so that a base of
//! reflectance 1 returns 1.001 of the light; at η = 2 it is some 2 % in light.

use std::f32::consts::FRAC_1_PI;

use super::lobe_choice::{LobeChoice, followed_share, mean};
use super::rough_dielectric::read_relative_index;
use super::{Lobes, MaterialSample, SpecularLobes, View, fresnel};
use crate::math::{Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A matte base under a smooth clear coat.
#[derive(Clone, Debug)]
pub struct Plastic {
    base: CoatedBase,
    specular_reflectance: Texture,
    /// Index inside over index outside.
    relative_index: f32,
}

/// The matte base under a clear coat.
#[derive(Clone, Debug)]
pub(crate) struct CoatedBase {
    /// Share of light that it reflects.
    pub reflectance: Texture,
    nonlinear: bool,
    /// The coat's mean reflectance from inside.
    internal_reflectance: f32,
    inverse_index_squared: f32,
}

impl CoatedBase {
    /// Reads `diffuse_reflectance` and `nonlinear`.
    pub(crate) fn read(
        fields: &mut Fields<'_>,
        textures: &mut TextureReader<'_>,
        relative_index: f32,
        internal_reflectance: f32,
    ) -> Result<Self, SceneError> {
        Ok(Self {
            reflectance: textures.share(fields, "diffuse_reflectance", 0.5)?,
            nonlinear: fields.boolean("nonlinear")?.unwrap_or(false),
            internal_reflectance,
            inverse_index_squared: 1.0 / (relative_index * relative_index),
        })
    }

    /// The BSDF without the coat's transmittance, 1/sr.
    #[inline]
    pub(crate) fn value(&self, view: &View) -> Rgb {
        let reflectance = self.reflectance.color(&view.point);
        let trapped = if self.nonlinear { reflectance } else { Rgb::ONE } * self.internal_reflectance;
        reflectance * (FRAC_1_PI * self.inverse_index_squared) / (Rgb::ONE - trapped)
    }
}

impl Plastic {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let relative_index = read_relative_index(fields, "polypropylene")?;
        let internal_reflectance = fresnel::mean_reflectance(1.0 / relative_index);
        Ok(Self {
            base: CoatedBase::read(fields, textures, relative_index, internal_reflectance)?,
            specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)?,
            relative_index,
        })
    }

    /// About how much light the coat and the base reflect, black outside of the lobes in view.
    fn shares(&self, view: &View) -> [f32; 2] {
        let reflected = fresnel::dielectric(view.outgoing.z, self.relative_index).reflected;
        let coat = reflected * mean(self.specular_reflectance.color(&view.point));
        let base = (1.0 - reflected) * mean(self.base.reflectance.color(&view.point));
        [if view.lobes.any(Lobes::SPECULAR) { coat } else { 0.0 }, if view.lobes.any(Lobes::WIDE) { base } else { 0.0 }]
    }

    /// Chooses the coat or the base by their shares.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if view.outgoing.z <= 0.0 {
            return None;
        }
        let choice = LobeChoice::new(self.shares(view));
        match choice.pick(u[2])?.0 {
            0 => Some(self.mirrored(view).scaled(1.0 / choice.probabilities[0])),
            _ => {
                let direction = warp::cosine_hemisphere([u[0], u[1]]);
                MaterialSample::weighted(direction, (self.evaluate(view, direction), self.pdf(view, direction)), 1.0)
            }
        }
    }

    fn mirrored(&self, view: &View) -> MaterialSample {
        let reflected = fresnel::dielectric(view.outgoing.z, self.relative_index).reflected;
        MaterialSample::mirrored(view.outgoing, self.specular_reflectance.color(&view.point) * reflected)
    }

    /// The base, seen through the coat.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        if view.outgoing.z <= 0.0 || incident.z <= 0.0 || !view.lobes.any(Lobes::WIDE) {
            return Rgb::ZERO;
        }
        let passed = |cosine: f32| 1.0 - fresnel::dielectric(cosine, self.relative_index).reflected;
        self.base.value(view) * (passed(view.outgoing.z) * passed(incident.z))
    }

    /// The base's cosine, times the probability to choose the base.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        if view.outgoing.z <= 0.0 {
            return 0.0;
        }
        LobeChoice::new(self.shares(view)).probabilities[1] * warp::cosine_hemisphere_pdf(incident.z)
    }

    /// A specular coat and a wide base.
    pub fn lobes(&self) -> Lobes {
        Lobes::SPECULAR | Lobes::WIDE
    }

    /// The coat's share.
    pub fn followed_share(&self, view: &View) -> f32 {
        let [coat, base] = self.shares(&view.of(Lobes::ALL));
        if view.outgoing.z > 0.0 { followed_share(coat, base) } else { 0.0 }
    }

    /// The coat's reflection.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        let seen = view.outgoing.z > 0.0 && view.lobes.any(Lobes::SPECULAR);
        [seen.then(|| self.mirrored(view)), None, None, None]
    }

    /// None: the coat's transmittance varies.
    pub fn constant_value(&self, _view: &View) -> Option<Rgb> {
        None
    }
}
