//! Numbers that name things of a farm. Each kind has a type of its own, so that none is taken for another.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Crockford's base 32: no letter that looks like a digit.
const DIGITS: &[u8; 32] = b"0123456789abcdefghjkmnpqrstvwxyz";
/// Digits of a job's id at least, so that ids of the next thirty years sort as text.
const WIDTH: usize = 8;
/// Milliseconds from 1970 to 2026, where job numbers begin.
const EPOCH_MILLISECONDS: u64 = 1_767_225_600_000;

/// A job. Written as eight or more digits of Crockford's base 32, for example `0czk4m2t`: upper case is read like lower case,
/// `o` as 0, `i` and `l` as 1. Later jobs have larger ids, also across restarts; none is used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(u64);

impl JobId {
    /// The job with this number.
    pub const fn new(number: u64) -> Self {
        Self(number)
    }

    /// The number, as it is stored.
    pub const fn number(self) -> u64 {
        self.0
    }

    /// The id of a job that is submitted now, where `last` is the largest id used so far: the time, but later than `last`.
    pub fn after(last: Option<Self>, unix_milliseconds: u64) -> Self {
        let by_time = unix_milliseconds.saturating_sub(EPOCH_MILLISECONDS);
        Self(last.map_or(by_time, |last| by_time.max(last.0 + 1)))
    }
}

/// A text that is not a job's id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not a job's id")]
pub struct BadJobId(pub String);

impl fmt::Display for JobId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = [b'0'; 13];
        let (mut rest, mut start) = (self.0, text.len());
        while rest > 0 || start > text.len() - WIDTH {
            start -= 1;
            text[start] = DIGITS[(rest % 32) as usize];
            rest /= 32;
        }
        text[start..].iter().try_for_each(|digit| fmt::Write::write_char(formatter, char::from(*digit)))
    }
}

impl FromStr for JobId {
    type Err = BadJobId;

    fn from_str(text: &str) -> Result<Self, BadJobId> {
        let digit = |byte: u8| {
            let byte = match byte.to_ascii_lowercase() {
                b'o' => b'0',
                b'i' | b'l' => b'1',
                byte => byte,
            };
            DIGITS.iter().position(|known| *known == byte)
        };
        let number =
            text.bytes().try_fold(0u64, |number, byte| number.checked_mul(32)?.checked_add(digit(byte)? as u64));
        match number {
            Some(number) if text.len() >= WIDTH => Ok(Self(number)),
            _ => Err(BadJobId(text.to_owned())),
        }
    }
}

/// How the id of a sequence begins.
const SEQUENCE: &str = "seq-";

/// A sequence. Written as `seq-` and the digits of a job's id, for example `seq-0czk4m2t`; its number is no job's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SequenceId(JobId);

impl SequenceId {
    /// The sequence that takes the number of a job.
    pub const fn new(job: JobId) -> Self {
        Self(job)
    }

    /// The number, as it is stored.
    pub const fn number(self) -> u64 {
        self.0.number()
    }
}

/// A text that is not a sequence's id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not a sequence's id")]
pub struct BadSequenceId(pub String);

impl fmt::Display for SequenceId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{SEQUENCE}{}", self.0)
    }
}

impl FromStr for SequenceId {
    type Err = BadSequenceId;

    fn from_str(text: &str) -> Result<Self, BadSequenceId> {
        let number = text.strip_prefix(SEQUENCE).and_then(|digits| digits.parse().ok());
        number.map(Self).ok_or_else(|| BadSequenceId(text.to_owned()))
    }
}

/// Ids that are written as text.
macro_rules! as_text {
    ($name:ident) => {
        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}

as_text!(JobId);
as_text!(SequenceId);

macro_rules! number {
    ($(#[$documentation:meta])* $name:ident) => {
        $(#[$documentation])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(u64);

        impl $name {
            /// The one with this number.
            pub const fn new(number: u64) -> Self {
                Self(number)
            }

            /// The number, as it travels.
            pub const fn number(self) -> u64 {
                self.0
            }

            /// The one after this.
            pub const fn next(self) -> Self {
                Self(self.0 + 1)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(formatter)
            }
        }
    };
}

number! {
    /// A registration of a worker: one that was forgotten and comes back has a new one.
    WorkerId
}

number! {
    /// A lease.
    LeaseId
}

number! {
    /// Rises every time the same work is leased, so that a late result of an earlier lease is told from the current one's.
    Fencing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn job_ids_are_read_as_they_are_written_and_sort_as_text() {
        let numbers = [0, 1, 31, 32, 28_000_000_000, (1 << 40) - 1, 1 << 40, u64::MAX];
        for number in numbers {
            let id = JobId::new(number);
            assert_eq!(id.to_string().parse(), Ok(id));
            assert_eq!(id.to_string().to_uppercase().parse(), Ok(id));
        }
        let texts: Vec<String> = numbers[..6].iter().map(|number| JobId::new(*number).to_string()).collect();
        assert!(texts.is_sorted(), "{texts:?}");
        assert_eq!("0000oil0".parse(), Ok(JobId::new(((1 << 5) + 1) << 5)));
        let sequence = SequenceId::new(JobId::new(31));
        assert_eq!((sequence.to_string().as_str(), sequence.to_string().parse()), ("seq-0000000z", Ok(sequence)));
        assert!("0000000z".parse::<SequenceId>().is_err() && "seq-0000000z".parse::<JobId>().is_err());
        for wrong in ["", "job-1", "0000000u", "zzzzzzzzzzzzzz", "1"] {
            assert!(wrong.parse::<JobId>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn job_ids_rise_even_when_the_clock_does_not() {
        let first = JobId::after(None, EPOCH_MILLISECONDS + 5);
        assert!(JobId::after(Some(first), EPOCH_MILLISECONDS + 5) > first);
        assert!(JobId::after(Some(first), 0) > first);
        assert_eq!(JobId::after(Some(first), EPOCH_MILLISECONDS + 900).number(), 900);
    }
}
