//! A deer's colours: one picture of its left side, projected along x.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    portable::{mix, smooth, srgb_code},
    texture::{
        noise::octaves,
        picture::{Channels, Picture, quantised},
    },
};

/// Texels per side.
const SIDE: usize = 512;
/// Lower rear corner of the picture in metres: z and y.
const LOW: Vec2 = Vec2::new(-0.90, -0.03);
/// Metres that the picture covers along z and y.
const SIZE: Vec2 = Vec2::new(2.05, 1.85);
/// Shades per channel in the file.
const SHADES: u32 = 40;

/// Where a place is in the picture; antlers take their colour from a strip above the head.
pub(super) fn coordinates(p: Vec3, antler: bool) -> Vec2 {
    let at = if antler {
        Vec2::new(mix(-0.8, 1.0, smooth(1.5, 2.3, p.y)), 1.77)
    } else {
        Vec2::new(p.z, p.y.min(1.70))
    };
    let share = (at - LOW) / SIZE;
    Vec2::new(share.x, 1.0 - share.y).clamp(Vec2::ZERO, Vec2::ONE)
}

pub(super) fn picture() -> Picture {
    Picture::from_fn("deer", SIDE, SIDE, Channels::Rgb, |x, y| {
        let share = Vec2::new(x as f32 + 0.5, (SIDE - 1 - y) as f32 + 0.5) / SIDE as f32;
        let at = LOW + share * SIZE;
        let color = if at.y > 1.73 {
            antler(share.x, share)
        } else {
            fur(at, share)
        };
        let [r, g, b] = color
            .to_array()
            .map(|c| quantised(f32::from(srgb_code(c)) / 255.0, SHADES));
        [r, g, b, 255]
    })
}

/// Brown and rough below, polished above.
fn antler(height: f32, share: Vec2) -> Vec3 {
    let grain = octaves(21, share, (16, 64), 2);
    let brown = Vec3::new(0.10, 0.062, 0.036);
    brown.lerp(Vec3::new(0.42, 0.34, 0.24), smooth(0.45, 0.95, height)) * (1.0 + 0.4 * grain)
}

/// How much of a spot covers a place: 1 inside `radius`, 0 outside 1.6 of it.
fn spot(at: Vec2, middle: Vec2, size: Vec2) -> f32 {
    smooth(1.6, 0.8, ((at - middle) / size).length())
}

/// Linear colour at z and y in metres.
fn fur(at: Vec2, share: Vec2) -> Vec3 {
    let v = Vec2::new;
    let ragged = 0.05 * octaves(11, share, (9, 9), 3);
    let at = at + v(ragged, 0.7 * ragged);
    let mut color = Vec3::new(0.150, 0.069, 0.032);
    let mut cover = |tint: Vec3, amount: f32| color = color.lerp(tint, amount.clamp(0.0, 1.0));
    let pale = Vec3::new(0.30, 0.21, 0.125);
    let dark = Vec3::new(0.070, 0.042, 0.026);
    // Darker back, paler belly and inside of the thighs.
    cover(
        Vec3::new(0.115, 0.056, 0.028),
        0.8 * smooth(1.10, 1.22, at.y) * smooth(0.38, 0.2, at.x),
    );
    cover(
        pale,
        0.75 * smooth(0.86, 0.74, at.y) * smooth(-0.62, -0.45, at.x) * smooth(0.22, 0.05, at.x),
    );
    // Neck: a dark mane below.
    let mane = smooth(0.30, 0.48, at.x) * smooth(0.82, 0.95, at.y) * smooth(1.40, 1.25, at.y);
    cover(Vec3::new(0.052, 0.030, 0.018), 0.9 * mane);
    // Legs: grey-brown, black at the hooves.
    cover(Vec3::new(0.072, 0.047, 0.031), 0.95 * smooth(0.80, 0.55, at.y));
    cover(dark, 0.5 * smooth(0.46, 0.40, at.y) * smooth(0.30, 0.34, at.y));
    cover(Vec3::new(0.018, 0.014, 0.012), smooth(0.075, 0.052, at.y));
    // The mirror of the rump, with a dark border.
    cover(dark, 0.7 * smooth(-0.60, -0.66, at.x) * smooth(0.80, 0.86, at.y));
    cover(
        Vec3::new(0.60, 0.47, 0.29),
        smooth(-0.645, -0.69, at.x) * smooth(0.80, 0.88, at.y),
    );
    // Head: grey, pale chin and eye ring, dark muzzle; black eye and nostril.
    let head = smooth(0.70, 0.80, at.x) * smooth(1.34, 1.40, at.y);
    cover(Vec3::new(0.185, 0.105, 0.058), head);
    cover(pale, head * smooth(1.415, 1.385, at.y - 0.12 * (0.98 - at.x)));
    cover(pale, 0.6 * spot(at, v(0.80, 1.520), v(0.035, 0.028)));
    cover(dark, smooth(0.98, 1.03, at.x) * smooth(1.38, 1.40, at.y));
    cover(pale, 0.8 * spot(at, v(1.035, 1.375), v(0.03, 0.012)));
    // Ears: pale inside, which is their front.
    cover(pale, 0.7 * smooth(1.60, 1.63, at.y));
    let strand = octaves(12, share, (24, 40), 3);
    color *= 1.0 + 0.45 * strand;
    let still = at - v(ragged, 0.7 * ragged);
    let black = spot(still, v(0.808, 1.523), v(0.013, 0.0105)).max(spot(still, v(1.052, 1.412), v(0.010, 0.007)));
    color.lerp(Vec3::new(0.008, 0.006, 0.005), black)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_find_their_texels() {
        let picture = picture();
        let seen = |p: Vec3| picture.nearest(coordinates(p, false)).expect("a texel");
        let [r, g, b, _] = seen(Vec3::new(0.2, 1.0, 0.0));
        assert!(r > g && g > b, "brown flank");
        assert!(
            seen(Vec3::new(0.05, 1.523, 0.808))[..3].iter().all(|c| *c < 30),
            "black eye"
        );
        assert!(seen(Vec3::new(0.0, 0.95, -0.74))[0] > 170, "pale rump");
        assert!(coordinates(Vec3::new(0.0, 3.0, 9.0), true).max_element() <= 1.0);
    }
}
