//! `twosided`: gives a one-sided material a back.
//!
//! Holds one opaque bsdf for both sides, or two: front, then back.

use super::{Lobes, Material, MaterialSample, TransportMode};
use crate::math::{Rgb, Vec3};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// Two opaque materials back to back.
#[derive(Clone, Debug)]
pub struct TwoSided {
    front: Box<Material>,
    back: Box<Material>,
}

fn flip(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.y, -direction.z)
}

impl TwoSided {
    /// The same matte grey on both sides.
    pub fn matte(reflectance: f32) -> Self {
        let side = Box::new(Material::Diffuse(super::Diffuse::grey(reflectance)));
        Self { front: side.clone(), back: side }
    }

    /// Reads the nested materials.
    pub fn read(fields: &mut Fields<'_>) -> Result<Self, SceneError> {
        let nodes = [fields.child(PluginClass::Bsdf), fields.child(PluginClass::Bsdf)];
        let Some(front_node) = nodes[0] else {
            let problem = "\"twosided\" holds no bsdf";
            return Err(SceneError::new(fields.location(), problem, "nest one opaque bsdf, or two"));
        };
        let front = super::read(front_node)?;
        let back = nodes[1].map_or_else(|| Ok(front.clone()), |node| super::read(node))?;
        if front.lobes().transmissive || back.lobes().transmissive {
            let problem = "\"twosided\" holds a bsdf that lets light through";
            return Err(SceneError::new(
                fields.location(),
                problem,
                "use that bsdf without twosided: it has both sides",
            ));
        }
        Ok(Self { front: Box::new(front), back: Box::new(back) })
    }

    /// Samples the side that is seen.
    #[inline]
    pub fn sample(&self, outgoing: Vec3, mode: TransportMode, u: [f32; 3]) -> Option<MaterialSample> {
        if outgoing.z >= 0.0 {
            return self.front.sample(outgoing, mode, u);
        }
        let sample = self.back.sample(flip(outgoing), mode, u)?;
        Some(MaterialSample { direction: flip(sample.direction), ..sample })
    }

    /// The side that is seen.
    #[inline]
    pub fn evaluate(&self, outgoing: Vec3, incident: Vec3) -> Rgb {
        match outgoing.z >= 0.0 {
            true => self.front.evaluate(outgoing, incident),
            false => self.back.evaluate(flip(outgoing), flip(incident)),
        }
    }

    /// The side that is seen.
    #[inline]
    pub fn pdf(&self, outgoing: Vec3, incident: Vec3) -> f32 {
        match outgoing.z >= 0.0 {
            true => self.front.pdf(outgoing, incident),
            false => self.back.pdf(flip(outgoing), flip(incident)),
        }
    }

    /// Those of both sides.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        let (front, back) = (self.front.lobes(), self.back.lobes());
        Lobes { smooth: front.smooth || back.smooth, specular: front.specular || back.specular, transmissive: false }
    }

    /// Those of the side that is seen.
    pub fn specular_lobes(&self, outgoing: Vec3, mode: TransportMode) -> [Option<MaterialSample>; 2] {
        if outgoing.z >= 0.0 {
            return self.front.specular_lobes(outgoing, mode);
        }
        let flipped = |sample: MaterialSample| MaterialSample { direction: flip(sample.direction), ..sample };
        self.back.specular_lobes(flip(outgoing), mode).map(|sample| sample.map(flipped))
    }

    /// That of the side that is seen.
    #[inline]
    pub fn constant_value(&self, outgoing: Vec3) -> Option<Rgb> {
        match outgoing.z >= 0.0 {
            true => self.front.constant_value(outgoing),
            false => self.back.constant_value(flip(outgoing)),
        }
    }
}
