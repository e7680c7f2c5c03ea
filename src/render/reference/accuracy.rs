//! A mask against truth: [`Accuracy`].

use bevy::math::UVec2;
use serde::{Deserialize, Serialize};

use super::pixels::PixelTruth;

/// Pixels of a true shadow edge lie within this distance of a pixel with the other truth, in pixels.
pub const BAND: i32 = 3;

/// Mask values above it are lit.
pub const LIT_ABOVE: u8 = 127;

/// How many pixels there are of every kind; together they are the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kinds {
    /// [`PixelTruth::Sky`].
    pub sky: u32,
    /// [`PixelTruth::Unmatched`].
    pub unmatched: u32,
    /// [`PixelTruth::FacesAway`].
    pub faces_away: u32,
    /// [`PixelTruth::Edge`].
    pub edge: u32,
    /// [`PixelTruth::Unsure`].
    pub unsure: u32,
    /// [`PixelTruth::Lit`].
    pub lit: u32,
    /// [`PixelTruth::Shadow`].
    pub shadow: u32,
}

impl Kinds {
    /// Counts the pixels of a picture.
    pub fn of(truth: &[PixelTruth]) -> Self {
        let mut kinds = Self::default();
        for pixel in truth {
            *match pixel {
                PixelTruth::Sky => &mut kinds.sky,
                PixelTruth::Unmatched => &mut kinds.unmatched,
                PixelTruth::FacesAway => &mut kinds.faces_away,
                PixelTruth::Edge => &mut kinds.edge,
                PixelTruth::Unsure => &mut kinds.unsure,
                PixelTruth::Lit => &mut kinds.lit,
                PixelTruth::Shadow => &mut kinds.shadow,
            } += 1;
        }
        kinds
    }
}

/// Counts of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Valid ones.
    pub valid: u32,
    /// In shadow, where truth is lit.
    pub false_shadow: u32,
    /// Lit, where truth is in shadow.
    pub false_lit: u32,
}

impl Counts {
    /// Counts one valid pixel.
    pub fn add(&mut self, truth_lit: bool, mask_lit: bool) {
        self.valid += 1;
        match (truth_lit, mask_lit) {
            (true, false) => self.false_shadow += 1,
            (false, true) => self.false_lit += 1,
            _ => {}
        }
    }

    /// Share of valid pixels that are wrong, 0..=1; 0 without valid pixels.
    pub fn wrong_share(&self) -> f64 {
        self.share(self.false_shadow + self.false_lit)
    }

    /// Share of a count in the valid pixels.
    pub fn share(&self, count: u32) -> f64 {
        if self.valid == 0 {
            0.0
        } else {
            f64::from(count) / f64::from(self.valid)
        }
    }
}

/// How a mask agrees with truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Accuracy {
    /// All pixels of the picture.
    pub pixels: u32,
    /// Valid pixels.
    pub overall: Counts,
    /// Those within [`BAND`] of a true shadow edge.
    pub band: Counts,
}

/// Compares a mask (255 lit, 0 in shadow, row 0 on top) with truth. Lists of different lengths are compared as far as
/// both go.
pub fn compare(size: UVec2, mask: &[u8], truth: &[PixelTruth]) -> Accuracy {
    let band = edge_band(size, truth);
    Accuracy {
        pixels: size.x * size.y,
        overall: count_where(mask, truth, |_| true),
        band: count_where(mask, truth, |index| band[index]),
    }
}

/// Compares the valid pixels of which `counts` is true, by their index.
pub fn count_where(mask: &[u8], truth: &[PixelTruth], counts: impl Fn(usize) -> bool) -> Counts {
    let mut sum = Counts::default();
    for (index, (value, pixel)) in mask.iter().zip(truth).enumerate() {
        if pixel.is_valid() && counts(index) {
            sum.add(*pixel == PixelTruth::Lit, *value > LIT_ABOVE);
        }
    }
    sum
}

