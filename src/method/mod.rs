//! Methods: algorithms that turn a prepared scene into estimates. One self-contained file per method and one table.

use serde::{Deserialize, Serialize};

use crate::estimate::RadiusRule;

/// A method by name, with the parameters that the user set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MethodChoice {
    /// Name in the table, for example `sppm`.
    pub name: String,
    /// Parameters by name; whatever is missing takes its default.
    #[serde(default)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

/// A choice that was checked: what coordinator and workers agree on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckedMethod {
    /// The choice with every parameter written out.
    pub choice: MethodChoice,
    /// How radii shrink.
    pub radius_rule: RadiusRule,
    /// α of the radius rule.
    pub alpha: f64,
    /// Photons emitted per pass.
    pub photons_per_pass: u32,
    /// Passes to make when the job names no stop rule.
    pub passes: u32,
}

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
}

/// Checks a choice against the table. `pixels` is the picture's size, from which `photons_per_pass: auto` follows.
pub fn check(choice: &MethodChoice, pixels: u64) -> Result<CheckedMethod, MethodError> {
    let _ = (choice, pixels);
    todo!("lands with the methods")
}
