//! What an import could not represent as it was written. Nothing is dropped without a notice here.

use std::fmt;

use crate::scene::error::Location;

/// One thing in the user's files that the description does not hold as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Where it stands.
    pub location: Location,
    /// What it is, as a lowercase fragment, for example `parameter "saveLargeKernel" of integrator "ppm"`.
    pub subject: String,
    /// What was done with it.
    pub treatment: Treatment,
    /// What took its place, or why it does not matter, as a lowercase fragment; may be empty.
    pub explanation: String,
}

/// What an importer did with something that it cannot represent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// Something similar took its place.
    Approximated,
    /// The scene is rendered as if it were not there.
    Ignored,
}

impl Treatment {
    /// Its name: `approximated` or `ignored`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Approximated => "approximated",
            Self::Ignored => "ignored",
        }
    }
}

impl Notice {
    /// `subject` at `location` was replaced by something similar, as `explanation` says.
    pub fn approximated(location: &Location, subject: impl Into<String>, explanation: impl Into<String>) -> Self {
        Self::new(location, subject.into(), Treatment::Approximated, explanation.into())
    }

    /// `subject` at `location` was left out; `explanation` says what that means.
    pub fn ignored(location: &Location, subject: impl Into<String>, explanation: impl Into<String>) -> Self {
        Self::new(location, subject.into(), Treatment::Ignored, explanation.into())
    }

    fn new(location: &Location, subject: String, treatment: Treatment, explanation: String) -> Self {
        Self { location: location.clone(), subject, treatment, explanation }
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {} is {}", self.location, self.subject, self.treatment.name())?;
        if self.explanation.is_empty() { Ok(()) } else { write!(formatter, ": {}", self.explanation) }
    }
}
