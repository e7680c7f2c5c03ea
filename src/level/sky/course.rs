//! [`DayCourse`]: where the sun stands at an hour of a day at a latitude.
//!
//! Declination by J. W. Spencer, "Fourier series representation of the position of the sun", Search 2(5), 1971 (within
//! 0.01 degrees); the rest is spherical trigonometry, as in NOAA's "General solar position calculations". Hours are
//! local solar time: the sun stands highest at 12. Without refraction, which lifts a sun on the horizon by half a
//! degree.

use std::f32::consts::TAU;

use bevy::prelude::*;

/// The sun's path over a place on a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DayCourse {
    /// Degrees north of the equator, −90..=90.
    pub latitude_deg: f32,
    /// Day of the year, 1..=365.
    pub day: u32,
}

/// Radians that the earth turns in an hour.
const HOUR_ANGLE: f32 = TAU / 24.0;
/// Steps in which the nearest hour of a direction is looked for: every 3 minutes of a whole day.
const SEARCH_STEPS: u32 = 480;

impl DayCourse {
    /// Angle of the sun above the plane of the equator, in radians (Spencer 1971).
    #[must_use]
    pub fn declination(&self) -> f32 {
        let angle = TAU * (self.day as f32 - 1.0) / 365.0;
        let (sin, cos) = angle.sin_cos();
        let (sin_2, cos_2) = (2.0 * angle).sin_cos();
        let (sin_3, cos_3) = (3.0 * angle).sin_cos();
        0.006_918 - 0.399_912 * cos + 0.070_257 * sin - 0.006_758 * cos_2 + 0.000_907 * sin_2 - 0.002_697 * cos_3
            + 0.001_48 * sin_3
    }

    /// The unit direction in which sunlight travels at an hour (0..24; others are taken around the clock): +x is east,
    /// −z north, y up. It points upwards at night.
    #[must_use]
    pub fn light_dir(&self, hour: f32) -> Vec3 {
        let (sin_latitude, cos_latitude) = self.latitude_deg.to_radians().sin_cos();
        let (sin_declination, cos_declination) = self.declination().sin_cos();
        let (sin_hour, cos_hour) = ((hour - 12.0) * HOUR_ANGLE).sin_cos();
        let east = -cos_declination * sin_hour;
        let north = sin_declination * cos_latitude - cos_declination * sin_latitude * cos_hour;
        let up = sin_declination * sin_latitude + cos_declination * cos_latitude * cos_hour;
        -Vec3::new(east, up, -north)
    }

    /// The hours between which the sun's middle stands higher than `elevation` radians; `None` where it never does.
    /// Where it always does: 0 and 24.
    #[must_use]
    pub fn hours_above(&self, elevation: f32) -> Option<(f32, f32)> {
        let (sin_latitude, cos_latitude) = self.latitude_deg.to_radians().sin_cos();
        let (sin_declination, cos_declination) = self.declination().sin_cos();
        let cos_hour = (elevation.sin() - sin_declination * sin_latitude) / (cos_declination * cos_latitude);
        if cos_hour >= 1.0 || !cos_hour.is_finite() {
            return None;
        }
        let half = cos_hour.max(-1.0).acos() / HOUR_ANGLE;
        Some((12.0 - half, 12.0 + half))
    }

    /// The hour at which sunlight comes nearest to `light_dir` (any length but zero), to 3 minutes.
    #[must_use]
    pub fn nearest_hour(&self, light_dir: Vec3) -> f32 {
        let hour = |step: u32| 24.0 * step as f32 / SEARCH_STEPS as f32;
        let nearness = |step: &u32| self.light_dir(hour(*step)).dot(light_dir);
        let nearest = (0..SEARCH_STEPS).max_by(|a, b| nearness(a).total_cmp(&nearness(b)));
        nearest.map_or(12.0, hour)
    }
}

