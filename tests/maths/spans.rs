//! The free parameter for tilted light: readings of its formula, pseudo planes.

use proptest::prelude::*;
use umbrage::maths::warp::{OptimumRule, WarpSpan};

use crate::support::close;

/// Scherzer, table 3.2 (z_n = 0.1, d = 69.9) and oracles 3 and 4; the demonstration program's rule besides.
#[test]
fn readings_of_the_optimum() {
    let (near, extent): (f64, f64) = (0.1, 69.9);
    let by = |rule, sine: f64| WarpSpan::directional_by(rule, extent, near, sine).optimal_warp_near();
    for (angle, literal, derived) in [
        (90.0, 2.7458, 2.7458),
        (60.0, 3.1705, 2.9588),
        (45.0, 3.8831, 3.2887),
        (30.0, 5.4915, 3.9443),
        (20.0, 8.0280, 4.8226),
        (10.0, 15.8122, 6.9465),
        (5.0, 31.504, 10.176),
        (1.0, 157.33, 26.547),
        (0.1, 1573.2, 142.66),
    ] {
        let sine = f64::to_radians(angle).sin();
        close(by(OptimumRule::Literal, sine), literal, 1.0e-4);
        close(by(OptimumRule::Derived, sine), derived, 1.0e-4);
        let demo_near = near / sine;
        let demo = (demo_near + (demo_near * (demo_near + extent * sine)).sqrt()) / sine;
        close(by(OptimumRule::Demo, sine), demo, 1.0e-12);
        assert!(
            demo >= derived * (1.0 - 1.0e-4),
            "the demonstration program warps less than the derivation"
        );
    }
    for rule in [OptimumRule::Literal, OptimumRule::Derived, OptimumRule::Demo] {
        close(by(rule, 1.0), 2.745_751, 1.0e-6);
        for sine in [0.0, -0.5, f64::NAN] {
            assert_eq!(by(rule, sine), f64::INFINITY, "{rule:?}, sin γ = {sine}");
            assert_eq!(
                WarpSpan::directional_by(rule, extent, near, sine).warp_near(1.0),
                f64::INFINITY
            );
        }
    }
    close(
        by(OptimumRule::Literal, 0.5),
        2.0 * by(OptimumRule::Literal, 1.0),
        1.0e-12,
    );
    // PSM is the same to every reading but the last.
    let strongest = |rule| WarpSpan::directional_by(rule, extent, near, 0.5).warp_near(1.0);
    close(
        strongest(OptimumRule::Literal),
        strongest(OptimumRule::Derived),
        1.0e-12,
    );
    close(
        strongest(OptimumRule::Demo),
        2.0 * strongest(OptimumRule::Derived),
        1.0e-12,
    );
}

proptest! {
    /// Scherzer, oracle 3: n_opt grows with Δz, falls with sin γ, and is at least 2 z_n ÷ sin γ.
    #[test]
    fn the_optimum_is_monotone(near in 0.05..5.0, extent in 0.5..500.0, sine in 0.05..0.99) {
        for rule in [OptimumRule::Literal, OptimumRule::Derived, OptimumRule::Demo] {
            let optimum = |extent, sine| WarpSpan::directional_by(rule, extent, near, sine).optimal_warp_near();
            prop_assert!(optimum(extent * 1.01, sine) > optimum(extent, sine));
            prop_assert!(optimum(extent, sine * 1.01) < optimum(extent, sine));
            prop_assert!(optimum(extent, sine) >= 2.0 * near / sine);
        }
    }

    /// The strength of every rule and pair of pseudo planes is the inverse of its n', falls with n', and ends at `PSM`.
    #[test]
    fn strengths_are_inverse(
        near in 0.05..5.0, extent in 1.0..500.0, sine in 0.1..1.0, planes in [0.0..600.0, 0.0..600.0], eta in -0.99..1.0,
    ) {
        for rule in [OptimumRule::Literal, OptimumRule::Derived, OptimumRule::Demo] {
            let whole = WarpSpan::directional_by(rule, extent, near, sine);
            let span = whole.levelled_between(planes[0], planes[1]);
            let warp_near = span.warp_near(eta);
            prop_assert!((span.eta(warp_near) - eta).abs() < 1.0e-5, "{} from {eta}", span.eta(warp_near));
            prop_assert!(span.warp_near(eta - 0.01) > warp_near);
            let (strongest, expected) = (span.warp_near(1.0), whole.warp_near(1.0));
            prop_assert!((strongest / expected - 1.0).abs() < 1.0e-6, "{strongest} against {expected}");
        }
    }
}
