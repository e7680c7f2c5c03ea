//! The states of Unpopping on pixels.

use umbrage::maths::lod::blend::{BlendKind, Coat, Layer, Pixel, blended, coats};

const BACKGROUND: Pixel = Pixel { color: 1.0, depth: 0.1 };
const TIMES: [f64; 9] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

fn layer(depth: f64, color: f64) -> Layer {
    Layer { depth, color }
}

fn unpopped(old: &[Layer], new: &[Layer], t: f64) -> Pixel {
    blended(BACKGROUND, [old, new], [0, 1], BlendKind::Unpopping, t, true)
}

/// Giegl, figure 7.2.
#[test]
fn the_table_of_states() {
    let faded = |alpha| Coat {
        alpha,
        writes_depth: false,
    };
    assert_eq!(coats(BlendKind::Unpopping, 0.25), [Coat::OPAQUE, faded(0.5)]);
    assert_eq!(coats(BlendKind::Unpopping, 0.5), [faded(1.0), Coat::OPAQUE]);
    assert_eq!(coats(BlendKind::Unpopping, 0.75), [faded(0.5), Coat::OPAQUE]);
    assert_eq!(coats(BlendKind::Plain, 0.25), [faded(0.75), faded(0.25)]);
    for kind in [BlendKind::Hard, BlendKind::Plain, BlendKind::Unpopping] {
        assert_eq!(coats(kind, 0.0), [Coat::OPAQUE, Coat::HIDDEN], "{kind:?}");
        assert_eq!(coats(kind, 1.0), [Coat::HIDDEN, Coat::OPAQUE], "{kind:?}");
    }
    assert_eq!(coats(BlendKind::Unpopping, -1.0), [Coat::OPAQUE, Coat::HIDDEN]);
}

/// Giegl, oracles O27 and O31: the ends, and the depth left behind.
#[test]
fn one_level_owns_the_depth_buffer() {
    for (old, new) in [(0.5, 0.6), (0.6, 0.5), (0.5, 0.5)] {
        let (old, new) = ([layer(old, 0.2)], [layer(new, 0.7)]);
        for t in TIMES {
            let expected = if t < 0.5 { old[0].depth } else { new[0].depth };
            assert_eq!(unpopped(&old, &new, t).depth, expected, "{t}");
        }
        assert_eq!(unpopped(&old, &new, 0.0).color, 0.2);
        assert_eq!(unpopped(&old, &new, 1.0).color, 0.7);
    }
}

/// Giegl, oracle O28.
#[test]
fn nothing_behind_shines_through() {
    let (old, new) = ([layer(0.5, 0.0)], [layer(0.6, 0.0)]);
    for t in TIMES {
        for pair in [[&old[..], &new], [&new, &old]] {
            let unpopped = unpopped(pair[0], pair[1], t);
            assert_eq!(unpopped.color, 0.0, "{t}");
            let plain = blended(BACKGROUND, pair, [0, 1], BlendKind::Plain, t, true);
            assert!((plain.color - t * (1.0 - t)).abs() < 1e-15, "{t}: {}", plain.color);
        }
    }
}

/// The jump at t = ½: the difference of the picture just before and at it.
fn jump(old: &[Layer], new: &[Layer], is_nearest_only: bool) -> f64 {
    let at = |t| blended(BACKGROUND, [old, new], [0, 1], BlendKind::Unpopping, t, is_nearest_only).color;
    (at(0.5 - 1e-9) - at(0.5)).abs()
}

/// Giegl, oracle O29 and the conditions of section 7.2 that make it true.
#[test]
fn the_picture_is_continuous_where_roles_change() {
    assert!(
        jump(&[layer(0.5, 0.2)], &[layer(0.6, 0.7)], true) < 1e-8,
        "new one nearer"
    );
    assert!(
        jump(&[layer(0.6, 0.2)], &[layer(0.5, 0.7)], true) < 1e-8,
        "old one nearer"
    );
    assert!(
        jump(&[layer(0.5, 0.2)], &[layer(0.5, 0.7)], true) < 1e-8,
        "shared surface"
    );
    let hollow = [layer(0.7, 0.7), layer(0.6, 0.0)];
    assert!(
        jump(&[layer(0.5, 0.2)], &hollow, true) < 1e-8,
        "two layers of the new one"
    );
    assert!(
        jump(&hollow, &[layer(0.5, 0.2)], true) < 1e-8,
        "two layers of the old one"
    );
    assert!(
        jump(&[layer(0.5, 0.2)], &hollow, false) > 0.5,
        "layers that are not reduced to the nearest make it jump"
    );
    // If the fading level always won ties, or always lost them, shared surfaces would jump by all that they differ.
    let tie = |wins: bool, coat| {
        BACKGROUND
            .drawn(&[layer(0.5, 0.2)], Coat::OPAQUE, true)
            .drawn(&[layer(0.5, 0.7)], coat, wins)
    };
    let opaque = coats(BlendKind::Unpopping, 0.5 - 1e-9)[1];
    assert!((tie(true, opaque).color - tie(false, opaque).color).abs() > 0.49);
}

/// Giegl, oracle O30.
#[test]
fn crossings_look_the_same_from_both_ends() {
    for (fine, coarse) in [(0.5, 0.6), (0.6, 0.5), (0.5, 0.5)] {
        let (fine, coarse) = ([layer(fine, 0.2), layer(0.3, 0.9)], [layer(coarse, 0.7)]);
        for t in TIMES.into_iter().filter(|t| *t != 0.5) {
            let away = blended(BACKGROUND, [&fine, &coarse], [0, 1], BlendKind::Unpopping, t, true);
            let back = blended(
                BACKGROUND,
                [&coarse, &fine],
                [1, 0],
                BlendKind::Unpopping,
                1.0 - t,
                true,
            );
            assert!(
                (away.color - back.color).abs() <= 1e-15 && away.depth == back.depth,
                "{t}: {away:?} {back:?}"
            );
        }
    }
}

/// Section 7.3: where only one level covers a pixel, it blends with the scene; where nothing follows, all of it does.
#[test]
fn rims_and_vanishing_things_blend_with_the_scene() {
    let thing = [layer(0.5, 0.0)];
    let colors = TIMES.map(|t| unpopped(&thing, &[], t).color);
    assert_eq!(colors, [0.0, 0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0]);
    let depths = TIMES.map(|t| unpopped(&thing, &[], t).depth);
    assert_eq!(depths, [0.5, 0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0.1, 0.1]);
}
