//! The direction to the sun by place and time, for `sky`, `sun` and `sunsky` without `sun_direction`.
//!
//! The position follows the Astronomical Almanac's low-precision formulas (Michalsky 1988, "The Astronomical Almanac's
//! algorithm for approximate solar position"), within 0.01° from 1950 to 2050.

use turner::math::elementary::{asin, atan2, sin_cos};
use turner::math::{DVec3, radians};

use super::params::Object;
use crate::scene_import::report::Fault;

/// A place on Earth and a time there. The defaults are Mitsuba's: Tokyo, 10 July 2010, 15:00.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlaceAndTime {
    /// Degrees north and east.
    latitude: f64,
    longitude: f64,
    /// Hours ahead of Universal Time.
    timezone: f64,
    year: i64,
    month: i64,
    day: i64,
    /// Hours since midnight.
    hours: f64,
}

impl PlaceAndTime {
    fn of(object: &Object) -> Result<PlaceAndTime, Fault> {
        let number = |name, or: f64| object.float(name).map(|v| v.unwrap_or(or));
        let whole = |name, or: f64, low: f64, high: f64| {
            number(name, or).map(|v| if v.is_finite() { v.clamp(low, high) as i64 } else { or as i64 })
        };
        let bounded = |v: f64, most: f64| if v.is_finite() { v.clamp(-most, most) } else { 0.0 };
        let hours = number("hour", 15.0)? + number("minute", 0.0)? / 60.0 + number("second", 0.0)? / 3600.0;
        Ok(PlaceAndTime {
            latitude: bounded(number("latitude", 35.6894)?, 90.0),
            longitude: bounded(number("longitude", 139.6917)?, 360.0),
            timezone: bounded(number("timezone", 9.0)?, 24.0),
            year: whole("year", 2010.0, 1.0, 9999.0)?,
            month: whole("month", 7.0, 1.0, 12.0)?,
            day: whole("day", 10.0, 1.0, 31.0)?,
            hours: bounded(hours, 48.0),
        })
    }

    /// Days since noon of 1 January 2000, Universal Time.
    fn days(&self) -> f64 {
        // The Julian day number of the Gregorian calendar; years begin in March.
        let before_march = (14 - self.month) / 12;
        let (year, month) = (self.year + 4800 - before_march, self.month + 12 * before_march - 3);
        let number =
            self.day + (153 * month + 2) / 5 + 365 * year + year / 4 - year / 100 + year / 400 - 32_045;
        (number - 2_451_545) as f64 - 0.5 + self.universal() / 24.0
    }

    fn universal(&self) -> f64 {
        self.hours - self.timezone
    }

    /// Elevation of the sun above the horizon, and its azimuth from north towards east, in radians.
    fn sun(&self) -> (f64, f64) {
        let days = self.days();
        let (sin_g, cos_g) = sin_cos(radians((357.528 + 0.985_600_3 * days).rem_euclid(360.0)));
        // sin 2g = 2 sin g cos g.
        let longitude = 280.460 + 0.985_647_4 * days + 1.915 * sin_g + 0.020 * 2.0 * sin_g * cos_g;
        let (sin_l, cos_l) = sin_cos(radians(longitude.rem_euclid(360.0)));
        let (sin_tilt, cos_tilt) = sin_cos(radians(23.439 - 4e-7 * days));
        let right_ascension = atan2(cos_tilt * sin_l, cos_l);
        let declination = asin((sin_tilt * sin_l).clamp(-1.0, 1.0));
        // Sidereal time in hours: a sidereal day is shorter by 0.0657 hours.
        let sidereal = (6.697_375 + 0.065_709_824_2 * days + self.universal()).rem_euclid(24.0);
        let hour_angle = radians(sidereal * 15.0 + self.longitude) - right_ascension;
        let (sin_d, cos_d) = sin_cos(declination);
        let (sin_h, cos_h) = sin_cos(hour_angle);
        let (sin_p, cos_p) = sin_cos(radians(self.latitude));
        let elevation = asin((sin_p * sin_d + cos_p * cos_d * cos_h).clamp(-1.0, 1.0));
        let azimuth = atan2(-sin_h * cos_d, sin_d * cos_p - sin_p * cos_d * cos_h);
        (elevation, azimuth)
    }
}

/// The direction to the sun in the space of the emitter: with z up and north at −x, or, in Mitsuba 0.6 (`is_old`), with y up
/// and north at −z.
pub(super) fn direction(object: &Object, is_old: bool) -> Result<DVec3, Fault> {
    let (elevation, azimuth) = PlaceAndTime::of(object)?.sun();
    let ((up, level), (east, north)) = (sin_cos(elevation), sin_cos(azimuth));
    Ok(if is_old {
        DVec3::new(east * level, up, -north * level)
    } else {
        DVec3::new(-north * level, -east * level, up)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_is_where_mitsuba_has_it() {
        let tokyo = PlaceAndTime {
            latitude: 35.6894,
            longitude: 139.6917,
            timezone: 9.0,
            year: 2010,
            month: 7,
            day: 10,
            hours: 15.0,
        };
        let cape_town = PlaceAndTime {
            latitude: -33.9,
            longitude: 18.4,
            timezone: 2.0,
            year: 2020,
            month: 1,
            day: 15,
            hours: 10.5,
        };
        // Elevations of Mitsuba 3.9.1.
        for (at, elevation, azimuth) in [
            (tokyo, 46.08, 265.75),
            (PlaceAndTime { hours: 9.0, ..tokyo }, 51.525, 98.85),
            (cape_town, 55.56, 77.9),
        ] {
            let (e, a) = at.sun();
            assert!((e.to_degrees() - elevation).abs() < 0.05, "{at:?}: {}", e.to_degrees());
            assert!((a.to_degrees().rem_euclid(360.0) - azimuth).abs() < 0.1, "{at:?}: {}", a.to_degrees());
        }
    }

    #[test]
    fn the_sun_stands_at_the_tilt_of_the_earth() {
        // At the solstice, at noon on the tropic, it is overhead; at the equinox it rises in the east.
        let noon = PlaceAndTime {
            latitude: 23.44,
            longitude: 0.0,
            timezone: 0.0,
            year: 2000,
            month: 6,
            day: 21,
            hours: 12.0,
        };
        assert!(noon.sun().0.to_degrees() > 89.0, "{:?}", noon.sun());
        let rise = PlaceAndTime { latitude: 0.0, month: 3, day: 20, hours: 6.12, ..noon };
        let (elevation, azimuth) = rise.sun();
        assert!(elevation.to_degrees().abs() < 1.0 && (azimuth.to_degrees() - 90.0).abs() < 1.0);
    }
}
