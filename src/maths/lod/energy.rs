//! How much of a change of level is seen.
//!
//! *Pop energy* of a frame: the squared change of the picture from the frame before that is due to levels of detail, summed
//! over pixels and channels, in linear light. A crossing that takes n frames spreads the same change over more frames, and
//! squares reward it. For a pixel that both levels cover and that changes by Δ in all:
//!
//! | kind | largest energy of a frame | n = 24 (0.4 s at 60 Hz) |
//! |---|---|---|
//! | hard | Δ² | 1 |
//! | ordered dither with 16 levels | Δ² ⌈16 ÷ n⌉ ÷ 16 on average over a tile of the pattern | 1 ÷ 16 |
//! | plain, over a background of the farther level's colour | Δ² ÷ n² | 1 ÷ 576 |
//! | Unpopping | 4 Δ² ÷ n² | 1 ÷ 144 |
//!
//! Unpopping changes a pixel in one half of the crossing only: in the first where the new level is nearer, in the second
//! where the old one is. Plain blending is smoother still, at a price: its *background leak*, the share of the background
//! that shines through a solid object, is t (1 − t), up to a quarter; Unpopping's is 0.

use super::blend::BlendKind;

/// Levels of Bevy's ordered dither.
pub const DITHER_LEVELS: f64 = 16.0;

/// Share of the background in a pixel that both levels cover, at t.
#[must_use]
pub fn background_leak(kind: BlendKind, t: f64) -> f64 {
    match kind {
        BlendKind::Hard | BlendKind::Unpopping => 0.0,
        BlendKind::Plain => t * (1.0 - t),
    }
}

/// The largest energy of a frame, in squares of the whole change, of a pixel that both levels cover, over a crossing of so
/// many frames, at least 2. Of plain blending the upper bound that holds for any background as bright as one of both
/// levels, or between them.
#[must_use]
pub fn largest_energy(kind: BlendKind, frames: f64) -> f64 {
    match kind {
        BlendKind::Hard => 1.0,
        // d/dt of t new + (1 − t)² old + t (1 − t) background, where the new one is nearer: at most 2 between old and new.
        BlendKind::Plain | BlendKind::Unpopping => (2.0 / frames.max(2.0)).powi(2),
    }
}

/// The same for ordered dither: whole pixels change, as many at once as thresholds lie within a frame's step.
#[must_use]
pub fn largest_dither_energy(frames: f64) -> f64 {
    (DITHER_LEVELS / frames.max(1.0)).ceil().min(DITHER_LEVELS) / DITHER_LEVELS
}

/// Light of a channel of 8 bits in sRGB, 0..=1.
#[must_use]
pub fn linear_light(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        bevy_math::ops::powf(((encoded + 0.055) / 1.055) as f32, 2.4).into()
    }
}

/// Energy of the change from one picture to another in 8-bit sRGB with alpha, as rows of RGBA bytes of equal length: squares
/// of linear light, summed over pixels and colours.
#[must_use]
pub fn picture_energy(before: &[u8], after: &[u8]) -> f64 {
    let light: [f64; 256] = std::array::from_fn(|code| linear_light(code as u8));
    let (before, after) = (before.as_chunks::<4>().0, after.as_chunks::<4>().0);
    let pixels = before.iter().zip(after).filter(|(a, b)| a != b);
    pixels
        .map(|(a, b)| {
            let change = |i: usize| (light[usize::from(a[i])] - light[usize::from(b[i])]).powi(2);
            change(0) + change(1) + change(2)
        })
        // The sum of nothing is -0.
        .fold(0.0, |sum, energy| sum + energy)
}
