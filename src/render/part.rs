//! A method that is prepared for a scene, or for the light of one of its groups.

use std::sync::Arc;

use super::{GuideError, Guides};
use crate::method::{self, CheckedMethod, MethodError, PreparedMethod};
use crate::scene::Scene;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::scene::light::{LightTable, LightVisibility};

/// A prepared method, and where its photons start.
#[derive(Clone)]
pub(super) struct Part {
    pub(super) scene: Arc<Scene>,
    pub(super) method: Arc<dyn PreparedMethod>,
    pub(super) guide: Option<Arc<EmissionGuide>>,
}

impl Part {
    /// Prepares `checked` for `scene`.
    pub(super) fn new(scene: Arc<Scene>, checked: &CheckedMethod, seed: u64) -> Result<Self, MethodError> {
        Ok(Self { method: method::prepare(scene.clone(), checked, seed)?.into(), scene, guide: None })
    }

    /// The same with what a pilot learnt of all lights of the scene; a group's lights are picked by what is left of it.
    pub(super) fn guided(&self, guides: &Guides, checked: &CheckedMethod, seed: u64) -> Result<Self, GuideError> {
        let lights = &self.scene.lights;
        if lights.is_dark() {
            return Ok(self.clone());
        }
        let mut picks: Option<LightTable> = None;
        let mut guide = None;
        if !guides.visibility.is_empty() {
            picks = Some(lights.with_visibility(LightVisibility::new(&guides.visibility, lights)?));
        }
        if !guides.emission.is_empty() {
            let found = EmissionGuide::new(&guides.emission, lights)?;
            match found.picks_lights_alone() {
                true => {
                    let probabilities: Vec<f64> = found.probabilities().collect();
                    picks = picks.as_ref().unwrap_or(lights).with_emission_picks(&probabilities);
                }
                false => guide = Some(Arc::new(found)),
            }
        }
        let Some(picks) = picks else { return Ok(Self { guide, ..self.clone() }) };
        Ok(Self { guide, ..Self::new(Arc::new(self.scene.with_lights(picks)), checked, seed)? })
    }
}
