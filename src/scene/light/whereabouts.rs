//! Where lights are, for people who look for them: what each is called, of which kind it is, and some of its places.

use super::importance::LightImportance;
use super::{Light, LightTable};
use crate::math::Vec3;
use crate::math::color::luminance;
use crate::scene::geometry::Geometry;

/// Places of an emitting shape that are told.
const PLACES: u16 = 8;

/// A light that has a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Whereabouts {
    /// What the user calls it, or empty.
    pub name: String,
    /// Its plugin.
    pub kind: &'static str,
    /// Where it shines from, m: of an emitting shape some places spread over it, of others the one that there is.
    pub points: Vec<Vec3>,
}

impl LightTable {
    /// The lights that have a place, those of most power first. Skies, suns and beams have none.
    pub fn whereabouts(&self, geometry: &Geometry) -> Vec<Whereabouts> {
        let mut found: Vec<(f32, Whereabouts)> = Vec::new();
        for (index, light) in self.lights().iter().enumerate() {
            let points = points(light, self.importance(index), geometry);
            if !points.is_empty() {
                let name = self.name(index).to_owned();
                found.push((luminance(light.power()), Whereabouts { name, kind: kind(light), points }));
            }
        }
        found.sort_by(|(one, _), (other, _)| other.total_cmp(one));
        found.into_iter().map(|(_, light)| light).collect()
    }
}

fn points(light: &Light, importance: &LightImportance, geometry: &Geometry) -> Vec<Vec3> {
    match (light, importance) {
        (Light::AreaLight(area), _) => {
            let photons = (0..PLACES).filter_map(|place| area.emit(geometry, spread(place), [0.25, 0.5]));
            photons.filter(|photon| luminance(photon.flux) > 0.0).map(|photon| photon.origin).collect()
        }
        (_, LightImportance::Near(lamp)) => vec![lamp.center],
        (_, LightImportance::Far { .. }) => Vec::new(),
    }
}

/// Points of the unit square, the middle first [R₂ sequence, Roberts 2018].
fn spread(place: u16) -> [f32; 2] {
    [0.754_877_7, 0.569_840_3].map(|step: f32| (0.5 + step * f32::from(place)).fract())
}

fn kind(light: &Light) -> &'static str {
    match light {
        Light::AreaLight(_) => "area",
        Light::DirectionalArea(_) => "directionalarea",
        Light::Point(_) => "point",
        Light::Spot(_) => "spot",
        Light::Ies(_) => "ies",
        Light::Projector(_) => "projector",
        Light::Directional(_) => "directional",
        Light::Constant(_) => "constant",
        Light::EnvironmentMap(_) => "envmap",
        Light::SunSky(_) => "sunsky",
        Light::Dark(_) => "dark",
    }
}
