//! The color of a ratio: the CPU twin of `heat_color` in `shaders/heat_map/texel_ratio.wgsl`, and the color of a sampling rate
//! ([`maths::sampling_rate`](crate::maths::sampling_rate)) as it is drawn.

use bevy::prelude::*;

use crate::maths::sampling_rate::rate_color;

/// Colors of 1/8, 1/4, 1/2, 1, 2, 4 and 8: blue is finer than the picture, green as fine, red coarser.
pub const STOPS: [LinearRgba; 7] = [
    LinearRgba::rgb(0.01, 0.01, 0.12),
    LinearRgba::rgb(0.01, 0.06, 0.6),
    LinearRgba::rgb(0.01, 0.4, 0.7),
    LinearRgba::rgb(0.03, 0.5, 0.05),
    LinearRgba::rgb(0.85, 0.65, 0.03),
    LinearRgba::rgb(0.85, 0.2, 0.01),
    LinearRgba::rgb(0.5, 0.01, 0.02),
];

/// The color of texel ÷ pixel; beyond the ends that of the end, for not a number that of the finest.
pub fn heat_color(ratio: f32) -> LinearRgba {
    let place = (ratio.log2() + 3.0).max(0.0).min(5.9999);
    let stop = place as usize;
    STOPS[stop].mix(&STOPS[stop + 1], place.fract())
}

/// The color of texels per pixel that `shaders/heat_map/sampling_rate.wgsl` draws.
pub fn sampling_color(texels_per_pixel: f32) -> LinearRgba {
    let color = rate_color(texels_per_pixel);
    Srgba::rgb(color.x, color.y, color.z).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_have_their_colors() {
        for (ratio, stop) in [(0.0, 0), (0.125, 0), (0.5, 2), (1.0, 3), (4.0, 5), (8.0, 6), (1e9, 6)] {
            let (color, wanted) = (heat_color(ratio), STOPS[stop]);
            assert!(
                (color.to_vec3() - wanted.to_vec3()).length() < 1e-3,
                "{ratio}: {color:?}"
            );
        }
        assert_eq!(heat_color(f32::NAN).to_vec3(), STOPS[0].to_vec3());
    }
}
