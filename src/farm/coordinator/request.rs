//! From what a user asks for to a job that workers can trace: which method, which parameters, when to stop.

use super::limits::Limits;
use crate::farm::cut::Cut;
use crate::farm::error::FarmError;
use crate::farm::job::{JobRequest, StopRule};
use crate::farm::method_choice::{AUTO, DEFAULT_METHOD, choice, without_passed_over};
use crate::farm::text::is_hidden;
use crate::method::{self, CheckedMethod, MethodError, SceneTraits};
use crate::scene::Integrator;
use crate::scene::light::groups::OTHERS;

/// A method that was checked, and what the user should know of the choice.
pub(crate) struct ResolvedMethod {
    /// The method with all parameters.
    pub method: CheckedMethod,
    /// One sentence each.
    pub notices: Vec<String>,
}

/// Whether a request leaves the choice of the method to trials.
pub(crate) fn asks_for_auto(request: &JobRequest) -> bool {
    request.method.as_deref() == Some(AUTO)
}

/// Chooses the method: the request's, else the scene's integrator, else `sppm`.
pub(crate) fn resolve_method(
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
    let check = |name: &str| method::check(&choice(name, &request.parameters, integrator), pixels);
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
    method::check_media(&method, traits)?;
    notices.extend(method::notices(&method, traits));
    Ok(ResolvedMethod { method, notices })
}

/// The light groups that a request keeps apart, of those that its scene names; none unless it asks for that.
///
/// # Errors
/// See [`method::check_light_groups`].
pub(crate) fn resolve_light_groups(
    request: &JobRequest,
    of_scene: &[String],
    method: Option<&CheckedMethod>,
) -> Result<Vec<String>, FarmError> {
    if !request.light_groups {
        return Ok(Vec::new());
    }
    // Where no light names one, all are others.
    let groups = if of_scene.is_empty() { vec![OTHERS.to_owned()] } else { of_scene.to_vec() };
    method::check_light_groups(method, &groups)?;
    Ok(groups)
}

/// Checks a stop rule and completes it: without any rule the method's own passes count.
pub(crate) fn resolve_stop(stop: StopRule, method: &CheckedMethod, limits: &Limits) -> Result<StopRule, FarmError> {
    check_stop(stop, limits)?;
    Ok(StopRule { passes: if stop.is_empty() { Some(method.passes) } else { stop.passes }, ..stop })
}

/// Checks the numbers of a stop rule.
pub(crate) fn check_stop(stop: StopRule, limits: &Limits) -> Result<(), FarmError> {
    if stop.passes.is_some_and(|passes| !(1..=limits.passes).contains(&passes)) {
        return Err(FarmError::BadRequest {
            problem: format!("stop.passes is {}", stop.passes.unwrap_or_default()),
            remedy: format!("give 1 to {} passes", limits.passes),
        });
    }
    if stop.seconds.is_some_and(|seconds| !(seconds > 0.0 && seconds <= limits.seconds)) {
        return Err(FarmError::BadRequest {
            problem: format!("stop.seconds is {}", stop.seconds.unwrap_or_default()),
            remedy: format!("give a number above 0, and at most {}", limits.seconds),
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

/// Checks that a method which never finds some of the light is not asked for an error that its own passes tell, unless that is accepted.
pub(crate) fn check_finds_light(stop: StopRule, method: &CheckedMethod, traits: SceneTraits) -> Result<(), FarmError> {
    match method::blind_spot(method, traits) {
        Some(blind_spot) if stop.error.is_some() && !stop.accepts_missing_light => Err(FarmError::BadRequest {
            problem: format!("stop.error would be met without some of the light: {}", blind_spot.trim_end_matches('.')),
            remedy: "choose such a method, or set stop.accepts_missing_light (--accept-missing-light)".to_owned(),
        }),
        _ => Ok(()),
    }
}

/// Checks the numbers of a cut.
pub(crate) fn check_cut(cut: Cut) -> Result<(), FarmError> {
    if let Some(passes) = cut.passes_per_shard.filter(|passes| !(1..=Cut::MOST_PASSES).contains(passes)) {
        let problem = format!("cut.passes_per_shard is {passes}");
        return Err(FarmError::BadRequest { problem, remedy: format!("give 1 to {} passes", Cut::MOST_PASSES) });
    }
    let is_right = |shards: u32| (2..=Cut::MOST_SHARDS).contains(&shards) && shards.is_multiple_of(2);
    if let Some(shards) = cut.shards_per_epoch.filter(|shards| !is_right(*shards)) {
        let problem = format!("cut.shards_per_epoch is {shards}");
        let remedy = format!("give an even number from 2 to {}", Cut::MOST_SHARDS);
        return Err(FarmError::BadRequest { problem, remedy });
    }
    Ok(())
}

/// Checks name and tags.
pub(crate) fn check_labels(request: &JobRequest, limits: &Limits) -> Result<(), FarmError> {
    let Limits { name_bytes, tags, tag_bytes, .. } = *limits;
    let labels = request.name.iter().chain(&request.tags);
    if labels.flat_map(|label| label.chars()).any(is_hidden) {
        let problem = "name or tags hold control characters".to_owned();
        return Err(FarmError::BadRequest { problem, remedy: "leave them out".to_owned() });
    }
    if request.name.as_ref().is_some_and(|name| name.len() > name_bytes) {
        let problem = "the name is too long".to_owned();
        return Err(FarmError::BadRequest { problem, remedy: format!("give at most {name_bytes} bytes") });
    }
    if request.tags.len() > tags || request.tags.iter().any(|tag| tag.is_empty() || tag.len() > tag_bytes) {
        let problem = "the tags are too many or too long, or one is empty".to_owned();
        let remedy = format!("give at most {tags} tags of 1 to {tag_bytes} bytes");
        return Err(FarmError::BadRequest { problem, remedy });
    }
    Ok(())
}
