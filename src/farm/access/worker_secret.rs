//! What a worker shows after it joined: a secret of its own, so that no worker speaks for another.
//!
//! It is not kept anywhere: it says which worker was let in by which token, and carries a code that only this coordinator can make.

use super::secret::{NoRandomness, SecretHash, random_bytes};
use crate::farm::ids::WorkerId;

/// Makes and checks the secrets of workers. They end with the process: a worker that knows none joins again.
pub struct WorkerSecrets {
    key: [u8; 32],
}

impl WorkerSecrets {
    /// With a key that nobody else has.
    pub fn new() -> Result<Self, NoRandomness> {
        Ok(Self { key: random_bytes()? })
    }

    /// The secret of a worker; `token` is the one by which it joined, if one was needed.
    pub fn issue(&self, worker: WorkerId, token: Option<SecretHash>) -> String {
        let token = token.map_or_else(String::new, |hash| hash.digits());
        let code = self.code(worker, &token);
        format!("{worker}.{token}.{}", code.to_hex())
    }

    /// Who shows `secret`, if it was issued here.
    pub fn check(&self, secret: &str) -> Option<Shown> {
        let mut parts = secret.split('.');
        let (worker, token, code) = (parts.next()?, parts.next()?, parts.next()?);
        let worker = WorkerId::new(worker.parse().ok()?);
        // Hashes are compared in constant time.
        let is_ours = parts.next().is_none() && blake3::Hash::from_hex(code).ok()? == self.code(worker, token);
        is_ours.then(|| Shown { worker, token: SecretHash::from_digits(token) })
    }

    fn code(&self, worker: WorkerId, token: &str) -> blake3::Hash {
        blake3::keyed_hash(&self.key, format!("{worker}.{token}").as_bytes())
    }
}

/// What a worker's secret says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shown {
    /// The worker.
    pub worker: WorkerId,
    /// The token by which it joined.
    pub token: Option<SecretHash>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_is_one_workers_and_one_coordinators() {
        let secrets = WorkerSecrets::new().expect("randomness");
        let other = WorkerSecrets::new().expect("randomness");
        let token = Some(SecretHash::of("join"));
        for (worker, token) in [(WorkerId::new(7), token), (WorkerId::new(u64::MAX), None)] {
            let secret = secrets.issue(worker, token);
            assert_eq!(secrets.check(&secret), Some(Shown { worker, token }));
            assert_eq!(other.check(&secret), None);
            let (_, rest) = secret.split_once('.').expect("parts");
            assert_eq!(secrets.check(&format!("8.{rest}")), None);
            assert_eq!(secrets.check(&format!("{secret}.")), None);
        }
        let (stolen, _) =
            secrets.issue(WorkerId::new(7), token).rsplit_once('.').map(|(a, _)| (a.to_owned(), ())).expect("parts");
        for wrong in ["", "7", "7..", "7..00", &format!("{stolen}."), &format!("{stolen}.{}", "0".repeat(64))] {
            assert_eq!(secrets.check(wrong), None, "{wrong}");
        }
    }
}
