//! Which methods keep the light of which groups apart. All do: each group is traced as a scene of its own.

use super::{CheckedMethod, MethodError};
use crate::scene::light::groups::MOST_GROUPS;

/// Whether a job by `method`, or by one that is not chosen yet, can keep these groups apart.
///
/// # Errors
/// There are too many, or parameters name places that only one group's lights have.
pub fn check_light_groups(method: Option<&CheckedMethod>, groups: &[String]) -> Result<(), MethodError> {
    if groups.len() > MOST_GROUPS {
        let problem = format!("the scene has {}", groups.len());
        return Err(MethodError::LightGroups { problem, remedy: format!("give its lights at most {MOST_GROUPS}") });
    }
    if method.is_some_and(CheckedMethod::names_places) {
        let problem = "user_paths begin at lamps, which only one group has".to_owned();
        let remedy = "leave user_paths or light_groups out".to_owned();
        return Err(MethodError::LightGroups { problem, remedy });
    }
    Ok(())
}
