//! Truth and differences as pictures: red, green and blue of every pixel, row 0 on top.

use super::{accuracy::LIT_ABOVE, pixels::PixelTruth};

/// In shadow, where truth is lit.
pub const FALSE_SHADOW: [u8; 3] = [220, 30, 30];
/// Lit, where truth is in shadow.
pub const FALSE_LIT: [u8; 3] = [255, 160, 0];
/// Pixels that do not count.
pub const NOT_VALID: [u8; 3] = [40, 50, 90];

/// Truth: white lit, black in shadow, [`NOT_VALID`].
pub fn truth_picture(truth: &[PixelTruth]) -> Vec<[u8; 3]> {
    let color = |pixel: &PixelTruth| match pixel {
        PixelTruth::Lit => [255; 3],
        PixelTruth::Shadow => [0; 3],
        _ => NOT_VALID,
    };
    truth.iter().map(color).collect()
}

/// A mask against truth: [`FALSE_SHADOW`], [`FALSE_LIT`], [`NOT_VALID`]; right pixels are light or dark grey.
pub fn difference_picture(mask: &[u8], truth: &[PixelTruth]) -> Vec<[u8; 3]> {
    let color = |(value, pixel): (&u8, &PixelTruth)| match (pixel, *value > LIT_ABOVE) {
        (PixelTruth::Lit, false) => FALSE_SHADOW,
        (PixelTruth::Shadow, true) => FALSE_LIT,
        (PixelTruth::Lit, true) => [200; 3],
        (PixelTruth::Shadow, false) => [60; 3],
        _ => NOT_VALID,
    };
    mask.iter().zip(truth).map(color).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_their_colors() {
        use PixelTruth::{Edge, Lit, Shadow};
        let picture = difference_picture(&[0, 255, 255, 0, 0], &[Lit, Shadow, Lit, Shadow, Edge]);
        assert_eq!(picture, [FALSE_SHADOW, FALSE_LIT, [200; 3], [60; 3], NOT_VALID]);
    }
}
