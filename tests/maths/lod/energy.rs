//! How much of a crossing is seen.

use umbrage::maths::lod::{
    blend::{BlendKind, Layer, Pixel, blended},
    energy::{background_leak, largest_dither_energy, largest_energy, linear_light, picture_energy},
};

/// 0.4 s at 60 Hz.
const FRAMES: usize = 24;

/// Colours of a pixel over a crossing.
fn colors(kind: BlendKind, background: f64, [old, new]: [f64; 2], frames: usize) -> Vec<f64> {
    let pixel = |frame: usize| {
        let layer = |depth, color| [Layer { depth, color }];
        let behind = Pixel {
            color: background,
            depth: 0.1,
        };
        let t = frame as f64 / frames as f64;
        blended(behind, [&layer(old, 0.2), &layer(new, 0.7)], [0, 1], kind, t, true).color
    };
    (0..=frames).map(pixel).collect()
}

/// In squares of the whole change.
fn largest(colors: &[f64]) -> f64 {
    let steps = colors.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    steps.fold(0.0, f64::max) / 0.25
}

#[test]
fn closed_forms_are_the_energies_of_crossings() {
    for order in [[0.5, 0.6], [0.6, 0.5]] {
        let unpopping = largest(&colors(BlendKind::Unpopping, 1.0, order, FRAMES));
        assert!(
            (unpopping - largest_energy(BlendKind::Unpopping, 24.0)).abs() < 1e-12,
            "{unpopping}"
        );
        let hard = largest(&colors(BlendKind::Hard, 1.0, order, FRAMES));
        assert!((hard - largest_energy(BlendKind::Hard, 24.0)).abs() < 1e-12, "{hard}");
        for background in [0.2, 0.4, 0.7] {
            let plain = largest(&colors(BlendKind::Plain, background, order, FRAMES));
            assert!(plain <= largest_energy(BlendKind::Plain, 24.0), "{background}: {plain}");
        }
        // The farther level's colour: of the old one, then of the new one.
        let background = if order[0] < order[1] { 0.2 } else { 0.7 };
        let plain = largest(&colors(BlendKind::Plain, background, order, FRAMES));
        assert!((plain - 1.0 / 576.0).abs() < 1e-12, "{plain}");
    }
}

/// The promise of the project, in theory: at most 2 % of hard switching's and half of dithering's.
#[test]
fn unpopping_is_below_its_rivals() {
    let unpopping = largest_energy(BlendKind::Unpopping, 24.0);
    assert!((unpopping - 1.0 / 144.0).abs() < 1e-12);
    assert!(unpopping <= 0.02 && unpopping <= 0.5 * largest_dither_energy(24.0));
}

/// Bevy's pattern: 16 thresholds, each once in a tile of 4 x 4 pixels.
#[test]
fn dithering_changes_whole_pixels() {
    for frames in [3_u32, 10, 16, 24, 60] {
        let passed = |frame: u32| {
            (0..16)
                .filter(|k| f64::from(*k) + 0.5 < 16.0 * f64::from(frame) / f64::from(frames))
                .count()
        };
        let steps = (0..frames).map(|frame| passed(frame + 1) - passed(frame));
        let largest = steps.max().unwrap_or(0) as f64 / 16.0;
        assert!(largest <= largest_dither_energy(frames.into()), "{frames}: {largest}");
    }
    assert_eq!(largest_dither_energy(24.0), 1.0 / 16.0);
    assert_eq!(largest_dither_energy(1.0), 1.0);
}

#[test]
fn the_leak_of_plain_blending_peaks_at_a_quarter() {
    assert_eq!(background_leak(BlendKind::Plain, 0.5), 0.25);
    for i in 0..=100 {
        let t = f64::from(i) / 100.0;
        assert!(background_leak(BlendKind::Plain, t) <= 0.25);
        assert_eq!(background_leak(BlendKind::Unpopping, t), 0.0);
        // A dark thing before a white wall.
        let thing = [Layer { depth: 0.5, color: 0.0 }];
        let wall = Pixel { color: 1.0, depth: 0.1 };
        let pixel = blended(wall, [&thing, &thing], [0, 1], BlendKind::Plain, t, true);
        assert!((pixel.color - background_leak(BlendKind::Plain, t)).abs() < 1e-12);
    }
}

#[test]
fn pictures_are_compared_in_linear_light() {
    assert!((linear_light(255) - 1.0).abs() < 1e-6 && linear_light(0) == 0.0);
    assert!((linear_light(188) - 0.502_886).abs() < 1e-5, "{}", linear_light(188));
    let (black, white) = ([0, 0, 0, 255, 9, 9, 9, 255], [255, 255, 255, 0, 9, 9, 9, 255]);
    assert!((picture_energy(&black, &white) - 3.0).abs() < 1e-5);
    assert_eq!(picture_energy(&black, &black), 0.0);
}
