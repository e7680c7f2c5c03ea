//! The sun by keys, azimuth and elevation to the direction of sunlight and back; and the course of the day.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::prelude::*;

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    screens::Activity,
};
use crate::level::{LoadedScene, Sun, sky::course::DayCourse};

/// Where the sun stands, seen from the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunAngles {
    /// Radians clockwise from −z (north) seen from above: a quarter turn is +x (east). In −π..=π.
    pub azimuth: f32,
    /// Radians above the horizon, within [`SunAngles::MIN_ELEVATION`]..=[`SunAngles::MAX_ELEVATION`].
    pub elevation: f32,
}

/// Radians per second while a key is held.
const SPEED: f32 = 20.0 * DEGREE;
const DEGREE: f32 = TAU / 360.0;
/// Below this horizontal length a direction has no azimuth.
const NO_AZIMUTH: f32 = 1.0e-4;

impl SunAngles {
    /// The lowest sun that the keys reach: 2 degrees. Shadows are then 29 times as long as their casters are high.
    pub const MIN_ELEVATION: f32 = 2.0 * DEGREE;
    /// The highest: 89.5 degrees, so that the azimuth stays known.
    pub const MAX_ELEVATION: f32 = 89.5 * DEGREE;

    /// The direction in which sunlight travels, of unit length.
    pub fn light_dir(&self) -> Vec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth.sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation.sin_cos();
        -Vec3::new(sin_azimuth * cos_elevation, sin_elevation, -cos_azimuth * cos_elevation)
    }

    /// The angles of sunlight that travels along `light_dir` (any length), clamped into the keys' range.
    /// A vertical direction has azimuth 0, a zero or non-finite one is taken for vertical.
    pub fn from_light_dir(light_dir: Vec3) -> Self {
        let to_sun = -light_dir.try_normalize().unwrap_or(Vec3::NEG_Y);
        let azimuth = if to_sun.xz().length() < NO_AZIMUTH {
            0.0
        } else {
            to_sun.x.atan2(-to_sun.z)
        };
        Self {
            azimuth,
            elevation: to_sun.y.clamp(-1.0, 1.0).asin(),
        }
        .clamped()
    }

    /// Turned by `azimuth` and raised by `elevation` radians, clamped; non-finite steps change nothing.
    #[must_use]
    pub fn moved(&self, azimuth: f32, elevation: f32) -> Self {
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        Self {
            azimuth: self.azimuth + finite(azimuth),
            elevation: self.elevation + finite(elevation),
        }
        .clamped()
    }

    /// The light's rotation: −z along the light, y up as far as possible.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(-self.azimuth)
            * Quat::from_rotation_y(std::f32::consts::PI)
            * Quat::from_rotation_x(-self.elevation)
    }

    fn clamped(self) -> Self {
        let azimuth = (self.azimuth + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        Self {
            azimuth,
            elevation: self
                .elevation
                .clamp(Self::MIN_ELEVATION, Self::MAX_ELEVATION.min(FRAC_PI_2)),
        }
    }
}

/// The course of the day: the sun moves on its path over the level's latitude and day, and nights are left out.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Day {
    /// Local solar time while the day runs.
    pub hour: Option<f32>,
    /// From the course's direction to the sun's: a sun that did not stand on the course glides to it.
    off_course: Quat,
}

impl Day {
    /// Hours of the day in a second of play: from sunrise to sunset in one and a half minutes at most.
    pub const HOURS_PER_SECOND: f32 = 1.0 / 6.0;

    /// Seconds in which a sun off the course comes 2.7 times nearer to it.
    const GLIDE_SECONDS: f32 = 2.0;

    /// A day that begins with the sun where it stands: at the nearest hour. It stands still on days without a sunrise.
    fn beginning(course: &DayCourse, light_dir: Vec3) -> Self {
        let hour = Self::after(course, course.nearest_hour(light_dir), 0.0);
        let off_course = hour.map(|hour| Quat::from_rotation_arc(course.light_dir(hour), light_dir));
        Self {
            hour,
            off_course: off_course.unwrap_or_default(),
        }
    }

    /// The direction of sunlight `seconds` later; `None` while the day stands still.
    fn run(&mut self, course: &DayCourse, seconds: f32) -> Option<Vec3> {
        self.hour = Self::after(course, self.hour?, seconds);
        let nearer = 1.0 - (-seconds / Self::GLIDE_SECONDS).exp();
        self.off_course = self.off_course.slerp(Quat::IDENTITY, nearer);
        Some(self.off_course * course.light_dir(self.hour?))
    }

