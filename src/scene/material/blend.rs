//! `blendbsdf`: a mixture of two materials.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `weight` | share of the second material; a texture's values outside of the range count as its ends | 0 to 1 | required |
//! | two nested bsdfs | the materials | – | required |
//!
//! f = (1 − weight)·f₁ + weight·f₂, chosen by the weight.

use super::lobe_choice::{LobeChoice, followed_share};
use super::{Lobes, Material, MaterialSample, SpecularLobes, TransportMode, View};
use crate::math::{Rgb, Vec2, Vec3};
use crate::scene::description::PluginClass;
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;
use crate::scene::texture::{Texture, TextureReader};

/// A mixture of two materials.
#[derive(Clone, Debug)]
pub struct Blend {
    weight: Texture,
    parts: [Box<Material>; 2],
}

/// Reads a number within [0, 1] that may be a texture.
pub(crate) fn read_share(
    fields: &mut Fields<'_>,
    textures: &mut TextureReader<'_>,
    name: &'static str,
) -> Result<Option<Texture>, SceneError> {
    let texture = textures.number(fields, name)?;
    match texture.as_ref().filter(|texture| !texture.varies()).map(|texture| texture.number(&TexturePoint::default())) {
        Some(number) if !(0.0..=1.0).contains(&number) => {
            Err(fields.error(name, format!("\"{name}\" is {}", shown_number(number)), "give a number from 0 to 1"))
        }
        _ => Ok(texture),
    }
}

impl Blend {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let Some(weight) = read_share(fields, textures, "weight")? else {
            let problem = "\"blendbsdf\" has no \"weight\"";
            return Err(SceneError::new(fields.location(), problem, "give the share of the second bsdf, 0 to 1"));
        };
        let [Some(first), Some(second)] = [fields.child(PluginClass::Bsdf), fields.child(PluginClass::Bsdf)] else {
            let problem = "\"blendbsdf\" holds fewer than two bsdfs";
            return Err(SceneError::new(fields.location(), problem, "nest the two bsdfs to be mixed"));
        };
        let parts = [Box::new(super::read(first, textures)?), Box::new(super::read(second, textures)?)];
        let blend = Self { weight, parts };
        blend.check_specular_directions(fields)?;
        Ok(blend)
    }

    /// Mixtures of mixtures may have more mirror and glass directions than fit into [`SpecularLobes`].
    fn check_specular_directions(&self, fields: &Fields<'_>) -> Result<(), SceneError> {
        let most = SpecularLobes::default().len();
        let fits = [0.8, -0.8].iter().all(|z| {
            let view = View::new(Vec2::splat(0.5), Vec3::new(0.6, 0.0, *z), TransportMode::Radiance);
            self.specular_directions(&view).len() <= most
        });
        if fits {
            return Ok(());
        }
        let problem = format!("\"blendbsdf\" mixes materials with more than {most} specular directions");
        Err(SceneError::new(fields.location(), problem, "mix fewer kinds of glass"))
    }

    fn weights(&self, view: &View) -> [f32; 2] {
        let second = self.weight.number(&view.point).clamp(0.0, 1.0);
        [1.0 - second, second]
    }

    /// A part is chosen by its weight among those with lobes in view.
    fn choice(&self, view: &View) -> LobeChoice<2> {
        let [first, second] = self.weights(view);
        let seen = |part: &Material| if part.lobes().kinds().any(view.lobes) { 1.0 } else { 0.0 };
        LobeChoice::new([first * seen(&self.parts[0]), second * seen(&self.parts[1])])
    }

    /// Chooses a part by the weight.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        let choice = self.choice(view);
        let (index, rest) = choice.pick(u[2])?;
        let sample = self.parts[index].sample(view, [u[0], u[1], rest])?;
        if sample.is_specular() {
            return Some(sample.scaled(self.weights(view)[index] / choice.probabilities[index]));
        }
        let response = (self.evaluate(view, sample.direction), self.pdf(view, sample.direction));
        MaterialSample::weighted(sample.direction, response, sample.relative_index)
    }

    /// The mixture.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        let [first, second] = self.weights(view);
        self.parts[0].evaluate(view, incident) * first + self.parts[1].evaluate(view, incident) * second
    }

    /// The mixture of the densities.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        let [first, second] = self.choice(view).probabilities;
        self.parts[0].pdf(view, incident) * first + self.parts[1].pdf(view, incident) * second
    }

    /// Those of both.
    pub fn lobes(&self) -> Lobes {
        self.parts[0].lobes() | self.parts[1].lobes()
    }

    /// The mixture of theirs.
    pub fn followed_share(&self, view: &View) -> f32 {
        let [first, second] = self.weights(view);
        let shares = [self.parts[0].followed_share(view), self.parts[1].followed_share(view)];
        let gathered = first * (1.0 - shares[0]) + second * (1.0 - shares[1]);
        followed_share(first * shares[0] + second * shares[1], gathered)
    }

    /// Those of both.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        let mut lobes = self.specular_directions(view).into_iter();
        std::array::from_fn(|_| lobes.next())
    }

    /// The specular directions of both, equal ones as one.
    fn specular_directions(&self, view: &View) -> Vec<MaterialSample> {
        let mut found: Vec<MaterialSample> = Vec::new();
        for (part, weight) in self.parts.iter().zip(self.weights(view)) {
            for lobe in part.specular_lobes(view).into_iter().flatten().map(|lobe| lobe.scaled(weight)) {
                match found.iter_mut().find(|known| known.direction == lobe.direction) {
                    Some(known) => known.weight += lobe.weight,
                    None => found.push(lobe),
                }
            }
        }
        found
    }

    /// Where both are constant on the same side.
    pub fn constant_value(&self, view: &View) -> Option<Rgb> {
        let [first, second] = self.weights(view);
        Some(self.parts[0].constant_value(view)? * first + self.parts[1].constant_value(view)? * second)
    }
}
