//! The same lights, known or picked in another way.

use std::sync::Arc;

use super::super::dark::Dark;
use super::super::groups::LightGroups;
use super::{Discrete, Emission, ImportanceSampler, Light, LightTable, LightVisibility, few_emitters};
use crate::math::color::luminance;
use crate::scene::texture::Texture;

impl LightTable {
    /// The same table with what the user calls the lights, by index.
    #[must_use]
    pub fn with_names(self, names: Vec<String>) -> Self {
        Self { names: names.into(), ..self }
    }

    /// The same table with what is seen and lights nothing.
    #[must_use]
    pub fn with_seen_only(self, seen_only: Vec<Emission>) -> Self {
        Self { seen_only, ..self }
    }

    /// The same table with the groups that its lights belong to.
    #[must_use]
    pub fn with_groups(self, groups: LightGroups) -> Self {
        Self { groups: groups.into(), ..self }
    }

    /// The same table with picks that know which lights are seen where.
    #[must_use]
    pub fn with_visibility(&self, visibility: LightVisibility) -> Self {
        Self { visibility: Some(visibility), ..self.clone() }
    }

    /// The same table with photons and light subpaths that come from lights with these probabilities, by index; `None` when they are none.
    #[must_use]
    pub fn with_emission_picks(&self, probabilities: &[f64]) -> Option<Self> {
        let by_emission = Discrete::new(probabilities).filter(|_| probabilities.len() == self.lights.len())?;
        Some(Self { by_emission, ..self.clone() })
    }

    /// The groups that lights belong to.
    pub fn groups(&self) -> &LightGroups {
        &self.groups
    }

    /// The light of group `group` alone: lights of other groups keep their indices and their surfaces, and emit nothing.
    #[must_use]
    pub fn only(&self, group: usize) -> Self {
        let of_group = |(index, light): (usize, &Light)| match self.groups.has_light(group, index) {
            true => light.clone(),
            false => Light::Dark(Dark),
        };
        let mut lights: Vec<Light> = self.lights.iter().enumerate().map(of_group).collect();
        let powers: Vec<f64> = lights.iter().map(|light| f64::from(luminance(light.power()))).collect();
        // Nothing that is picked of a group without power emits, so that it may be picked in any way.
        let by_power = Discrete::new(&powers).unwrap_or_else(|| {
            lights.fill(Light::Dark(Dark));
            self.by_power.clone()
        });
        let share = |light: usize| f32::from(u8::from(!lights[light].is_dark()));
        let seen_only =
            self.seen_only.iter().enumerate().map(|(index, emission)| match self.groups.has_seen(group, index) {
                true => emission.clone(),
                false => Emission { radiance: Texture::grey(0.0), ..emission.clone() },
            });
        Self {
            by_place: ImportanceSampler::of_shares(&self.importances, self.nearest, share),
            seen_only: seen_only.collect(),
            environment: lights.iter().position(Light::is_environment),
            has_extent: lights.iter().any(Light::has_extent),
            few_emitters: few_emitters(&lights),
            by_emission: by_power.clone(),
            by_power,
            visibility: None,
            lights: Arc::from(lights),
            ..self.clone()
        }
    }

    /// Whether no light emits anything, as of a group whose lights are black.
    pub fn is_dark(&self) -> bool {
        self.lights.iter().all(Light::is_dark)
    }
}
