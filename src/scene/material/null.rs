//! `null`: nothing at all: light passes as if the surface were not there. It has no parameters.

use super::{Lobes, MaterialSample, SpecularLobes, View};
use crate::math::Rgb;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::TextureReader;

/// An invisible surface.
#[derive(Clone, Debug)]
pub struct Null;

impl Null {
    /// Reads nothing.
    pub fn read(_fields: &mut Fields<'_>, _textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        Ok(Self)
    }

    /// Straight on.
    pub fn sample(&self, view: &View, _u: [f32; 3]) -> Option<MaterialSample> {
        view.lobes.any(Lobes::SPECULAR).then(|| MaterialSample::straight(view.outgoing, Rgb::ONE))
    }

    /// One specular lobe.
    pub fn lobes(&self) -> Lobes {
        Lobes::SPECULAR | Lobes::TRANSMISSIVE
    }

    /// Straight on.
    pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
        [self.sample(view, [0.0; 3]), None, None, None]
    }
}

purely_specular!(Null);
