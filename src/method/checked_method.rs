//! A method with its parameters, checked and read once: what coordinator and workers agree on.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::parameter_values::LightPicks;
use super::parameters::WrittenOut;
use super::visibility_pilot::LightSampling;
use super::{Bias, MethodChoice, MethodEntry, MethodError, PreparedMethod, SceneTraits, Strategy, entry};
use crate::estimate::{Declaration, RadiusRule};
use crate::scene::Scene;
use crate::transport::counters::Step;

/// What a method makes of its parameters. Every method's struct of parameters implements it.
pub trait ParameterizedMethod: WrittenOut + fmt::Debug + Send + Sync {
    /// Photons or light subpaths of a pass, for a picture of so many pixels. A parameter that is `auto` becomes that number.
    fn settle_photons(&mut self, pixels: u64) -> u32;

    /// Passes to make when the job names no stop rule.
    fn passes(&self) -> u32;

    /// What is gathered in discs.
    fn gathering(&self) -> Gathering;

    /// Whether its pilot may find a guide for photons.
    fn may_guide_photons(&self) -> bool {
        false
    }

    /// How it samples lights, if it does.
    fn light_sampling(&self) -> Option<LightSampling> {
        None
    }

    /// The kinds of proposals that its chains are made, if it has chains; counted in
    /// [`Counters::steps`](crate::transport::Counters).
    fn proposals(&self) -> &'static [Step] {
        &[]
    }

    /// What becomes of its bias, where the table says `usual` of the method.
    fn bias(&self, usual: Bias) -> Bias {
        usual
    }

    /// Light of a scene with such traits that it never finds, if there is any, and methods that do.
    fn blind_to(&self, _traits: SceneTraits) -> Option<&'static str> {
        None
    }

    /// Which of its parameters bring nothing in a scene with such traits, if any does, and what does instead.
    fn futile_in(&self, _traits: SceneTraits) -> Option<&'static str> {
        None
    }

    /// The ways of finding paths that it tells apart, up to so many segments; `None` for methods that have no `strategy`.
    fn strategies(&self, _longest: u32) -> Option<Vec<Strategy>> {
        None
    }

    /// Why no path at all counts, or how parameters contradict each other or are left without effect, if so.
    fn contradiction(&self) -> Option<Contradiction> {
        None
    }

    /// Whether [`ParameterizedMethod::refuses`] has anything to look at.
    fn names_places(&self) -> bool {
        false
    }

    /// What of its parameters does not fit a scene, if something does not.
    fn refuses(&self, _scene: &Scene) -> Option<Contradiction> {
        None
    }

    /// Prepares it for a scene that it does not refuse.
    fn prepare(&self, scene: Arc<Scene>, photons_per_pass: u32, seed: u64) -> Box<dyn PreparedMethod>;
}

/// Parameters that together leave no path that counts, contradict each other, or are left without effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// What is wrong with them.
    pub problem: String,
    /// What to give instead.
    pub remedy: String,
}

/// What a method gathers in discs around what pixels see, and what becomes of the discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gathering {
    /// Nothing: pixels have no radius.
    Nothing,
    /// Photons, in discs that stay as they are.
    FixedDiscs,
    /// Photons, in discs that shrink.
    ShrinkingDiscs {
        /// How.
        rule: RadiusRule,
        /// α of the rule, between 0 and 1.
        alpha: f64,
    },
}

impl Gathering {
    /// What tallies hold.
    pub fn declaration(self) -> Declaration {
        match self {
            Self::Nothing => Declaration::radiance_only(),
            // A schedule that keeps every photon keeps the radius.
            Self::FixedDiscs => Declaration::gathering(RadiusRule::Schedule, 1.0),
            Self::ShrinkingDiscs { rule, alpha } => Declaration::gathering(rule, alpha),
        }
    }
}

/// A choice that was checked, with its parameters as the method reads them.
#[derive(Clone, Serialize, Deserialize)]
#[serde(into = "CheckedRecord", try_from = "CheckedRecord")]
pub struct CheckedMethod {
    /// The choice with every parameter written out.
    pub choice: MethodChoice,
    /// Photons or light subpaths of a pass.
    pub photons_per_pass: u32,
    /// Passes to make when the job names no stop rule.
    pub passes: u32,
    pub(super) entry: &'static MethodEntry,
    pub(super) parameters: Arc<dyn ParameterizedMethod>,
}

