//! What one user may take of a farm, so that nobody fills it alone. Admins may take all; without users there is nobody to count.

use std::sync::Arc;

use super::shared::{Shared, State};
use crate::farm::access::scope::Role;
use crate::farm::access::user::UserName;
use crate::farm::error::FarmError;
use crate::farm::job::StopRule;
use crate::farm::locks::lock;

/// An upload of a user that is on its way.
pub(super) struct OwnUpload {
    shared: Arc<Shared>,
    user: UserName,
}

impl Drop for OwnUpload {
    fn drop(&mut self) {
        let mut uploading = lock(&self.shared.uploading);
        if let Some(own) = uploading.get_mut(&self.user) {
            *own -= 1;
        }
        uploading.retain(|_, own| *own > 0);
    }
}

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

    /// Counts one more upload of a user, until the answer is dropped. Half of all places is for one user.
    pub(super) fn take_upload_of(self: &Arc<Self>, user: Option<&UserName>) -> Result<Option<OwnUpload>, FarmError> {
        let Some(user) = user.filter(|user| self.is_limited(user)) else { return Ok(None) };
        let most = (self.options.limits.uploads / 2).max(1);
        let mut uploading = lock(&self.uploading);
        let own = uploading.entry(user.clone()).or_default();
        if *own >= most {
            return Err(self.busy(format!("{user} uploads {own} scenes already")));
        }
        *own += 1;
        Ok(Some(OwnUpload { shared: self.clone(), user: user.clone() }))
    }

    /// A refusal for now.
    pub(super) fn busy(&self, problem: String) -> FarmError {
        FarmError::Busy { problem, retry_after: self.options.limits.retry_after() }
    }
}
