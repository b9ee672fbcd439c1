//! What one user may take of a farm, so that nobody fills it alone. Admins may take all; without users there is nobody to count.

use super::shared::{Shared, State};
use crate::farm::access::scope::Role;
use crate::farm::access::user::UserName;
use crate::farm::error::FarmError;
use crate::farm::job::StopRule;
use crate::farm::locks::lock;

impl Shared {
    /// Whether there are limits for a user.
    fn is_limited(&self, user: &UserName) -> bool {
        lock(&self.register).user(user).is_none_or(|user| user.role != Role::Admin)
    }

    /// Whether a user may have one more job of so many pixels.
    pub(super) fn check_user_jobs(
        &self,
        state: &State,
        user: Option<&UserName>,
        pixels: u64,
        stop: StopRule,
    ) -> Result<(), FarmError> {
        let Some(user) = user.filter(|user| self.is_limited(user)) else { return Ok(()) };
        let most = &self.options.limits.user;
        if stop.seconds.is_some_and(|seconds| seconds > most.seconds) {
            let problem = format!("stop.seconds is {}", stop.seconds.unwrap_or_default());
            return Err(FarmError::BadRequest { problem, remedy: format!("give at most {} seconds", most.seconds) });
        }
        let (mut jobs, mut taken) = (0, 0);
        for (id, _) in state.rules.jobs() {
            let Some(job) = state.jobs.get(&id).filter(|job| job.owner().as_ref() == Some(user)) else { continue };
            let description = job.description();
            jobs += 1;
            taken += u64::from(description.width) * u64::from(description.height);
        }
        if jobs >= most.live_jobs {
            return Err(self.busy(format!("{user} has {jobs} jobs that wait or run already")));
        }
        if taken + pixels > most.pixels {
            let problem =
                format!("{user}'s jobs that wait or run have {taken} pixels, and {} are allowed", most.pixels);
            return Err(self.busy(problem));
        }
        Ok(())
    }

    /// Whether a user may keep one more scene of so many bytes.
    pub(super) fn check_user_scenes(&self, user: Option<&UserName>, bytes: u64) -> Result<(), FarmError> {
        let Some(user) = user.filter(|user| self.is_limited(user)) else { return Ok(()) };
        let state = self.lock();
        let own = state.scenes.values().filter(|scene| scene.summary.owner.as_ref() == Some(user));
        let kept: u64 = own.map(|scene| scene.summary.bytes).sum();
        let most = self.options.limits.user.scene_bytes;
        if kept + bytes <= most {
            return Ok(());
        }
        Err(self.busy(format!("{user}'s scenes have {kept} bytes, and {most} are allowed; delete some first")))
    }

    fn busy(&self, problem: String) -> FarmError {
        FarmError::Busy { problem, retry_after: self.options.limits.retry_after() }
    }
}
