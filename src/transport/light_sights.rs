//! Which lights are seen from a point, as photons and shadow photons near it tell [Jensen & Christensen 1995; Wald 1999, section 4.2.2].

use super::direct_light::LightSight;
use super::direct_photons::LIT_SEGMENTS;
use super::photon_map::{LightLookup, Nearest};

/// Fewer photons of a light decide nothing.
pub const LEAST_PHOTONS: u32 = 8;

/// How many photons and shadow photons of each light there are, of a few lights.
#[derive(Clone, Debug, Default)]
pub struct LightSights {
    lights: Vec<LightPhotons>,
}

#[derive(Clone, Copy, Debug)]
struct LightPhotons {
    light: usize,
    lit: u32,
    shadows: u32,
}

impl LightSights {
    /// Counts the photons that were found, instead of others.
    pub fn judge(&mut self, photons: &impl LightLookup, found: &Nearest) {
        self.lights.clear();
        for (_, index) in found.photons() {
            let light = photons.light(index) as usize;
            let known = self.lights.iter().position(|known| known.light == light).unwrap_or_else(|| {
                self.lights.push(LightPhotons { light, lit: 0, shadows: 0 });
                self.lights.len() - 1
            });
            let is_lit = photons.photon(index).segments() == LIT_SEGMENTS;
            let LightPhotons { lit, shadows, .. } = &mut self.lights[known];
            *(if is_lit { lit } else { shadows }) += 1;
        }
    }

    /// What they tell of a light.
    pub fn of(&self, light: usize) -> LightSight {
        match self.lights.iter().find(|known| known.light == light) {
            Some(LightPhotons { lit, shadows: 0, .. }) if *lit >= LEAST_PHOTONS => LightSight::Lit,
            Some(LightPhotons { lit: 0, shadows, .. }) if *shadows >= LEAST_PHOTONS => LightSight::Dark,
            _ => LightSight::Unknown,
        }
    }
}