/// An hour as on a clock: `06:05`.
#[must_use]
pub fn clock(hour: f32) -> String {
    let minutes = (hour.rem_euclid(24.0) * 60.0).round() as u32 % (24 * 60);
    format!("{:02}:{:02}", minutes / 60, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARCH_EQUINOX: u32 = 80;
    const JUNE_SOLSTICE: u32 = 172;
    const DECEMBER_SOLSTICE: u32 = 355;

    fn course(latitude_deg: f32, day: u32) -> DayCourse {
        DayCourse { latitude_deg, day }
    }

    fn elevation_deg(light_dir: Vec3) -> f32 {
        (-light_dir.y).clamp(-1.0, 1.0).asin().to_degrees()
    }

    /// The tilt of the earth's axis is 23.44 degrees.
    #[test]
    fn declination_is_that_of_solstices_and_equinox() {
        for (day, degrees) in [
            (JUNE_SOLSTICE, 23.44),
            (DECEMBER_SOLSTICE, -23.44),
            (MARCH_EQUINOX, 0.0),
        ] {
            let found = course(0.0, day).declination().to_degrees();
            assert!((found - degrees).abs() < 0.5, "day {day}: {found}");
        }
    }

    /// At noon the sun stands 90 − latitude + declination degrees high, in the south.
    #[test]
    fn noon_is_as_high_as_latitude_and_declination_say() {
        for (day, degrees) in [
            (JUNE_SOLSTICE, 65.44),
            (DECEMBER_SOLSTICE, 18.56),
            (MARCH_EQUINOX, 42.0),
        ] {
            let noon = course(48.0, day).light_dir(12.0);
            assert!((elevation_deg(noon) - degrees).abs() < 0.5, "day {day}: {noon}");
            assert!(
                noon.z < 0.0 && noon.x.abs() < 1e-5,
                "from the south to the north: {noon}"
            );
            assert!(noon.is_normalized(), "{noon}");
        }
        let south = course(-33.9, DECEMBER_SOLSTICE).light_dir(12.0);
        assert!(
            south.z > 0.0 && (elevation_deg(south) - 79.54).abs() < 0.5,
            "Cape Town: {south}"
        );
    }

    /// On the equinox the day has twelve hours everywhere, and the sun rises due east.
    #[test]
    fn the_equinox_has_twelve_hours_and_rises_in_the_east() {
        for latitude in [-60.0, 0.0, 48.0] {
            let (rise, set) = course(latitude, MARCH_EQUINOX).hours_above(0.0).expect("a day");
            assert!(
                (rise - 6.0).abs() < 0.06 && (set - 18.0).abs() < 0.06,
                "{latitude}: {rise} {set}"
            );
            let light_dir = course(latitude, MARCH_EQUINOX).light_dir(rise);
            assert!(light_dir.abs_diff_eq(Vec3::NEG_X, 0.02), "{latitude}: {light_dir}");
        }
    }

    /// At 48 degrees north, the longest day: cos of the half day is −tan 48° tan 23.44°, half a day is 7.92 hours; the
    /// sun rises at the azimuth whose cosine is sin 23.44° ÷ cos 48°, 53.5 degrees.
    #[test]
    fn the_longest_day_is_as_long_as_worked_out() {
        let course = course(48.0, JUNE_SOLSTICE);
        let (rise, set) = course.hours_above(0.0).expect("a day");
        assert!((rise - 4.08).abs() < 0.03 && (set - 19.92).abs() < 0.03, "{rise} {set}");
        let to_sun = -course.light_dir(rise);
        let azimuth = to_sun.x.atan2(-to_sun.z).to_degrees();
        assert!(
            (azimuth - 53.5).abs() < 0.5 && to_sun.y.abs() < 1e-3,
            "{azimuth}, {to_sun}"
        );
    }

    #[test]
    fn beyond_the_polar_circle_there_is_no_night_or_no_day() {
        assert_eq!(course(75.0, JUNE_SOLSTICE).hours_above(0.0), Some((0.0, 24.0)));
        assert_eq!(course(75.0, DECEMBER_SOLSTICE).hours_above(0.0), None);
    }

    #[test]
    fn the_nearest_hour_is_found_again() {
        let course = course(48.0, JUNE_SOLSTICE);
        for hour in [5.0, 9.3, 12.0, 18.75] {
            let found = course.nearest_hour(course.light_dir(hour) * 3.0);
            assert!((found - hour).abs() < 0.051, "{hour}: {found}");
        }
    }

    #[test]
    fn clocks_go_round() {
        assert_eq!(clock(6.0833), "06:05");
        assert_eq!(clock(23.9999), "00:00");
        assert_eq!(clock(-0.5), "23:30");
    }
}
