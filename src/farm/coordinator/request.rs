//! From what a user asks for to a job that workers can trace: which method, which parameters, when to stop.

use serde_json::{Map, Value};

use crate::evaluation::{DEFAULT_ERROR, ProcessStopwatch, RunError, Survey, survey};
use crate::farm::error::FarmError;
use crate::farm::job::{JobRequest, StopRule};
use crate::method::{self, CheckedMethod, MethodChoice, MethodError, SceneTraits};
use crate::scene::{Integrator, Scene};

/// The method of a scene and a request that name none.
const DEFAULT_METHOD: &str = "sppm";
/// The name that stands for the method that trials find to be the fastest.
pub const AUTO: &str = "auto";
/// Parameters that mean the same for every method. `rr_depth` is not one: it changes the time that a method takes, not the
/// picture, and what suits path tracing does not suit photons.
const SHARED_PARAMETERS: [&str; 1] = ["max_depth"];
const PASSES_LIMIT: u32 = 1 << 31;
/// Mitsuba's integrators that are methods here under another name.
const COUNTERPARTS: [(&str, &str); 3] =
    [("ptracer", "light_tracing"), ("volpath", "path"), ("photonmapper", "photon_map")];
/// Parameters of Mitsuba's integrators that methods here do not have, and what happens instead.
const PASSED_OVER: [(&str, &str); 3] = [
    ("hide_emitters", "lamps are always seen"),
    ("strict_normals", "directions that shading normals and surfaces disagree on are always dark"),
    ("samples_per_pass", "the farm cuts passes into shards by itself"),
];

/// A method that was checked, and what the user should know of the choice.
pub struct ResolvedMethod {
    /// The method with all parameters.
    pub method: CheckedMethod,
    /// One sentence each.
    pub notices: Vec<String>,
}

/// Whether a request leaves the choice of the method to trials.
pub fn asks_for_auto(request: &JobRequest) -> bool {
    request.method.as_deref() == Some(AUTO)
}

/// Tries methods on the scene and names the one that promises the wanted error soonest; what it found.
///
/// # Errors
/// Parameters that no candidate takes.
pub fn choose_method(request: &mut JobRequest, scene: Scene) -> Result<Survey, FarmError> {
    let integrator = scene.integrator.as_ref().map(|integrator| without_passed_over(integrator).0);
    let wanted = request.stop.error.unwrap_or(DEFAULT_ERROR);
    let internal = |problem: &dyn std::fmt::Display| FarmError::Internal(problem.to_string());
    let mut stopwatch = ProcessStopwatch::start().map_err(|problem| internal(&problem))?;
    let found = survey(scene, |name| choice(name, request, integrator.as_ref()), wanted, &mut stopwatch);
    let found = found.map_err(|problem| match problem {
        RunError::Method(problem) => FarmError::BadMethod(problem),
        other => internal(&other),
    })?;
    request.method = Some(found.best().map_or(DEFAULT_METHOD.to_owned(), |best| best.method.choice.name.clone()));
    Ok(found)
}

/// Chooses the method: the request's, else the scene's integrator, else `sppm`.
pub fn resolve_method(
    request: &JobRequest,
    integrator: Option<&Integrator>,
    pixels: u64,
    traits: SceneTraits,
) -> Result<ResolvedMethod, FarmError> {
    let (integrator, mut notices) = integrator.map_or((None, Vec::new()), |integrator| {
        let (integrator, notices) = without_passed_over(integrator);
        (Some(integrator), notices)
    });
    let integrator = integrator.as_ref();
    let wanted = integrator.map_or(DEFAULT_METHOD, |integrator| integrator.name.as_str());
    let check = |name: &str| method::check(&choice(name, request, integrator), pixels);
    let method = match (&request.method, check(request.method.as_deref().unwrap_or(wanted))) {
        (_, Ok(method)) => {
            // A method that the user chose does not have the integrator's parameters.
            if request.method.is_some() {
                notices.clear();
            }
            method
        }
        (None, Err(MethodError::Unknown { name, .. })) if name != DEFAULT_METHOD => {
            let notice = format!("The scene's integrator \"{name}\" is not a method here; {DEFAULT_METHOD} is used.");
            notices = vec![notice];
            check(DEFAULT_METHOD)?
        }
        (_, Err(problem)) => return Err(problem.into()),
    };
    notices.extend(method::notices(&method, traits));
    Ok(ResolvedMethod { method, notices })
}

/// The integrator under the name that it has here, without parameters that are passed over, and what to say of those.
fn without_passed_over(integrator: &Integrator) -> (Integrator, Vec<String>) {
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
fn choice(name: &str, request: &JobRequest, integrator: Option<&Integrator>) -> MethodChoice {
    let mut parameters: Map<String, Value> = integrator.map(|own| own.parameters.clone()).unwrap_or_default();
    if integrator.is_some_and(|own| own.name != name) {
        parameters.retain(|parameter, _| SHARED_PARAMETERS.contains(&parameter.as_str()));
    }
    parameters.extend(request.parameters.clone());
    MethodChoice { name: name.to_owned(), parameters }
}

/// Checks a stop rule and completes it: without any rule the method's own passes count.
pub fn resolve_stop(stop: StopRule, method: &CheckedMethod) -> Result<StopRule, FarmError> {
    check_stop(stop)?;
    let says_nothing = stop.passes.is_none() && stop.seconds.is_none() && stop.error.is_none();
    Ok(StopRule { passes: if says_nothing { Some(method.passes) } else { stop.passes }, ..stop })
}

/// Checks the numbers of a stop rule.
pub fn check_stop(stop: StopRule) -> Result<(), FarmError> {
    if stop.passes.is_some_and(|passes| !(1..=PASSES_LIMIT).contains(&passes)) {
        return Err(FarmError::BadRequest {
            problem: format!("stop.passes is {}", stop.passes.unwrap_or_default()),
            remedy: format!("give 1 to {PASSES_LIMIT} passes"),
        });
    }
    if stop.seconds.is_some_and(|seconds| !(seconds.is_finite() && seconds > 0.0)) {
        return Err(FarmError::BadRequest {
            problem: format!("stop.seconds is {}", stop.seconds.unwrap_or_default()),
            remedy: "give a number above 0".to_owned(),
        });
    }
    if stop.error.is_some_and(|error| !(error.is_finite() && error > 0.0)) {
        return Err(FarmError::BadRequest {
            problem: format!("stop.error is {}", stop.error.unwrap_or_default()),
            remedy: "give a relMSE above 0, as 0.01".to_owned(),
        });
    }
    Ok(())
}
