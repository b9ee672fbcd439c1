//! Browsers that were sent to the provider and are not back yet.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use openidconnect::{Nonce, PkceCodeVerifier};

/// For how long a browser may stay away.
const PATIENCE: Duration = Duration::from_secs(600);
/// Browsers on their way at most; the ones that left first are forgotten.
const MOST: usize = 10_000;

/// What only this coordinator knows of a browser on its way.
pub(super) struct Pending {
    pub(super) nonce: Nonce,
    pub(super) verifier: PkceCodeVerifier,
    since: Instant,
}

/// All browsers on their way, by the state that they bring back.
#[derive(Default)]
pub(super) struct PendingLogins(BTreeMap<String, Pending>);

impl PendingLogins {
    pub(super) fn add(&mut self, state: String, nonce: Nonce, verifier: PkceCodeVerifier) {
        self.0.retain(|_, pending| pending.since.elapsed() < PATIENCE);
        while self.0.len() >= MOST {
            let oldest = self.0.iter().min_by_key(|(_, pending)| pending.since).map(|(state, _)| state.clone());
            oldest.and_then(|state| self.0.remove(&state));
        }
        self.0.insert(state, Pending { nonce, verifier, since: Instant::now() });
    }

    /// Each comes back once.
    pub(super) fn take(&mut self, state: &str) -> Option<Pending> {
        self.0.remove(state).filter(|pending| pending.since.elapsed() < PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verifier() -> PkceCodeVerifier {
        PkceCodeVerifier::new("v".repeat(43))
    }

    #[test]
    fn each_browser_comes_back_once_and_few_are_remembered() {
        let mut logins = PendingLogins::default();
        for index in 0..=MOST {
            logins.add(index.to_string(), Nonce::new(index.to_string()), verifier());
        }
        assert_eq!(logins.0.len(), MOST);
        assert!(logins.take("0").is_none(), "the first one was forgotten");
        assert_eq!(logins.take("1").map(|pending| pending.nonce.secret().clone()).as_deref(), Some("1"));
        assert!(logins.take("1").is_none());
    }
}
