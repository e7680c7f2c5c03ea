//! The blend of the shadow result with the frame before.

use bevy_math::{DMat4, DVec3, UVec2};
use umbrage::maths::stable::blend_history::{BlendedFrame, REACH, blend};

use crate::support::close;

const SIZE: UVec2 = UVec2::new(24, 16);

/// A camera that looks along −z, moved sideways by some pixels of a wall 10 m away.
struct Wall {
    clip_from_world: DMat4,
    aside: f64,
}

/// Metres of the wall per pixel.
fn pixel() -> f64 {
    2.0 * 10.0 * 0.5f64.tan() / f64::from(SIZE.y)
}

impl Wall {
    fn new(pixels: f64) -> Self {
        let aside = pixels * pixel();
        let projection = DMat4::perspective_infinite_reverse_rh(1.0, f64::from(SIZE.x) / f64::from(SIZE.y), 0.1);
        Self {
            clip_from_world: projection * DMat4::from_translation(DVec3::new(-aside, 0.0, 0.0)),
            aside,
        }
    }

    fn positions(&self) -> Vec<Option<DVec3>> {
        let place = |index: u32| {
            let (x, y) = (f64::from(index % SIZE.x) + 0.5, f64::from(index / SIZE.x) + 0.5);
            DVec3::new(
                self.aside + (x - f64::from(SIZE.x) / 2.0) * pixel(),
                -(y - f64::from(SIZE.y) / 2.0) * pixel(),
                -10.0,
            )
        };
        (0..SIZE.x * SIZE.y).map(|index| Some(place(index))).collect()
    }

    /// A shadow on the wall from x on, in pixels from the middle of the first camera, with soft edges of a pixel.
    fn shadow(&self, from: f64, to: f64) -> Vec<f32> {
        let values = self.positions().into_iter().flatten().map(|position| {
            let x = position.x / pixel();
            let covered = (x + 0.5 - from).clamp(0.0, 1.0).min((to - x + 0.5).clamp(0.0, 1.0));
            1.0 - covered as f32
        });
        values.collect()
    }

    fn blended<'a>(&self, visibility: &'a [f32], view_depths: &'a [f32]) -> BlendedFrame<'a> {
        BlendedFrame {
            size: SIZE,
            clip_from_world: self.clip_from_world,
            view_depth_from_world: DVec3::NEG_Z.extend(0.0),
            visibility,
            view_depths,
        }
    }
}

fn depths() -> Vec<f32> {
    vec![10.0; (SIZE.x * SIZE.y) as usize]
}

#[test]
fn what_stands_still_stays() {
    let wall = Wall::new(0.0);
    let shadow = wall.shadow(-4.0, 3.0);
    let depths = depths();
    let blended = blend(SIZE, &shadow, &wall.positions(), &wall.blended(&shadow, &depths), 0.25);
    for (a, b) in blended.iter().zip(&shadow) {
        close(f64::from(*a), f64::from(*b), 1.0e-6);
    }
}

/// One jump of an edge by less than a texel: the sum of squared changes is that of a jump at once ÷ (2N − 1).
#[test]
fn a_jump_is_spread_over_frames() {
    let wall = Wall::new(0.0);
    let depths = depths();
    let (before, after) = (wall.shadow(0.0, 9.0), wall.shadow(0.4, 9.0));
    let at_once: f64 = before.iter().zip(&after).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    for frames in [2.0, 4.0, 8.0] {
        let mut now = before.clone();
        let mut sum = 0.0;
        for _ in 0..200 {
            let next = blend(
                SIZE,
                &after,
                &wall.positions(),
                &wall.blended(&now, &depths),
                1.0 / frames,
            );
            sum += now
                .iter()
                .zip(&next)
                .map(|(a, b)| f64::from(a - b).powi(2))
                .sum::<f64>();
            now = next;
        }
        close(sum / at_once, 1.0 / (2.0 * frames - 1.0), 1.0e-3);
        assert!(
            now.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1.0e-4),
            "it arrives"
        );
    }
}

/// A shadow that leaps farther than the reach: where the new result has no edge nearby, nothing of the old one is left.
#[test]
fn shadows_that_move_leave_no_trail() {
    let wall = Wall::new(0.0);
    let depths = depths();
    let (before, after) = (wall.shadow(-11.0, -7.0), wall.shadow(2.0, 6.0));
    let blended = blend(SIZE, &after, &wall.positions(), &wall.blended(&before, &depths), 0.1);
    let mut lagging = 0;
    for (index, (blended, after)) in blended.iter().zip(&after).enumerate() {
        let x = (index as i32 % SIZE.x as i32) - 12;
        let distance = [2, 6].into_iter().map(|edge: i32| (x - edge).abs()).min().unwrap_or(0);
        if distance > REACH + 1 {
            assert_eq!(blended, after, "{x}");
        } else {
            lagging += i32::from(blended != after);
        }
    }
    assert!(lagging > 16, "edges lag");
}

/// The camera moves by whole pixels and by parts: the history is found where the surface was.
#[test]
fn the_history_moves_with_the_surface() {
    let (first, depths) = (Wall::new(0.0), depths());
    for pixels in [3.0, 2.5] {
        let second = Wall::new(pixels);
        let (before, now) = (first.shadow(-4.0, 3.0), second.shadow(-4.0, 3.0));
        let frame = first.blended(&before, &depths);
        let blended = blend(SIZE, &now, &second.positions(), &frame, 0.25);
        let worst = blended
            .iter()
            .zip(&now)
            .map(|(a, b)| f64::from(a - b).abs())
            .fold(0.0, f64::max);
        // Half a pixel of a ramp of one pixel: a corner is off by a quarter at most, and a quarter of it is new.
        let bound = if pixels == 3.0 { 1.0e-5 } else { 0.75 * 0.25 + 1.0e-5 };
        assert!(worst <= bound, "{pixels}: {worst}");
    }
}

#[test]
fn what_was_not_seen_is_new() {
    let wall = Wall::new(0.0);
    let (shadow, lit) = (wall.shadow(-4.0, 3.0), vec![1.0; (SIZE.x * SIZE.y) as usize]);
    let positions = wall.positions();
    // Something stood before the wall; the sky; a picture that ends there; a camera that looks away.
    for depth in [9.0, 0.0, f32::NAN] {
        let depths = vec![depth; lit.len()];
        assert_eq!(
            blend(SIZE, &shadow, &positions, &wall.blended(&lit, &depths), 0.1),
            shadow,
            "{depth}"
        );
    }
    let (far, depths) = (Wall::new(100.0), depths());
    assert_eq!(
        blend(SIZE, &shadow, &positions, &far.blended(&lit, &depths), 0.1),
        shadow
    );
    let mut behind = wall.blended(&lit, &depths);
    behind.clip_from_world = wall.clip_from_world * DMat4::from_rotation_y(std::f64::consts::PI);
    assert_eq!(blend(SIZE, &shadow, &positions, &behind, 0.1), shadow);
    assert_eq!(blend(SIZE, &[], &positions, &behind, 0.1), Vec::<f32>::new(), "nothing");
    let sky = vec![None; lit.len()];
    assert_eq!(blend(SIZE, &shadow, &sky, &behind, 0.1), lit, "the sky is lit");
}
