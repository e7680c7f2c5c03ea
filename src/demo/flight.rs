//! Pictures along a camera path: what `play` shows where no window can be opened.

use crate::level::{format::CameraPath, shot::Shot};
use bevy::math::{UVec2, Vec3};

/// `count` shots at equal times along `path`, its ends included, named `flight-01` and so on; none for a path
/// without keys. `light_dir` is the direction in which sunlight travels.
pub fn shots(path: &CameraPath, light_dir: Vec3, count: u32, size: UVec2) -> Vec<Shot> {
    (0..count)
        .filter_map(|index| {
            let share = index as f32 / count.saturating_sub(1).max(1) as f32;
            let (position, target) = path.sample(path.duration() * share)?;
            Some(Shot {
                scene: None,
                name: format!("flight-{:02}", index + 1),
                position: position.to_array(),
                target: target.to_array(),
                up: [0.0, 1.0, 0.0],
                fov_y_deg: 60.0,
                near: 0.1,
                far: 1000.0,
                width: size.x,
                height: size.y,
                light_dir: light_dir.to_array(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::format::PathKey;

    fn path(keys: &[(f32, f32)]) -> CameraPath {
        CameraPath {
            name: "walk".into(),
            keys: keys
                .iter()
                .map(|&(time, x)| PathKey {
                    time,
                    position: Vec3::X * x,
                    target: Vec3::X * x + Vec3::Z,
                })
                .collect(),
        }
    }

    #[test]
    fn a_flight_begins_and_ends_with_its_path() {
        let shots = shots(
            &path(&[(0.0, 0.0), (5.0, 10.0), (10.0, 20.0)]),
            Vec3::NEG_Y,
            5,
            UVec2::new(480, 270),
        );
        let at: Vec<f32> = shots.iter().map(|shot| shot.position[0]).collect();
        assert_eq!(shots.len(), 5);
        for (x, expected) in at.iter().zip([0.0, 5.0, 10.0, 15.0, 20.0]) {
            assert!((x - expected).abs() < 1e-4, "{at:?}");
        }
        assert_eq!((shots[0].width, shots[0].height), (480, 270));
        assert_eq!(shots[4].name, "flight-05");
    }

    #[test]
    fn flights_of_one_or_no_picture_are_fine() {
        let one = shots(&path(&[(2.0, 7.0)]), Vec3::NEG_Y, 1, UVec2::ONE);
        assert_eq!(one.len(), 1);
        assert_eq!(one[0].position[0], 7.0);
        assert!(shots(&path(&[]), Vec3::NEG_Y, 8, UVec2::ONE).is_empty(), "no keys");
        assert!(
            shots(&path(&[(0.0, 0.0)]), Vec3::NEG_Y, 0, UVec2::ONE).is_empty(),
            "no pictures"
        );
    }
}
