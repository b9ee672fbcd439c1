//! `difftrans`: an ideal matte sheet that lets light through and reflects none, such as a lampshade; works from both sides.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `transmittance` | share of light that leaves on the other side, per channel | 0 to 1 | 0.5 |
//!
//! Name and parameter are those of Mitsuba 0.6. f = transmittance/π on the other side; sampled by the cosine.

use std::f32::consts::FRAC_1_PI;

use super::{Lobes, MaterialSample, SpecularLobes, View};
use crate::math::{Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// An ideal matte sheet that lets light through.
#[derive(Clone, Debug)]
pub struct DiffuseTransmitter {
    transmittance: Texture,
}

impl DiffuseTransmitter {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        Ok(Self { transmittance: textures.share(fields, "transmittance", 0.5)? })
    }

    /// Samples by the cosine on the other side.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        let above = warp::cosine_hemisphere([u[0], u[1]]);
        let direction = Vec3::new(above.x, above.y, -above.z.copysign(view.outgoing.z));
        MaterialSample::weighted(direction, (self.evaluate(view, direction), self.pdf(view, direction)), 1.0)
    }

    /// transmittance/π on the other side.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        let seen = view.lobes.any(Lobes::WIDE) && view.outgoing.z * incident.z < 0.0;
        if seen { self.transmittance.color(&view.point) * FRAC_1_PI } else { Rgb::ZERO }
    }

    /// |cos θ|/π on the other side.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        let seen = view.lobes.any(Lobes::WIDE) && view.outgoing.z * incident.z < 0.0;
        if seen { warp::cosine_hemisphere_pdf(incident.z.abs()) } else { 0.0 }
    }

    /// One wide lobe behind.
    pub fn lobes(&self) -> Lobes {
        Lobes::WIDE | Lobes::TRANSMISSIVE
    }

    /// 0: there is nothing to follow.
    pub fn followed_share(&self, _view: &View) -> f32 {
        0.0
    }

    /// None.
    pub fn specular_lobes(&self, _view: &View) -> SpecularLobes {
        SpecularLobes::default()
    }

    /// None: light counts from the other side only.
    pub fn constant_value(&self, _view: &View) -> Option<Rgb> {
        None
    }
}
