//! Texts that nobody can guess, and the hashes that are kept of them.

use std::fmt;
use std::str::FromStr;

/// What the text of a token of ours begins with, so that it is found where it was left by mistake.
const PREFIX: &str = "photonfarm_";
/// Random bytes of a secret.
const BYTES: usize = 32;
/// Bytes of a secret that somebody else made, at least.
const SHORTEST: usize = 32;
/// Digits of a hash by which people call a token.
const ID_DIGITS: usize = 12;

/// A secret. It is shown once, to the one whom it is for, and neither logged nor kept.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

/// A text that cannot be a secret.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a token is {SHORTEST} or more visible characters without spaces; make one with `photonfarm token new`, or `openssl rand -hex 32`"
)]
pub struct BadSecret;

/// The system has no random numbers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this system gives no random numbers: {0}")]
pub struct NoRandomness(String);

/// Random bytes from the system.
pub(in crate::farm) fn random_bytes() -> Result<[u8; BYTES], NoRandomness> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes).map_err(|problem| NoRandomness(problem.to_string()))?;
    Ok(bytes)
}

impl Secret {
    /// A new one, of 256 random bits.
    pub fn new() -> Result<Self, NoRandomness> {
        Ok(Self(format!("{PREFIX}{}", blake3::Hash::from_bytes(random_bytes()?).to_hex())))
    }

    /// The text itself.
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// What is kept of it. It was drawn from so many that a slow hash would add nothing.
    pub fn hash(&self) -> SecretHash {
        SecretHash::of(&self.0)
    }
}

impl FromStr for Secret {
    type Err = BadSecret;

    fn from_str(text: &str) -> Result<Self, BadSecret> {
        let text = text.trim();
        let is_secret = text.len() >= SHORTEST && text.bytes().all(|byte| byte.is_ascii_graphic());
        if is_secret { Ok(Self(text.to_owned())) } else { Err(BadSecret) }
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Secret(…)")
    }
}

/// BLAKE3 of a secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SecretHash([u8; BYTES]);

impl SecretHash {
    /// That of a text that somebody sent.
    pub fn of(text: &str) -> Self {
        Self(*blake3::hash(text.as_bytes()).as_bytes())
    }

    /// 64 hexadecimal digits.
    pub fn digits(&self) -> String {
        blake3::Hash::from_bytes(self.0).to_hex().to_string()
    }

    /// From 64 hexadecimal digits.
    pub fn from_digits(digits: &str) -> Option<Self> {
        blake3::Hash::from_hex(digits).ok().map(|hash| Self(*hash.as_bytes()))
    }

    /// By what people call the token.
    pub fn id(&self) -> String {
        self.digits().chars().take(ID_DIGITS).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_differ_and_do_not_show_themselves() {
        let (one, other) = (Secret::new().expect("randomness"), Secret::new().expect("randomness"));
        assert_ne!(one.reveal(), other.reveal());
        assert_eq!(one.reveal().parse::<Secret>().map(|secret| secret.hash()), Ok(one.hash()));
        assert!(!format!("{one:?}").contains(&one.reveal()[PREFIX.len()..]));
        assert_eq!(SecretHash::from_digits(&one.hash().digits()), Some(one.hash()));
    }

    #[test]
    fn short_texts_and_texts_with_spaces_are_no_secrets() {
        let long = "x".repeat(SHORTEST);
        assert!(format!("{long}\n").parse::<Secret>().is_ok());
        for text in ["", "secret", &long[1..], &format!("{long} {long}")] {
            assert_eq!(text.parse::<Secret>(), Err(BadSecret), "{text}");
        }
    }
}