/// Which valid pixels lie within [`BAND`] of a true shadow edge.
pub fn edge_band(size: UVec2, truth: &[PixelTruth]) -> Vec<bool> {
    (0..truth.len())
        .map(|index| truth[index].is_valid() && is_near_edge(size, truth, index))
        .collect()
}

fn is_near_edge(size: UVec2, truth: &[PixelTruth], index: usize) -> bool {
    let width = size.x as i32;
    if width <= 0 {
        return false;
    }
    let (x, y) = (index as i32 % width, index as i32 / width);
    (-BAND..=BAND).any(|dy| {
        (-BAND..=BAND).any(|dx| {
            let (nx, ny) = (x + dx, y + dy);
            let is_inside = dx * dx + dy * dy <= BAND * BAND && nx >= 0 && nx < width && ny >= 0;
            let other = is_inside.then(|| truth.get((ny * width + nx) as usize)).flatten();
            other.is_some_and(|other| other.is_valid() && *other != truth[index])
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use PixelTruth::{Edge, Lit, Shadow, Sky};

    const SIZE: UVec2 = UVec2::new(12, 1);
    const TRUTH: [PixelTruth; 12] = [Lit, Lit, Lit, Lit, Lit, Lit, Shadow, Shadow, Edge, Shadow, Shadow, Sky];

    #[test]
    fn a_perfect_mask_has_no_errors() {
        let mask = TRUTH.map(|pixel| if pixel == Shadow { 0 } else { 255 });
        let accuracy = compare(SIZE, &mask, &TRUTH);
        assert_eq!((accuracy.pixels, accuracy.overall.valid), (12, 10));
        assert_eq!(accuracy.overall.wrong_share(), 0.0);
        // Three on the lit side, and 6, 7 and (across the edge pixel) nothing farther than 3 on the other.
        assert_eq!(accuracy.band.valid, 3 + 2);
    }

    #[test]
    fn errors_have_kinds_and_places() {
        let mut mask = TRUTH.map(|pixel| if pixel == Shadow { 0 } else { 255 });
        mask[0] = 127; // false shadow far from the edge
        mask[5] = 0; // false shadow in the band
        mask[10] = 128; // false lit outside
        mask[8] = 0; // not valid
        mask[11] = 0; // not valid
        let accuracy = compare(SIZE, &mask, &TRUTH);
        assert_eq!(
            accuracy.overall,
            Counts {
                valid: 10,
                false_shadow: 2,
                false_lit: 1
            }
        );
        assert_eq!(
            accuracy.band,
            Counts {
                valid: 5,
                false_shadow: 1,
                false_lit: 0
            }
        );
        assert!((accuracy.overall.wrong_share() - 0.3).abs() < 1e-12);
    }

    #[test]
    fn every_pixel_has_one_kind() {
        let kinds = Kinds::of(&TRUTH);
        let expected = Kinds {
            sky: 1,
            edge: 1,
            lit: 6,
            shadow: 4,
            ..Kinds::default()
        };
        assert_eq!(kinds, expected);
        let others = Kinds::of(&[PixelTruth::Unmatched, PixelTruth::FacesAway, PixelTruth::Unsure]);
        assert_eq!((others.unmatched, others.faces_away, others.unsure), (1, 1, 1));
    }

    #[test]
    fn chosen_pixels_are_counted_alone() {
        let mask = [0; 12];
        let band = edge_band(SIZE, &TRUTH);
        let outside = count_where(&mask, &TRUTH, |index| !band[index]);
        // Pixels 0, 1, 2 are lit and outside, 9 and 10 in shadow and outside.
        assert_eq!((outside.valid, outside.false_shadow, outside.false_lit), (5, 3, 0));
    }

    #[test]
    fn nothing_valid_is_nothing_wrong() {
        assert_eq!(compare(SIZE, &[0; 12], &[Sky; 12]).overall.wrong_share(), 0.0);
        assert_eq!(compare(SIZE, &[], &[]).overall, Counts::default());
        assert_eq!(
            compare(UVec2::ZERO, &[0], &[Lit]).band,
            Counts::default(),
            "no width, no neighbors"
        );
    }
}
