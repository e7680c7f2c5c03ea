//! At which distances levels of detail are drawn.

use std::ops::Range;

/// Tangent of half the vertical field of view that distances are meant for: 60 degrees.
const HALF_VIEW: f32 = 0.577_350_3;

/// Camera distances in metres at which each level is drawn, without gaps, from 0 on.
///
/// `coverages` are shares of the picture's height down to which levels are meant (`MSFT_screencoverage`), falling; a
/// last one of 0 is drawn to any distance. A thing of height h covers the share h / (2 d tan 30°) at the distance d.
/// Distances are whole metres, so that instances of nearly equal scale share their ranges.
pub fn ranges(coverages: &[f32], height: f32) -> Vec<Range<f32>> {
    let mut from = 0.0;
    let range = |coverage: &f32| {
        let to = if *coverage > 0.0 {
            (height / (2.0 * HALF_VIEW * coverage)).ceil().max(from)
        } else {
            f32::INFINITY
        };
        let range = from..to;
        from = to;
        range
    };
    coverages.iter().map(range).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_ends_where_the_thing_covers_its_share() {
        // 11.547 m at 10 m fill a picture of 60 degrees.
        let ranges = ranges(&[1.0, 0.5, 0.0], 11.547_005);
        assert_eq!(ranges, [0.0..10.0, 10.0..20.0, 20.0..f32::INFINITY]);
    }

    #[test]
    fn ranges_never_overlap_whatever_a_file_says() {
        for coverages in [&[0.1, 0.5, 0.2][..], &[0.0, 0.3], &[f32::NAN, 0.1], &[0.5]] {
            let ranges = ranges(coverages, 3.0);
            assert_eq!(ranges.len(), coverages.len());
            for pair in ranges.windows(2) {
                assert!(pair[0].end == pair[1].start, "{ranges:?}");
            }
            assert!(ranges.iter().all(|range| range.start <= range.end), "{ranges:?}");
        }
    }
}
