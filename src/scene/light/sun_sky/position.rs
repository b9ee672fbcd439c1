//! Where the sun stands at a place and time [Blanco-Muriel et al. 2001], to about 0.01°.

use glam::DVec3;

use crate::scene::error::SceneError;
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
    let mut number = |name: &'static str, default: f64, range: [f64; 2]| {
        let number = fields.float(name)?.unwrap_or(default);
        match (range[0]..=range[1]).contains(&number) {
            true => Ok(number),
            false => {
                let remedy = format!("give a number from {} to {}", range[0], range[1]);
                Err(fields.error(name, format!("\"{name}\" is {number}"), remedy))
            }
        }
    };
    let latitude = number("latitude", 35.6894, [-90.0, 90.0])?;
    let longitude = number("longitude", 139.6917, [-180.0, 180.0])?;
    let timezone = number("timezone", 9.0, [-14.0, 14.0])?;
    let [year, month, day] =
        [number("year", 2010.0, [1.0, 9999.0])?, number("month", 7.0, [1.0, 12.0])?, number("day", 10.0, [1.0, 31.0])?];
    let minutes = number("minute", 0.0, [0.0, 60.0])? + number("second", 0.0, [0.0, 60.0])? / 60.0;
    let hour = number("hour", 15.0, [0.0, 24.0])? - timezone + minutes / 60.0;
    Ok(Sun::InSky(direction(noon_days(year as i64, month as i64, day as i64), hour, latitude, longitude)))
}

/// Days from noon of the 1st of January 2000 to midnight at the beginning of a day of the Gregorian calendar.
fn noon_days(year: i64, month: i64, day: i64) -> f64 {
    // January and February count as months 11 and 12 of the year before.
    let early = i64::from(month < 3);
    let (year, month) = (year - early, month + 12 * early);
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * (month - 3) + 2) / 5 + day;
    // The 1st of March of the year 0 is day 1; the 1st of January 2000 then is day 730426.
    days as f64 - 730_426.0 - 0.5
}

/// The direction at `hour` of universal time, for degrees north and east [Blanco-Muriel et al. 2001, section 4].
fn direction(midnight: f64, hour: f64, latitude: f64, longitude: f64) -> DVec3 {
    /// The sun's parallax: the Earth's radius over its distance.
    const PARALLAX: f64 = 6371.01 / 149_597_890.0;
    let days = midnight + hour / 24.0;
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
    let hour_angle = (sidereal_hours * 15.0 + longitude).to_radians() - ascension;
    let latitude = latitude.to_radians();
    let [sin, cos] = [libm::sin(latitude), libm::cos(latitude)];
    let up = cos * libm::cos(hour_angle) * libm::cos(declination) + libm::sin(declination) * sin;
    let zenith = libm::acos(up.clamp(-1.0, 1.0));
    let azimuth = libm::atan2(-libm::sin(hour_angle), libm::tan(declination) * cos - sin * libm::cos(hour_angle));
    let zenith = zenith + PARALLAX * libm::sin(zenith);
    let across = libm::sin(zenith);
    // Azimuths count from north towards east.
    DVec3::new(-across * libm::cos(azimuth), -across * libm::sin(azimuth), libm::cos(zenith))
}
