//! `twosided`: gives a one-sided material a back.
//!
//! Holds one opaque bsdf for both sides, or two: front, then back.

use super::{Lobes, Material, MaterialSample, SpecularLobes, View, flip};
use crate::math::{Rgb, Vec3};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::TextureReader;

/// Two opaque materials back to back.
#[derive(Clone, Debug)]
pub struct TwoSided {
    front: Box<Material>,
    back: Box<Material>,
}

impl TwoSided {
    /// The same matte grey on both sides.
    pub fn matte(reflectance: f32) -> Self {
        let side = Box::new(Material::Diffuse(super::Diffuse::grey(reflectance)));
        Self { front: side.clone(), back: side }
    }

    /// Reads the nested materials.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let nodes = [fields.child(PluginClass::Bsdf), fields.child(PluginClass::Bsdf)];
        let Some(front_node) = nodes[0] else {
            let problem = "\"twosided\" holds no bsdf";
            return Err(SceneError::new(fields.location(), problem, "nest one opaque bsdf, or two"));
        };
        let front = super::read(front_node, textures)?;
        let back = nodes[1].map_or_else(|| Ok(front.clone()), |node| super::read(node, textures))?;
        if (front.lobes() | back.lobes()).any(Lobes::TRANSMISSIVE) {
            let problem = "\"twosided\" holds a bsdf that lets light through";
            return Err(SceneError::new(
                fields.location(),
                problem,
                "use that bsdf without twosided: it has both sides",
            ));
        }
        Ok(Self { front: Box::new(front), back: Box::new(back) })
    }

    /// The side that is seen, and the view of it.
    #[inline]
    fn side(&self, view: &View) -> (&Material, View) {
        if view.outgoing.z >= 0.0 { (&self.front, *view) } else { (&self.back, view.from_behind()) }
    }

    /// Samples the side that is seen.
    #[inline]
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        let (material, side) = self.side(view);
        let sample = material.sample(&side, u)?;
        Some(if view.outgoing.z >= 0.0 { sample } else { sample.from_behind() })
    }

    /// The side that is seen.
    #[inline]
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        let (material, side) = self.side(view);
        material.evaluate(&side, if view.outgoing.z >= 0.0 { incident } else { flip(incident) })
    }

    /// The side that is seen.
    #[inline]
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        let (material, side) = self.side(view);
        material.pdf(&side, if view.outgoing.z >= 0.0 { incident } else { flip(incident) })
    }

    /// Those of both sides.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.front.lobes() | self.back.lobes()
    }

    /// That of the side that is seen.
    #[inline]
    pub fn followed_share(&self, view: &View) -> f32 {
        let (material, side) = self.side(view);
        material.followed_share(&side)
    }

    /// Those of the side that is seen.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        let (material, side) = self.side(view);
        let lobes = material.specular_lobes(&side);
        if view.outgoing.z >= 0.0 { lobes } else { lobes.map(|sample| sample.map(MaterialSample::from_behind)) }
    }

    /// That of the side that is seen.
    #[inline]
    pub fn constant_value(&self, view: &View) -> Option<Rgb> {
        let (material, side) = self.side(view);
        material.constant_value(&side)
    }

    /// That of the side that is seen, in the frame of the front.
    pub fn turned_normal(&self, view: &View) -> Vec3 {
        let (material, side) = self.side(view);
        material.turned_normal(&side)
    }
}
