//! Pictures of truth and of what differs from it.

use crate::{
    cli::pictures::NOT_VALID,
    render::reference::{accuracy::LIT_ABOVE, pixels::PixelTruth},
};

const FALSE_SHADOW: [u8; 3] = [220, 30, 30];
const FALSE_LIT: [u8; 3] = [255, 160, 0];

/// Truth: lit white, shadow black.
pub(super) fn truth(truth: &[PixelTruth]) -> Vec<u8> {
    let color = |pixel: &PixelTruth| match pixel {
        PixelTruth::Lit => [255; 3],
        PixelTruth::Shadow => [0; 3],
        _ => NOT_VALID,
    };
    truth.iter().flat_map(color).collect()
}

/// A mask against truth: what is right grey, what is wrong in its color.
pub(super) fn difference(mask: &[u8], truth: &[PixelTruth]) -> Vec<u8> {
    let color = |(value, pixel): (&u8, &PixelTruth)| match (pixel, *value > LIT_ABOVE) {
        (PixelTruth::Lit, false) => FALSE_SHADOW,
        (PixelTruth::Shadow, true) => FALSE_LIT,
        (PixelTruth::Lit, true) => [200; 3],
        (PixelTruth::Shadow, false) => [60; 3],
        _ => NOT_VALID,
    };
    mask.iter().zip(truth).flat_map(color).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_their_colors() {
        use PixelTruth::{Edge, Lit, Shadow};
        let picture = difference(&[0, 255, 255, 0, 0], &[Lit, Shadow, Lit, Shadow, Edge]);
        let (colors, _) = picture.as_chunks::<3>();
        assert_eq!(colors, [FALSE_SHADOW, FALSE_LIT, [200; 3], [60; 3], NOT_VALID]);
    }
}
