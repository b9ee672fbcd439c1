//! Whether a scene's lights are behind glass: then hardly any point sees one, and sampling lights is in vain.

use super::Scene;
use super::geometry::Ray;
use super::material::{Lobes, Material};
use crate::math::color::luminance;
use crate::math::random::{PassRandom, Stream, dimension};

/// Photons that are tried.
const PHOTONS: u32 = 1024;
/// Lights are behind glass when less than this share of their flux meets a surface with a smooth lobe first.
const LEAST_SHARE: f32 = 0.01;
/// So many surfaces are passed that are nothing but borders.
const MOST_BORDERS: u32 = 16;

/// What a photon meets first.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meeting {
    /// A surface that light can be sampled at.
    Smooth,
    /// A mirror, or glass.
    Specular,
    /// Nothing.
    Nothing,
}

impl Scene {
    /// Whether nearly all light that meets anything meets mirrors or glass first. Shapes that only bound media do not count.
    pub fn has_sealed_lights(&self) -> bool {
        if !self.lobes().any(Lobes::SPECULAR) {
            return false;
        }
        let random = PassRandom::independent(0, Stream::PilotPhoton, 0);
        let (mut smooth, mut specular) = (0.0, 0.0);
        for path in 0..PHOTONS {
            let numbers = random.path(path);
            let place = numbers.block(dimension::EMISSION);
            let direction = numbers.block(dimension::EMISSION_DIRECTION);
            let direction = [direction[0], direction[1]];
            let photon = self.lights.emit(&self.geometry, [place[0], place[1], place[2]], direction);
            let Some(photon) = photon else { continue };
            match self.meeting(Ray::new(photon.origin, photon.direction)) {
                Meeting::Smooth => smooth += luminance(photon.flux),
                Meeting::Specular => specular += luminance(photon.flux),
                Meeting::Nothing => {}
            }
        }
        smooth < LEAST_SHARE * (smooth + specular)
    }

    fn meeting(&self, mut ray: Ray) -> Meeting {
        for _ in 0..MOST_BORDERS {
            let Some(hit) = self.intersect(&ray) else { return Meeting::Nothing };
            match self.material(hit.shape) {
                Material::Null(_) => ray = hit.ray_to(ray.direction),
                material if material.lobes().any(Lobes::SMOOTH) => return Meeting::Smooth,
                _ => return Meeting::Specular,
            }
        }
        Meeting::Nothing
    }
}
