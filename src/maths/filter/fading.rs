//! Depth and share of a fading caster in one number of a depth texture: the twin of `shaders/fading.wgsl`.
//!
//! While an object changes its level of detail, the fading level takes a share of the light only. Casters that fade lie in
//! maps of their own, which hold the nearest of them in every texel: its depth, and the share in the eight last bits of
//! that. A lookup that finds nothing opaque before the receiver takes the share away. What is continuous in the share is
//! continuous in the result: no texel switches from lit to dark, as those of a dither do.

/// The last eight bits of the depth.
const MOST: u32 = 255;
/// The largest number below 1, in bits: depths of 1 (casters before the near plane) would lose their share in a texture, which
/// holds nothing larger.
const LARGEST: u32 = 0x3f7f_ffff;

/// A depth of reverse z, 0..=1, that carries how much of the light the caster takes, 0..=1 (others are clamped).
#[must_use]
pub fn fading_depth(depth: f32, share: f32) -> f32 {
    let share = (share.clamp(0.0, 1.0) * MOST as f32).round() as u32;
    f32::from_bits((depth.to_bits().min(LARGEST) & !MOST) | share)
}

/// The depth that such a depth carries: the same for every share, or texels would change while shares do. Never nearer to the
/// light than the caster's, and farther by at most 2⁻¹⁵ of it.
#[must_use]
pub fn depth_without_share(stored: f32) -> f32 {
    f32::from_bits(stored.to_bits() & !MOST)
}

/// The share that such a depth carries.
#[must_use]
pub fn fading_share(stored: f32) -> f32 {
    (stored.to_bits() & MOST) as f32 / MOST as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_stay_behind_and_shares_come_back() {
        for depth in [1.0, 0.75, 0.500_001, 0.1, 3e-4, 1e-20] {
            for share in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let stored = fading_depth(depth, share);
                assert!(stored < 1.0, "a texture holds no larger number than 1");
                let found = depth_without_share(stored);
                assert!(found <= depth, "{found} is nearer than {depth}");
                assert!(found >= depth * (1.0 - 1.0 / 32768.0), "{found} is far behind {depth}");
                assert_eq!(found, depth_without_share(fading_depth(depth, 0.3)), "share {share}");
                assert!((fading_share(stored) - share).abs() <= 0.501 / 255.0, "share {share}");
            }
        }
    }

    #[test]
    fn nothing_has_no_share() {
        assert_eq!(fading_share(0.0), 0.0);
        assert_eq!(
            depth_without_share(fading_depth(0.0, 1.0)),
            0.0,
            "the far end stays there"
        );
        assert_eq!(fading_share(fading_depth(0.5, 7.0)), 1.0);
        assert_eq!(fading_share(fading_depth(0.5, f32::NAN)), 0.0);
    }
}
