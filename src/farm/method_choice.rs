//! Which parameters a method gets in a scene, and which method suits it best.

use std::sync::atomic::AtomicBool;

use serde_json::{Map, Value};

use crate::evaluation::{RunError, Stopwatch, Survey, check_candidates, survey};
use crate::method::{MethodChoice, MethodError};
use crate::scene::{Integrator, Scene};

/// The method of a scene and a request that name none.
pub const DEFAULT_METHOD: &str = "sppm";
/// The name that stands for the method that trials find to be the fastest.
pub const AUTO: &str = "auto";
/// Parameters that mean the same for every method. `rr_depth` is not one: it changes the time that a method takes, not the
/// picture, and what suits path tracing does not suit photons.
const SHARED_PARAMETERS: [&str; 1] = ["max_depth"];
/// Mitsuba's integrators that are methods here under another name.
const COUNTERPARTS: [(&str, &str); 8] = [
    ("ptracer", "light_tracing"),
    ("photonmapper", "photon_map"),
    ("direct", "path"),
    ("volpath", "path"),
    ("volpathmis", "path"),
    ("prb", "path"),
    ("prb_basic", "path"),
    ("prbvolpath", "path"),
];
/// Parameters of Mitsuba's integrators that methods here do not have, and what happens instead.
const PASSED_OVER: [(&str, &str); 2] = [
    ("strict_normals", "directions that shading normals and surfaces disagree on are always dark"),
    ("samples_per_pass", "the farm cuts passes into shards by itself"),
];

/// Tries methods on the scene, on the calling rayon pool; which promises relMSE `wanted` soonest?
///
/// # Errors
/// Parameters that no candidate takes, time that cannot be measured, or `cancel`.
pub fn try_methods(
    scene: &Scene,
    requested: &Map<String, Value>,
    wanted: f64,
    stopwatch: &mut dyn Stopwatch,
    cancel: &AtomicBool,
) -> Result<Survey, RunError> {
    let integrator = scene.integrator.as_ref().map(|integrator| without_passed_over(integrator).0);
    survey(scene, |name| choice(name, requested, integrator.as_ref()), wanted, stopwatch, cancel)
}

/// Refuses parameters that no method to choose from takes, without trying any.
///
/// # Errors
/// What the first of them has against them.
pub fn check_trials(
    requested: &Map<String, Value>,
    integrator: Option<&Integrator>,
    pixels: u64,
) -> Result<(), MethodError> {
    let integrator = integrator.map(|integrator| without_passed_over(integrator).0);
    check_candidates(|name| choice(name, requested, integrator.as_ref()), pixels)
}

/// The method that a survey found, with the parameters that set its trial apart; or the default.
pub fn best_method(found: &Survey) -> MethodChoice {
    match found.best() {
        Some(best) => MethodChoice { name: best.method.choice.name.clone(), parameters: best.own.clone() },
        None => MethodChoice { name: DEFAULT_METHOD.to_owned(), parameters: Map::new() },
    }
}

/// The integrator under the name that it has here, without parameters that are passed over, and what to say of those.
pub fn without_passed_over(integrator: &Integrator) -> (Integrator, Vec<String>) {
    let mut own = integrator.clone();
    if let Some((_, here)) = COUNTERPARTS.iter().find(|(theirs, _)| *theirs == own.name) {
        own.name = (*here).to_owned();
    }
    let mut notices = Vec::new();
    for (name, instead) in PASSED_OVER {
        // Where it is off it asks for what happens anyway.
        if own.parameters.remove(name).is_some_and(|value| value != Value::Bool(false)) {
            notices.push(format!("The integrator's \"{name}\" is passed over: {instead}."));
        }
    }
    (own, notices)
}

/// The scene's parameters as far as they are meant for `name`, overridden by the request's.
pub fn choice(name: &str, requested: &Map<String, Value>, integrator: Option<&Integrator>) -> MethodChoice {
    let mut parameters: Map<String, Value> = integrator.map(|own| own.parameters.clone()).unwrap_or_default();
    if integrator.is_some_and(|own| own.name != name) {
        parameters.retain(|parameter, _| SHARED_PARAMETERS.contains(&parameter.as_str()));
    }
    parameters.extend(requested.clone());
    MethodChoice { name: name.to_owned(), parameters }
}