    /// The hour `seconds` after `hour`; after the hour at which the sun sinks below what keys reach comes the one at
    /// which it rises above it. `None` on days on which it never does.
    #[must_use]
    pub fn after(course: &DayCourse, hour: f32, seconds: f32) -> Option<f32> {
        let (rise, set) = course.hours_above(SunAngles::MIN_ELEVATION)?;
        let next = hour + seconds * Self::HOURS_PER_SECOND;
        Some(if (rise..set).contains(&next) { next } else { rise })
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Day>().add_systems(
        Update,
        (toggle_day, run_day, move_sun)
            .chain()
            .in_set(DemoSystems::Act)
            .run_if(in_state(Activity::Running)),
    );
}

fn toggle_day(
    intent: Res<Intent>,
    scene: Res<LoadedScene>,
    suns: Query<&Transform, With<Sun>>,
    mut day: ResMut<Day>,
    mut notice: ResMut<Notice>,
) {
    if !intent.started(Action::ToggleDay) {
        return;
    }
    if day.hour.take().is_some() {
        notice.show("the day stands still");
        return;
    }
    let course = scene.sun.course();
    let Some(sun) = suns.iter().next() else { return };
    *day = Day::beginning(&course, sun.forward().as_vec3());
    notice.show(match day.hour {
        Some(_) => "the day runs: an hour in six seconds",
        None => "the sun does not rise on this level's day",
    });
}

/// A new scene has its own sun, and the day stands still.
fn run_day(time: Res<Time>, scene: Res<LoadedScene>, mut suns: Query<&mut Transform, With<Sun>>, mut day: ResMut<Day>) {
    if scene.is_changed() {
        day.set_if_neq(Day::default());
    }
    if day.hour.is_none() {
        return;
    }
    if let Some(light_dir) = day.run(&scene.sun.course(), time.delta_secs()) {
        for mut transform in &mut suns {
            transform.rotation = SunAngles::from_light_dir(light_dir).rotation();
        }
    }
}

fn move_sun(intent: Res<Intent>, time: Res<Time>, mut suns: Query<&mut Transform, With<Sun>>, mut day: ResMut<Day>) {
    let step = intent.sun * SPEED * time.delta_secs() + intent.sun_drag;
    if step == Vec2::ZERO {
        return;
    }
    day.hour = None;
    for mut transform in &mut suns {
        let angles = SunAngles::from_light_dir(transform.forward().as_vec3()).moved(step.x, step.y);
        transform.rotation = angles.rotation();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn degrees(azimuth: f32, elevation: f32) -> SunAngles {
        SunAngles {
            azimuth: azimuth * DEGREE,
            elevation: elevation * DEGREE,
        }
    }

    /// The sun of a level need not stand on its course: it glides there from where it is.
    #[test]
    fn a_day_begins_where_the_sun_stands() {
        let course = DayCourse {
            latitude_deg: 48.0,
            day: 172,
        };
        let start = degrees(132.0, 41.0).light_dir();
        let mut day = Day::beginning(&course, start);
        let mut last = start;
        for _ in 0..600 {
            let next = day.run(&course, 1.0 / 60.0).expect("the day runs");
            let step = next.angle_between(last).to_degrees();
            assert!(step < 0.3, "{step} degrees in a sixtieth of a second");
            last = next;
        }
        let hour = day.hour.expect("the day runs");
        assert!(
            last.angle_between(course.light_dir(hour)).to_degrees() < 0.5,
            "on its course after ten seconds"
        );
    }

    /// At 48 degrees north on the longest day the sun stands 2 degrees high at about 4:17 and 19:43.
    #[test]
    fn days_follow_one_another_without_nights() {
        let course = DayCourse {
            latitude_deg: 48.0,
            day: 172,
        };
        let next = Day::after(&course, 9.0, 6.0).expect("a day");
        assert!((next - 10.0).abs() < 1e-4, "{next}");
        let next = Day::after(&course, 19.7, 6.0).expect("a day");
        assert!((next - 4.28).abs() < 0.05, "{next}");
        assert_eq!(
            Day::after(
                &DayCourse {
                    day: 355,
                    latitude_deg: 80.0
                },
                9.0,
                6.0
            ),
            None
        );
    }

    #[test]
    fn morning_sun_stands_in_the_east_and_shines_west() {
        let light_dir = degrees(90.0, 45.0).light_dir();
        assert!(
            light_dir.abs_diff_eq(Vec3::new(-1.0, -1.0, 0.0).normalize(), 1e-6),
            "{light_dir}"
        );
    }

    #[test]
    fn degenerate_directions_have_angles() {
        for light_dir in [Vec3::NEG_Y, Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::INFINITY)] {
            let angles = SunAngles::from_light_dir(light_dir);
            assert_eq!(angles, degrees(0.0, 89.5).clamped(), "{light_dir}");
        }
        let below = SunAngles::from_light_dir(Vec3::new(1.0, 0.5, 0.0));
        assert!(
            (below.elevation - SunAngles::MIN_ELEVATION).abs() < 1e-6,
            "from below the horizon: {below:?}"
        );
    }

    proptest! {
        #[test]
        fn angles_survive_the_round_trip(azimuth in -180.0f32..180.0, elevation in 2.0f32..89.0) {
            let angles = degrees(azimuth, elevation);
            let back = SunAngles::from_light_dir(angles.light_dir());
            let turn = (back.azimuth - angles.azimuth + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            prop_assert!(turn.abs() * elevation.to_radians().cos() < 1e-4, "{angles:?} {back:?}");
            prop_assert!((back.elevation - angles.elevation).abs() < 1e-3, "{angles:?} {back:?}");
        }

        #[test]
        fn the_rotation_looks_along_the_light(azimuth in -180.0f32..180.0, elevation in 2.0f32..89.5) {
            let angles = degrees(azimuth, elevation);
            let forward = angles.rotation() * Vec3::NEG_Z;
            prop_assert!(forward.abs_diff_eq(angles.light_dir(), 1e-5), "{forward} {}", angles.light_dir());
            let up = angles.rotation() * Vec3::Y;
            prop_assert!(up.y > 0.0, "never upside down: {up}");
        }

        #[test]
        fn moving_stays_in_range(steps in prop::collection::vec((-10.0f32..10.0, -10.0f32..10.0), 0..40)) {
            let mut angles = degrees(30.0, 45.0);
            for (azimuth, elevation) in steps {
                angles = angles.moved(azimuth, elevation).moved(f32::NAN, f32::INFINITY);
                prop_assert!((SunAngles::MIN_ELEVATION..=SunAngles::MAX_ELEVATION).contains(&angles.elevation), "{angles:?}");
                prop_assert!(angles.azimuth.abs() <= TAU / 2.0 + 1e-5, "{angles:?}");
                prop_assert!(angles.light_dir().is_normalized(), "{angles:?}");
            }
        }
    }
}
