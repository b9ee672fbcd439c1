//! Arguments that are one of some named values.

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// Reads one of `all` by its `name`.
pub(super) fn named<T: Copy + Send + Sync + 'static, const COUNT: usize>(
    all: [T; COUNT],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name))
        .try_map(move |text| all.into_iter().find(|value| name(*value) == text).ok_or("no such value"))
}
