//! What a method refuses.

/// A method that does not exist, or parameters that it cannot take.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MethodError {
    /// No method has this name.
    #[error("there is no method \"{name}\"; {remedy}")]
    Unknown {
        /// What the user wrote.
        name: String,
        /// Nearest names.
        remedy: String,
    },
    /// A parameter is unknown, of the wrong type or out of range.
    #[error("method \"{method}\": {problem}; {remedy}")]
    Parameter {
        /// The method.
        method: &'static str,
        /// What is wrong.
        problem: String,
        /// The allowed range, or the nearest name.
        remedy: String,
    },
    /// Light groups cannot be kept apart.
    #[error("light groups cannot be kept apart: {problem}; {remedy}")]
    LightGroups {
        /// Why not.
        problem: String,
        /// What to do instead.
        remedy: String,
    },
}
