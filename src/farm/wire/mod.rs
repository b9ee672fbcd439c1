//! The workers' protocol as bytes: generated messages, and one conversion file per message group.
//!
//! Whatever comes in is checked here against what the reader expects before anything is allocated for it.

pub mod first_surfaces;
pub mod guides;
pub mod lease;
pub mod mattes;
pub mod planes;
pub mod radius;
pub mod result;

/// The generated messages of `proto/photonfarm/v1`.
#[allow(missing_docs, clippy::doc_markdown, unreachable_pub)]
pub mod messages {
    include!(concat!(env!("OUT_DIR"), "/photonfarm.v1.rs"));
}

/// Which sources and target the program was built from. Only equal builds work on one picture.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("PHOTONFARM_BUILD"));

/// A message that does not say what it should.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// Not a message of the expected kind.
    #[error("the message cannot be read: {0}")]
    Malformed(String),
    /// A needed field is missing.
    #[error("the message has no {0}")]
    Missing(&'static str),
    /// A field's value is impossible.
    #[error("the message's {field} is impossible: {problem}")]
    Impossible {
        /// The field.
        field: &'static str,
        /// What is wrong.
        problem: String,
    },
}
