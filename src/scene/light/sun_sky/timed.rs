//! `timed_sunsky`: the sky and the sun on the average of a span of time.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | those of `sunsky` but `sun_direction` and the time | | | |
//! | `start_year`, `start_month`, `start_day` | the first day | – | 2025, 1, 1 |
//! | `end_year`, `end_month`, `end_day` | the day after the last | – | a year after the first day |
//! | `window_start_time`, `window_end_time` | the hours of each day that count | h, 0 to 24 | 7, 19 |
//! | `shutter_open`, `shutter_close` | the sensor's times of the first and the last instant | – | 0, 1 |
//!
//! A picture's rays have times that are even over the sensor's `shutter_open` and `shutter_close`, as in Mitsuba 3.9.1. The instants are
//! those from 0 to 1 by the emitter's own shutter: they run through the window of one day after the other. As pictures are linear in what
//! lights emit, theirs is that of the average over time, which is computed once and drawn as an environment map of 2048 columns.
//!
//! A sensor's shutter is open from 0 to 0 unless it says otherwise. Then there is one instant, which is a `sunsky`.

use super::date::{Date, DateNames};
use super::position::{Place, number};
use super::{Appearance, SunSky, average};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::light::{Light, Surroundings};

const START: DateNames = DateNames { year: "start_year", month: "start_month", day: "start_day" };
const END: DateNames = DateNames { year: "end_year", month: "end_month", day: "end_day" };

/// A span of days, with the hours that count of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    place: Place,
    /// See [`Date::number`].
    first_day: i64,
    days: i64,
    /// Hours of the place's clocks.
    window: [f64; 2],
}

impl Span {
    fn read(fields: &mut Fields<'_>) -> Result<Self, SceneError> {
        let place = Place::read(fields)?;
        let start = Date::read(fields, START, Date { year: 2025, month: 1, day: 1 })?;
        let end = Date::read(fields, END, Date { year: start.year + 1, ..start })?;
        let days = end.number() - start.number();
        if days < 1 {
            let name = [END.day, END.month, END.year].into_iter().find(|name| fields.has(name)).unwrap_or(START.year);
            let problem = "the last day comes before the end of the first one";
            return Err(fields.error(name, problem, "let it end at least a day after it starts"));
        }
        let window = [
            number(fields, "window_start_time", 7.0, [0.0, 24.0])?,
            number(fields, "window_end_time", 19.0, [0.0, 24.0])?,
        ];
        if window[0] > window[1] {
            let [start, end] = window.map(shown_number);
            let problem = format!("\"window_end_time\" is {end}, before \"window_start_time\", {start}");
            return Err(fields.error("window_end_time", problem, "let the window end after it starts"));
        }
        Ok(Self { place, first_day: start.number(), days, window })
    }

    /// Where the sun stands when `part` of the span is over: a unit vector in the sky's own space.
    pub(super) fn sun(&self, part: f64) -> glam::DVec3 {
        let days = part * self.days as f64;
        let day = days.floor();
        let hour = self.window[0] + (self.window[1] - self.window[0]) * (days - day);
        self.place.sun(self.first_day as f64 + day, hour)
    }
}

/// Reads the parameters, for a sensor whose shutter is open between two times.
pub(crate) fn read(
    fields: &mut Fields<'_>,
    shutter: [f64; 2],
    surroundings: Surroundings,
) -> Result<Light, SceneError> {
    let appearance = Appearance::read(fields)?;
    let span = Span::read(fields)?;
    let (open, close) = (fields.float("shutter_open")?.unwrap_or(0.0), fields.float("shutter_close")?.unwrap_or(1.0));
    if close <= open {
        let problem =
            format!("\"shutter_close\" is {}, and \"shutter_open\" {}", shown_number(close), shown_number(open));
        return Err(fields.error("shutter_close", problem, "let it close after it opens"));
    }
    let parts = shutter.map(|time| (time - open) / (close - open));
    if let Some(part) = parts.into_iter().find(|part| !(0.0..=1.0).contains(part)) {
        let problem = format!("the sensor's shutter is open at {} of the span, outside of it", shown_number(part));
        let remedy = "give sensor and emitter the same \"shutter_open\" and \"shutter_close\"";
        return Err(fields.error("shutter_close", problem, remedy));
    }
    Ok(if parts[0] == parts[1] {
        Light::SunSky(SunSky::at(&appearance, span.sun(parts[0]), surroundings))
    } else {
        Light::EnvironmentMap(average::environment(&appearance, &span, parts, surroundings))
    })
}
