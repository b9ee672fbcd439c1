//! `mask`: makes a material partly transparent, such as a leaf cut out of a rectangle by a texture.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `opacity` | share of the nested material; the rest is a hole; a texture's values outside of the range count as its ends | 0 to 1 | 0.5 |
//! | a nested bsdf | the material | – | required |

use super::blend::read_share;
use super::lobe_choice::{LobeChoice, followed_share};
use super::{Lobes, Material, MaterialSample, SpecularLobes, TransportMode, View};
use crate::math::{Rgb, Vec2, Vec3};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// A material with holes.
#[derive(Clone, Debug)]
pub struct Mask {
    opacity: Texture,
    material: Box<Material>,
}

impl Mask {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let opacity = read_share(fields, textures, "opacity")?.unwrap_or(Texture::grey(0.5));
        let Some(node) = fields.child(PluginClass::Bsdf) else {
            let problem = "\"mask\" holds no bsdf";
            return Err(SceneError::new(fields.location(), problem, "nest the bsdf that shows where it is opaque"));
        };
        let material = Box::new(super::read(node, textures)?);
        let view = View::new(Vec2::ZERO, Vec3::new(0.6, 0.0, 0.8), TransportMode::Radiance);
        if material.specular_lobes(&view)[3].is_some() {
            let problem = "\"mask\" holds a bsdf with too many specular directions";
            return Err(SceneError::new(fields.location(), problem, "mix fewer kinds of glass"));
        }
        Ok(Self { opacity, material })
    }

    fn opacity(&self, view: &View) -> f32 {
        self.opacity.number(&view.point).clamp(0.0, 1.0)
    }

    /// The material or the hole is chosen by the opacity, as far as they have lobes in view.
    #[inline]
    fn choice(&self, view: &View) -> LobeChoice<2> {
        let opacity = self.opacity(view);
        LobeChoice::new([
            if self.material.lobes().kinds().any(view.lobes) { opacity } else { 0.0 },
            if view.lobes.any(Lobes::SPECULAR) { 1.0 - opacity } else { 0.0 },
        ])
    }

    /// Chooses the material or the hole by the opacity.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        let choice = self.choice(view);
        let (index, rest) = choice.pick(u[2])?;
        let probability = choice.probabilities[index];
        if index == 1 {
            let through = (1.0 - self.opacity(view)) / probability;
            return Some(MaterialSample::straight(view.outgoing, Rgb::splat(through)));
        }
        let sample = self.material.sample(view, [u[0], u[1], rest])?.scaled(self.opacity(view) / probability);
        Some(MaterialSample { pdf: sample.pdf * probability, ..sample })
    }

    /// The material, as far as it is opaque.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        self.material.evaluate(view, incident) * self.opacity(view)
    }

    /// The material's, times the probability to choose it.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        self.material.pdf(view, incident) * self.choice(view).probabilities[0]
    }

    /// The material's, and a hole.
    pub fn lobes(&self) -> Lobes {
        self.material.lobes() | Lobes::SPECULAR | Lobes::TRANSMISSIVE
    }

    /// The hole's share and what of the material is followed; the material is taken to reflect half the light.
    pub fn followed_share(&self, view: &View) -> f32 {
        let opacity = self.opacity(view);
        let share = self.material.followed_share(view);
        followed_share(1.0 - opacity + 0.5 * opacity * share, 0.5 * opacity * (1.0 - share))
    }

    /// The material's, and straight on.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        if !view.lobes.any(Lobes::SPECULAR) {
            return SpecularLobes::default();
        }
        let opacity = self.opacity(view);
        let mut lobes = self.material.specular_lobes(view).map(|lobe| lobe.map(|lobe| lobe.scaled(opacity)));
        let through = MaterialSample::straight(view.outgoing, Rgb::splat(1.0 - opacity));
        match lobes.iter_mut().find(|lobe| lobe.is_none_or(|lobe| lobe.direction == through.direction)) {
            Some(Some(straight)) => straight.weight += through.weight,
            Some(free) => *free = Some(through),
            None => {}
        }
        lobes
    }

    /// None: light passes.
    pub fn constant_value(&self, _view: &View) -> Option<Rgb> {
        None
    }

    /// That of the material.
    pub fn turned_normal(&self, view: &View) -> Vec3 {
        self.material.turned_normal(view)
    }
}
