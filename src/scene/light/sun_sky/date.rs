//! Days of the Gregorian calendar.

use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;

/// A day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Date {
    pub(super) year: i64,
    /// From 1.
    pub(super) month: i64,
    /// From 1.
    pub(super) day: i64,
}

/// What the parameters of a date are called.
#[derive(Clone, Copy)]
pub(super) struct DateNames {
    pub(super) year: &'static str,
    pub(super) month: &'static str,
    pub(super) day: &'static str,
}

impl Date {
    /// Reads a date; `default` says what is not given.
    pub(super) fn read(fields: &mut Fields<'_>, names: DateNames, default: Self) -> Result<Self, SceneError> {
        let year = whole(fields, names.year, default.year, 9999)?;
        let month = whole(fields, names.month, default.month, 12)?;
        let day = whole(fields, names.day, default.day, 31)?;
        let length = days_of(year, month);
        if day > length {
            let problem = format!("\"{}\" is {day}, and month {month} of {year} has {length} days", names.day);
            return Err(fields.error(names.day, problem, format!("give a number from 1 to {length}")));
        }
        Ok(Self { year, month, day })
    }

    /// Days from the 1st of January 2000.
    pub(super) fn number(self) -> i64 {
        // January and February count as months 11 and 12 of the year before.
        let early = i64::from(self.month < 3);
        let (year, month) = (self.year - early, self.month + 12 * early);
        let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * (month - 3) + 2) / 5 + self.day;
        // The 1st of March of the year 0 is day 1; the 1st of January 2000 then is day 730426.
        days - 730_426
    }
}

/// A whole number from 1 to `most`.
fn whole(fields: &mut Fields<'_>, name: &'static str, default: i64, most: i64) -> Result<i64, SceneError> {
    let number = fields.float(name)?.unwrap_or(default as f64);
    if !(1.0..=most as f64).contains(&number) {
        return Err(fields.error(
            name,
            format!("\"{name}\" is {}", shown_number(number)),
            format!("give a number from 1 to {most}"),
        ));
    }
    if number.fract() != 0.0 {
        return Err(fields.error(name, format!("\"{name}\" is {}", shown_number(number)), "give a whole number"));
    }
    Ok(number as i64)
}

/// How many days a month has.
fn days_of(year: i64, month: i64) -> i64 {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}
