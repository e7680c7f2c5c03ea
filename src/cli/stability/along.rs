//! What moves while stability is measured: a shot becomes a sequence of shots, one per frame.

use std::fmt;

use bevy::math::{Quat, Vec3};
use clap::ValueEnum;

use crate::{
    cli::headless::TIME_STEP,
    level::{format::CameraPath, shot::Shot},
};

/// What moves, at a fixed step of 1/60 s; everything else stands still.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Along {
    /// The camera: along `--path`, else ahead at 1.4 m/s while it turns left at 10 degrees per second
    Camera,
    /// The field of view: it halves in 2 s
    Fov,
    /// The sun: a day in 10 minutes
    Sun,
}

impl fmt::Display for Along {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "camera",
            Self::Fov => "fov",
            Self::Sun => "sun",
        })
    }
}

/// A walker's speed in metres per second.
const WALKING_SPEED: f32 = 1.4;
/// Slow enough that the picture stays, fast enough that maps that follow the view turn: degrees per second.
const TURNING_SPEED_DEG: f32 = 10.0;
/// Seconds in which the field of view halves: from 60 to 30 degrees.
const ZOOM_TIME: f32 = 2.0;
/// Seconds of a day: games have days of 10 to 60 minutes, and the fastest sun moves shadows most per frame. Real ones,
/// 144 times slower, make the same steps more rarely.
const DAY: f32 = 600.0;

/// `frames` shots at equal steps of [`TIME_STEP`], the first of them `shot` itself (or, along a camera path, `shot`
/// moved to the beginning of the path).
pub(super) fn sequence(along: Along, shot: &Shot, path: Option<&CameraPath>, frames: usize) -> Vec<Shot> {
    (0..frames)
        .map(|frame| {
            let seconds = frame as f32 * TIME_STEP.as_secs_f32();
            match along {
                Along::Camera => match path.and_then(|path| path.sample(seconds)) {
                    Some((position, target)) => seen_from(shot, position, target),
                    None => walked(shot, seconds),
                },
                Along::Fov => Shot {
                    fov_y_deg: shot.fov_y_deg * (-seconds / ZOOM_TIME).exp2(),
                    ..shot.clone()
                },
                Along::Sun => Shot {
                    light_dir: sun_after(shot.light_dir.into(), seconds).to_array(),
                    ..shot.clone()
                },
            }
        })
        .collect()
}

fn seen_from(shot: &Shot, position: Vec3, target: Vec3) -> Shot {
    Shot {
        position: position.to_array(),
        target: target.to_array(),
        ..shot.clone()
    }
}

/// Straight ahead over level ground while the view turns; a camera that looks straight up or down only turns.
fn walked(shot: &Shot, seconds: f32) -> Shot {
    let (position, target) = (Vec3::from(shot.position), Vec3::from(shot.target));
    let view = target - position;
    let ahead = Vec3::new(view.x, 0.0, view.z).normalize_or_zero();
    let position = position + ahead * WALKING_SPEED * seconds;
    let turn = Quat::from_rotation_y((TURNING_SPEED_DEG * seconds).to_radians());
    seen_from(shot, position, position + turn * view)
}

/// The sun on a great circle that rises at 45 degrees to the horizon where the sun stands: both its height and its
/// heading change.
fn sun_after(light_dir: Vec3, seconds: f32) -> Vec3 {
    let light = light_dir.normalize_or(Vec3::NEG_Y);
    let level = light.cross(Vec3::Y).normalize_or(Vec3::X);
    let axis = (level + level.cross(light)).normalize_or(Vec3::X);
    Quat::from_axis_angle(axis, std::f32::consts::TAU / DAY * seconds) * light
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::format::PathKey;

    fn shot() -> Shot {
        Shot {
            scene: None,
            name: "front".to_owned(),
            position: [1.0, 2.0, 3.0],
            target: [1.0, 1.0, 1.0],
            up: [0.0, 1.0, 0.0],
            fov_y_deg: 60.0,
            near: 0.1,
            far: 100.0,
            width: 64,
            height: 36,
            light_dir: [-3.0, -4.0, 0.0],
        }
    }

    fn after_seconds(along: Along, path: Option<&CameraPath>, seconds: usize) -> Shot {
        sequence(along, &shot(), path, 60 * seconds + 1).pop().expect("frames")
    }

    #[test]
    fn sequences_begin_with_their_shot() {
        for along in [Along::Camera, Along::Fov] {
            assert_eq!(sequence(along, &shot(), None, 2)[0], shot(), "{along}");
        }
        let sun = Vec3::from(sequence(Along::Sun, &shot(), None, 1)[0].light_dir);
        assert!(sun.abs_diff_eq(Vec3::new(-0.6, -0.8, 0.0), 1e-6), "{sun}");
        assert!(sequence(Along::Sun, &shot(), None, 0).is_empty());
    }

    #[test]
    fn a_walker_goes_ahead_and_turns_left() {
        let later = after_seconds(Along::Camera, None, 3);
        let position = Vec3::from(later.position);
        assert!(position.abs_diff_eq(Vec3::new(1.0, 2.0, 3.0 - 4.2), 1e-3), "{position}");
        // Thirty degrees to the left of −z, as much downwards as before.
        let view = Vec3::from(later.target) - position;
        assert!(view.abs_diff_eq(Vec3::new(-1.0, -1.0, -3f32.sqrt()), 1e-3), "{view}");
        let down = Shot {
            target: [1.0, 0.0, 3.0],
            ..shot()
        };
        let later = sequence(Along::Camera, &down, None, 60).pop().expect("frames");
        assert_eq!(later.position, down.position);
    }

    #[test]
    fn paths_are_followed_at_their_own_speed() {
        let key = |time, x| PathKey {
            time,
            position: Vec3::X * x,
            target: Vec3::X * x + Vec3::Z,
        };
        let path = CameraPath {
            name: "walk".to_owned(),
            keys: vec![key(5.0, 0.0), key(9.0, 8.0)],
        };
        let later = after_seconds(Along::Camera, Some(&path), 2);
        assert!((later.position[0] - 4.0).abs() < 1e-3, "{later:?}");
        assert_eq!((later.target[2], later.fov_y_deg), (1.0, 60.0));
    }

    #[test]
    fn the_field_of_view_halves_in_two_seconds() {
        let later = after_seconds(Along::Fov, None, 2);
        assert!((later.fov_y_deg - 30.0).abs() < 1e-3);
        assert_eq!(later.position, shot().position);
    }

    #[test]
    fn the_sun_goes_round_in_a_day() {
        let start = Vec3::new(-0.6, -0.8, 0.0);
        let angle = |seconds| start.angle_between(sun_after(start, seconds)).to_degrees();
        // A great circle: the whole angle, not that of a small circle around a pole.
        assert!((angle(25.0) - 15.0).abs() < 1e-3, "{}", angle(25.0));
        assert!((angle(300.0) - 180.0).abs() < 0.1 && angle(600.0) < 0.1);
        let later = sun_after(start, 25.0);
        assert!(later.z.abs() > 0.1 && (later.y + 0.8).abs() > 0.05, "{later}");
        for dir in [Vec3::NEG_Y, Vec3::ZERO, Vec3::Y] {
            assert!(sun_after(dir, 1.0).is_normalized(), "{dir}");
        }
    }
}
