//! Where the sun stands at a place and time [Blanco-Muriel et al. 2001], to about 0.01°.

use glam::DVec3;

use super::date::{Date, DateNames};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;

/// A direction towards the sun.
pub(super) enum Sun {
    /// In the world, not normalized.
    InWorld(DVec3),
    /// A unit vector in the sky's own space: x south, y west, z up.
    InSky(DVec3),
}

impl Sun {
    /// The unit direction in the space of unit `axes`.
    pub(super) fn local(self, axes: [DVec3; 3]) -> DVec3 {
        match self {
            Self::InWorld(direction) => DVec3::from_array(axes.map(|axis| axis.dot(direction.normalize()))),
            Self::InSky(direction) => direction,
        }
    }
}

const PLACE_AND_TIME: [&str; 9] =
    ["latitude", "longitude", "timezone", "year", "month", "day", "hour", "minute", "second"];
const DATE: DateNames = DateNames { year: "year", month: "month", day: "day" };

/// A number in a closed range.
pub(super) fn number(
    fields: &mut Fields<'_>,
    name: &'static str,
    default: f64,
    range: [f64; 2],
) -> Result<f64, SceneError> {
    let number = fields.float(name)?.unwrap_or(default);
    match (range[0]..=range[1]).contains(&number) {
        true => Ok(number),
        false => {
            let remedy = format!("give a number from {} to {}", shown_number(range[0]), shown_number(range[1]));
            Err(fields.error(name, format!("\"{name}\" is {}", shown_number(number)), remedy))
        }
    }
}

/// Reads `sun_direction`, or place and time.
pub(super) fn read(fields: &mut Fields<'_>) -> Result<Sun, SceneError> {
    let given = PLACE_AND_TIME.into_iter().find(|name| fields.has(name));
    if let Some(direction) = fields.vector("sun_direction")? {
        if let Some(name) = given {
            let problem = format!("\"sun_direction\" and \"{name}\" are given");
            return Err(fields.error("sun_direction", problem, "give the direction, or place and time"));
        }
        if direction.try_normalize().is_none() {
            let remedy = "give a vector that is not zero";
            return Err(fields.error("sun_direction", "\"sun_direction\" has no length", remedy));
        }
        return Ok(Sun::InWorld(direction));
    }
    let place = Place::read(fields)?;
    let date = Date::read(fields, DATE, Date { year: 2010, month: 7, day: 10 })?;
    let minutes = number(fields, "minute", 0.0, [0.0, 60.0])? + number(fields, "second", 0.0, [0.0, 60.0])? / 60.0;
    let hour = number(fields, "hour", 15.0, [0.0, 24.0])? + minutes / 60.0;
    Ok(Sun::InSky(place.sun(date.number() as f64, hour)))
}

/// A place on the Earth and its time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Degrees north and east.
    latitude: f64,
    longitude: f64,
    /// Hours before Greenwich.
    timezone: f64,
}

impl Place {
    pub(super) fn read(fields: &mut Fields<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            latitude: number(fields, "latitude", 35.6894, [-90.0, 90.0])?,
            longitude: number(fields, "longitude", 139.6917, [-180.0, 180.0])?,
            timezone: number(fields, "timezone", 9.0, [-14.0, 14.0])?,
        })
    }

    /// The unit direction towards the sun in the sky's own space, `hour` hours by the place's clocks after the beginning of a
    /// day (see [`Date::number`]) [Blanco-Muriel et al. 2001, section 4].
    pub(super) fn sun(&self, day: f64, hour: f64) -> DVec3 {
        /// The sun's parallax: the Earth's radius over its distance.
        const PARALLAX: f64 = 6371.01 / 149_597_890.0;
        let hour = hour - self.timezone;
        // From noon of the 1st of January 2000.
        let days = day - 0.5 + hour / 24.0;
        let node = 2.1429 - 0.001_039_459_4 * days;
        let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * days;
        let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
        let ecliptic = mean_longitude + 0.033_416_07 * libm::sin(anomaly) + 0.000_348_94 * libm::sin(2.0 * anomaly)
            - 0.000_113_4
            - 0.000_020_3 * libm::sin(node);
        let obliquity = 0.409_092_8 - 6.214e-9 * days + 0.000_039_6 * libm::cos(node);
        let ascension = libm::atan2(libm::cos(obliquity) * libm::sin(ecliptic), libm::cos(ecliptic));
        let declination = libm::asin(libm::sin(obliquity) * libm::sin(ecliptic));
        let sidereal_hours = 6.697_424_324_2 + 0.065_709_828_3 * days + hour;
        let hour_angle = (sidereal_hours * 15.0 + self.longitude).to_radians() - ascension;
        let latitude = self.latitude.to_radians();
        let [sin, cos] = [libm::sin(latitude), libm::cos(latitude)];
        let up = cos * libm::cos(hour_angle) * libm::cos(declination) + libm::sin(declination) * sin;
        let zenith = libm::acos(up.clamp(-1.0, 1.0));
        let azimuth = libm::atan2(-libm::sin(hour_angle), libm::tan(declination) * cos - sin * libm::cos(hour_angle));
        let zenith = zenith + PARALLAX * libm::sin(zenith);
        let across = libm::sin(zenith);
        // Azimuths count from north towards east.
        DVec3::new(-across * libm::cos(azimuth), -across * libm::sin(azimuth), libm::cos(zenith))
    }
}