impl CheckedMethod {
    /// Whether its parameters name places in a scene, so that only a prepared one can tell whether they fit.
    pub fn names_places(&self) -> bool {
        self.parameters.names_places()
    }

    /// An error where there is something to refuse.
    pub(super) fn refuse(&self, found: Option<Contradiction>) -> Result<(), MethodError> {
        let error = |Contradiction { problem, remedy }| {
            let method = self.entry.name;
            MethodError::Parameter { method, problem, remedy }
        };
        found.map(error).map_or(Ok(()), Err)
    }

    /// Checks `choice` for a picture of so many pixels.
    pub(super) fn new(choice: &MethodChoice, pixels: u64) -> Result<Self, MethodError> {
        let entry = entry(&choice.name)?;
        let mut parameters = (entry.read)(entry.name, &choice.parameters)?;
        let photons_per_pass = parameters.settle_photons(pixels);
        let choice = MethodChoice { name: choice.name.clone(), parameters: parameters.written_out() };
        let passes = parameters.passes();
        Ok(Self { choice, photons_per_pass, passes, entry, parameters: parameters.into() })
    }

    /// Whether its pilot may find what its passes then need: a guide for photons, or which lights are seen where.
    pub fn may_be_guided(&self) -> bool {
        let samples = |sampling: LightSampling| sampling.picks != LightPicks::Importance;
        self.parameters.may_guide_photons() || self.parameters.light_sampling().is_some_and(samples)
    }

    /// How it samples lights, if it does.
    pub fn light_sampling(&self) -> Option<LightSampling> {
        self.parameters.light_sampling()
    }
}

impl fmt::Debug for CheckedMethod {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { choice, photons_per_pass, parameters, .. } = self;
        let mut shown = formatter.debug_struct("CheckedMethod");
        shown.field("name", &choice.name).field("parameters", parameters).field("photons_per_pass", photons_per_pass);
        shown.finish_non_exhaustive()
    }
}

impl PartialEq for CheckedMethod {
    fn eq(&self, other: &Self) -> bool {
        // All else follows from these.
        self.choice == other.choice && self.photons_per_pass == other.photons_per_pass
    }
}

/// A checked method as it is stored and sent.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CheckedRecord {
    choice: MethodChoice,
    /// This and the next two follow from the choice; a reader need not know the method to see them.
    radius_rule: RadiusRule,
    alpha: f64,
    photons_per_pass: u32,
    passes: u32,
}

impl From<CheckedMethod> for CheckedRecord {
    fn from(method: CheckedMethod) -> Self {
        let Declaration { radius_rule, alpha, .. } = method.parameters.gathering().declaration();
        let CheckedMethod { choice, photons_per_pass, passes, .. } = method;
        Self { choice, radius_rule, alpha, photons_per_pass, passes }
    }
}

/// Parameters that methods got later, and the value of each that does what they did before: a record has all parameters of its time, so
/// a job that was stored without one goes on to the bits that it began.
const LATER_PARAMETERS: [(&str, &str); 3] =
    [("emission", "power"), ("light_picks", "importance"), ("occlusion", "off")];

impl TryFrom<CheckedRecord> for CheckedMethod {
    type Error = MethodError;

    fn try_from(mut record: CheckedRecord) -> Result<Self, MethodError> {
        let known = entry(&record.choice.name)?.parameters;
        for (name, before) in LATER_PARAMETERS {
            if known.iter().any(|parameter| parameter.name == name) {
                record.choice.parameters.entry(name).or_insert_with(|| before.into());
            }
        }
        // Where the choice holds no number of photons there is one per pixel, so the number of photons is that of pixels.
        let checked = Self::new(&record.choice, record.photons_per_pass.into())?;
        if (checked.photons_per_pass, checked.passes) == (record.photons_per_pass, record.passes) {
            return Ok(checked);
        }
        let problem = format!(
            "its record says {} photons per pass and {} passes, its parameters say {} and {}",
            record.photons_per_pass, record.passes, checked.photons_per_pass, checked.passes
        );
        let remedy = "submit the job again".to_owned();
        Err(MethodError::Parameter { method: checked.entry.name, problem, remedy })
    }
}
