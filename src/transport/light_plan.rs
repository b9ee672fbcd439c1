//! How often each light is sampled at a point: some picks as everywhere, others by the photons that lie near [Wald 1999, section 4.2.3].
//!
//! The thesis gives samples to the lights of the photons that were found, and one to all other lights together, each as likely. Here that one
//! is picked as everywhere else, from all lights: no pick is lost on a set that must be told apart, and a light that photons missed weighs
//! as much as its usual pick says, not as the number of lights. Both kinds are one deterministic mixture [Veach 1997, section 9.2]: a sample of a
//! light counts over the number of samples that the light gets on average, so that the result is right whatever photons say.

use crate::math::Rgb;
use crate::math::color::luminance;
use crate::math::discrete::ONE_MINUS_EPSILON;
use crate::math::random::{PathRandom, dimension, spread_row};
use crate::scene::Scene;
use crate::scene::light::{LightPick, Place};

/// The energy that arrived from each light, of a few lights.
#[derive(Clone, Debug, Default)]
pub struct LightEnergies {
    lights: Vec<LightEnergy>,
    total: f32,
}

#[derive(Clone, Copy, Debug)]
struct LightEnergy {
    light: usize,
    energy: f32,
}

impl LightEnergies {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.lights.clear();
        self.total = 0.0;
    }

    /// Adds a photon of a light.
    pub fn add(&mut self, light: usize, flux: Rgb) {
        let energy = luminance(flux);
        if energy <= 0.0 {
            return;
        }
        self.total += energy;
        match self.lights.iter_mut().find(|known| known.light == light) {
            Some(known) => known.energy += energy,
            None => self.lights.push(LightEnergy { light, energy }),
        }
    }

    /// Whether no light brought anything.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// The share of a light.
    pub fn share(&self, light: usize) -> f32 {
        self.lights.iter().find(|known| known.light == light).map_or(0.0, |known| known.energy / self.total)
    }
}

/// How often lights are sampled at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightPlan<'a> {
    /// Picks as everywhere.
    pub usual: u32,
    /// Picks in proportion to what photons brought; none where there are no photons.
    pub by_photons: u32,
    /// What photons brought.
    pub energies: &'a LightEnergies,
}

impl LightPlan<'_> {
    /// How many samples a light gets on average.
    pub fn picks(&self, scene: &Scene, place: &Place, light: usize) -> f32 {
        let usual = self.usual as f32 * scene.lights.probability(place, light);
        usual + self.by_photons as f32 * self.energies.share(light)
    }

    /// Shows every pick for the vertex `vertex` at `place` to `sample`, with two numbers for a point of the light.
    #[inline]
    pub fn for_each_sample(
        &self,
        scene: &Scene,
        place: &Place,
        vertex: u32,
        random: &PathRandom,
        mut sample: impl FnMut(LightPick, [f32; 2]),
    ) {
        let [x, y, shift, _] = random.block(dimension::light(vertex));
        for index in 0..self.usual {
            let u = ((index as f32 + shift) / self.usual as f32).min(ONE_MINUS_EPSILON);
            let Some((light, probability)) = scene.lights.pick(place, u) else { break };
            let picks = self.usual as f32 * probability + self.by_photons as f32 * self.energies.share(light);
            sample(LightPick { index: light, picks }, spread_row([x, y], index));
        }
        if self.by_photons == 0 || self.energies.is_empty() {
            return;
        }
        let [x, y, shift, _] = random.block(dimension::guided_light(vertex));
        // Picks at equal distances: of each light as many as its share, rounded up or down.
        let (mut index, mut sum) = (0, 0.0);
        for known in &self.energies.lights {
            sum += known.energy;
            let end = (self.by_photons as f32 * (sum / self.energies.total) - shift).ceil() as u32;
            if index < end {
                let picks = self.picks(scene, place, known.light);
                (index..end).for_each(|index| {
                    sample(LightPick { index: known.light, picks }, spread_row([x, y], index));
                });
                index = end;
            }
        }
    }
}
