//! The version of a scene file, and which dialect it is written in.

/// Major and minor version, as in `version="0.6.0"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) struct Version(pub u32, pub u32);

impl Version {
    /// Reads `0.6.0`, `0.6` or `3`.
    pub(in super::super) fn parse(text: &str) -> Option<Self> {
        let mut numbers = text.split('.').map(|part| part.trim().parse::<u32>());
        let major = numbers.next()?.ok()?;
        Some(Self(major, numbers.next().map_or(Ok(0), |minor| minor).ok()?))
    }

    /// Mitsuba 0.6 and before: camelCase names, other plugins.
    pub(in super::super) fn is_old(self) -> bool {
        self < Self(2, 0)
    }
}
