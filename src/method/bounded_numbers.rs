//! Numbers in a range. What help tells of a range, what is taken and what errors say is written once.

use serde::de::{Deserializer, Error, Visitor};

/// Declares a type of numbers in a range: `Name(number type), [range]`, and with `or Auto`, `or All`, `or Switchable` also the range of that type of it.
///
/// A range is `above LOW, below HIGH` of real numbers, or some of `LOW to HIGH`, `NUMBER` and `NUMBER for MEANING` with commas between.
macro_rules! bounded {
    ($(#[$attribute:meta])* $visibility:vis struct $name:ident($type:ty) $(or $optional:ident)?, $range:tt) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $visibility struct $name($type);

        impl $name {
            /// `None` for what is out of range.
            #[allow(unused_comparisons, reason = "some ranges begin where their type does")]
            $visibility const fn new(number: $type) -> Option<Self> {
                if $crate::method::bounded_numbers::within!(number, $range) { Some(Self(number)) } else { None }
            }

            /// The number.
            $visibility const fn get(self) -> $type {
                self.0
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                self.0.serialize(serializer)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let refused = || serde::de::Error::custom(<Self as $crate::method::parameters::ParameterValue>::RANGE);
                let number = $crate::method::bounded_numbers::read(deserializer)?;
                number.and_then(Self::new).ok_or_else(refused)
            }
        }

        impl $crate::method::parameters::ParameterValue for $name {
            const RANGE: &'static str = $crate::method::bounded_numbers::told!($range);
        }

        $($crate::method::bounded_numbers::optional!($optional, $name, $range);)?
    };
}

/// Whether a number lies in a range.
macro_rules! within {
    ($number:ident, [above $low:literal, below $high:literal]) => { ($low as f64) < $number && $number < ($high as f64) };
    ($number:ident, [$low:literal to $high:literal $(, $($rest:tt)+)?]) => {
        ($low <= $number && $number <= $high) $(|| $crate::method::bounded_numbers::within!($number, [$($rest)+]))?
    };
    ($number:ident, [$only:literal $(for $meaning:ident)? $(, $($rest:tt)+)?]) => {
        $number == $only $(|| $crate::method::bounded_numbers::within!($number, [$($rest)+]))?
    };
}

/// A range as people read it.
macro_rules! told {
    ([above $low:literal, below $high:literal]) => { concat!("above ", $low, ", below ", $high) };
    ([$low:literal to $high:literal $(, $($rest:tt)+)?]) => {
        concat!($low, " to ", $high $(, ", ", $crate::method::bounded_numbers::told!([$($rest)+]))?)
    };
    ([$only:literal $(for $meaning:ident)? $(, $($rest:tt)+)?]) => {
        concat!($only $(, " for ", stringify!($meaning))? $(, ", ", $crate::method::bounded_numbers::told!([$($rest)+]))?)
    };
}

/// The range of a number that may also be a word.
macro_rules! optional {
    (Auto, $name:ident, $range:tt) => {
        impl $crate::method::parameters::ParameterValue for $crate::method::parameter_values::Auto<$name> {
            const RANGE: &'static str = concat!($crate::method::bounded_numbers::told!($range), ", auto");
        }
    };
    (All, $name:ident, $range:tt) => {
        impl $crate::method::parameters::ParameterValue for $crate::method::parameter_values::All<$name> {
            const RANGE: &'static str = concat!($crate::method::bounded_numbers::told!($range), ", all");
        }
    };
    (Switchable, $name:ident, $range:tt) => {
        impl $crate::method::parameters::ParameterValue for $crate::method::parameter_values::Switchable<$name> {
            const RANGE: &'static str = concat!($crate::method::bounded_numbers::told!($range), ", off");
        }
    };
}
pub(super) use {bounded, optional, told, within};

/// Types of numbers that a range may have.
pub(super) trait Numeric: Sized {
    /// A whole number, if the type holds it.
    fn from_whole(number: i128) -> Option<Self>;
    /// Any number, if the type holds it.
    fn from_real(number: f64) -> Option<Self>;
}

impl Numeric for f64 {
    fn from_whole(number: i128) -> Option<Self> {
        Some(number as Self)
    }

    fn from_real(number: f64) -> Option<Self> {
        Some(number)
    }
}

macro_rules! whole {
    ($($type:ty),+) => {$(
        impl Numeric for $type {
            fn from_whole(number: i128) -> Option<Self> {
                Self::try_from(number).ok()
            }

            /// 1e3 and 1000.0 are 1000.
            fn from_real(number: f64) -> Option<Self> {
                let is_whole = number.fract() == 0.0 && number.abs() <= (1_u64 << 53) as f64;
                is_whole.then(|| Self::from_whole(number as i128)).flatten()
            }
        }
    )+};
}
whole!(u32, i64);

/// Reads a number; `None` where its type does not hold it.
///
/// # Errors
/// What is no number.
pub(super) fn read<'de, T: Numeric, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    struct Number<T>(std::marker::PhantomData<T>);

    impl<T: Numeric> Visitor<'_> for Number<T> {
        type Value = Option<T>;

        fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            formatter.write_str("a number")
        }

        fn visit_i64<E: Error>(self, number: i64) -> Result<Option<T>, E> {
            Ok(T::from_whole(number.into()))
        }

        fn visit_u64<E: Error>(self, number: u64) -> Result<Option<T>, E> {
            Ok(T::from_whole(number.into()))
        }

        fn visit_f64<E: Error>(self, number: f64) -> Result<Option<T>, E> {
            Ok(T::from_real(number))
        }
    }
    deserializer.deserialize_any(Number(std::marker::PhantomData))
}
