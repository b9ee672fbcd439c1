//! Parameters: each method has one struct of them, made by [`parameters!`], in which every parameter stands once, with its type (which
//! holds nothing but legal values), its meaning and its default; and how such a struct is read from what a user gave.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::{MethodError, ParameterizedMethod};
use crate::scene::error::nearest_name;

/// One parameter, as `photonfarm methods` and the documentation show it.
#[derive(Clone, Copy, Debug)]
pub struct ParameterHelp {
    /// Its name.
    pub name: &'static str,
    /// What it means, with its unit.
    pub meaning: &'static str,
    /// Values it may take.
    pub range: &'static str,
    /// What it is when the user does not give it.
    pub default: &'static str,
}

/// A type that parameters have. Reading it refuses whatever is out of its range.
pub(crate) trait ParameterValue: Clone + Serialize + DeserializeOwned {
    /// Values it may take, as help and errors show them.
    const RANGE: &'static str;
}

/// What a parameter means, and what it is when the user does not give it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parameter<T> {
    /// What it means, with its unit.
    pub meaning: &'static str,
    /// Its default.
    pub default: T,
    /// The default as help shows it, after a colon what else is to be said of it.
    pub shown: &'static str,
}

impl<T: ParameterValue> Parameter<T> {
    /// The row of the help.
    pub(crate) const fn help(&self, name: &'static str) -> ParameterHelp {
        ParameterHelp { name, meaning: self.meaning, range: T::RANGE, default: self.shown }
    }
}

/// A parameter of one method; those of several stand in [`shared_parameters`](super::shared_parameters).
pub(crate) const fn parameter<T>(meaning: &'static str, default: T, shown: &'static str) -> Parameter<T> {
    Parameter { meaning, default, shown }
}

/// All parameters of a method.
pub trait ParameterSet: Default + Serialize + DeserializeOwned {
    /// What they are, in the order of the struct.
    const HELP: &'static [ParameterHelp];
}

/// Declares the parameters of a method, one a line: `name: Type = parameter("meaning, unit", default, "default as shown"),`.
macro_rules! parameters {
    ($(#[$attribute:meta])* $visibility:vis struct $set:ident { $($name:ident: $type:ty = $parameter:expr,)* }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        $visibility struct $set { $($visibility $name: $type,)* }

        impl Default for $set {
            fn default() -> Self {
                Self { $($name: {
                    const IT: &$crate::method::parameters::Parameter<$type> = &$parameter;
                    IT.default.clone()
                },)* }
            }
        }

        impl $crate::method::parameters::ParameterSet for $set {
            const HELP: &'static [$crate::method::ParameterHelp] = &[$({
                const IT: &$crate::method::parameters::Parameter<$type> = &$parameter;
                IT.help(stringify!($name))
            },)*];
        }
    };
}
pub(super) use parameters;

/// Reads what a user gave for `method`.
///
/// # Errors
/// A parameter that it does not have, or a value out of range.
pub(crate) fn read<P: ParameterSet>(method: &'static str, given: &Map<String, Value>) -> Result<P, MethodError> {
    let error = |problem: String, remedy: String| MethodError::Parameter { method, problem, remedy };
    // One at a time, so that an error names its parameter.
    for (name, value) in given {
        let Some(known) = P::HELP.iter().find(|known| known.name == name) else {
            let names: Vec<&str> = P::HELP.iter().map(|known| known.name).collect();
            return Err(error(format!("there is no parameter \"{name}\""), nearest_name(name, &names)));
        };
        let alone = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        if serde_json::from_value::<P>(alone).is_err() {
            return Err(error(format!("\"{name}\" is {value}"), format!("allowed: {}", known.range)));
        }
    }
    serde_json::from_value(Value::Object(given.clone()))
        .map_err(|source| error(source.to_string(), "see photonfarm methods".to_owned()))
}

/// [`read`], for the table of methods.
///
/// # Errors
/// Those of [`read`].
pub(crate) fn read_method<P: ParameterSet + ParameterizedMethod + 'static>(
    method: &'static str,
    given: &Map<String, Value>,
) -> Result<Box<dyn ParameterizedMethod>, MethodError> {
    Ok(Box::new(read::<P>(method, given)?))
}

/// Parameters as users write them.
pub trait WrittenOut {
    /// All of them, in the order of the struct.
    fn written_out(&self) -> Map<String, Value>;
}

impl<P: ParameterSet> WrittenOut for P {
    fn written_out(&self) -> Map<String, Value> {
        match serde_json::to_value(self) {
            Ok(Value::Object(all)) => all,
            // A struct of numbers and words always is an object.
            _ => Map::new(),
        }
    }
}
