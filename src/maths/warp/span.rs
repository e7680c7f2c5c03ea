//! [`WarpSpan`]: what a warp levels, and the free parameter n' that does it.

use serde::{Deserialize, Serialize};

/// Which reading of the formula for n_opt of a directional light is used. They differ only off 90° between light and
/// view, where sin γ < 1.
///
/// Scherzer 2005, equation 1, reads n_opt = (z_n + √(z_n (z_n + Δz))) ÷ sin γ and calls Δz the depth extent of B "in light
/// space".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum OptimumRule {
    /// Δz = d sin γ, the range of view depths: equal errors at both ends, as equation 3.2 of Stingl demands. See
    /// [`WarpSpan::directional`] for the derivation.
    #[default]
    Derived,
    /// Δz = d, the extent along the warp axis: a weaker warp for tilted light.
    Literal,
    /// Δz = d sin γ with z_n ÷ sin γ in place of z_n: the weakest. So the widely copied demonstration program of the
    /// method has it.
    Demo,
}

/// What a warp has to level: the extent of the body along the warp axis and the view depths at its two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpSpan {
    /// d: extent of the warp frustum along light-space y, in metres.
    pub extent: f64,
    /// z0: view depth at its near end, in metres.
    pub near_depth: f64,
    /// z1: view depth at its far end, in metres.
    pub far_depth: f64,
    /// The part over which errors are made equal.
    levelled: Levelled,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Levelled {
    /// Extent along light-space y.
    extent: f64,
    /// z_p and z_q: view depths of its ends.
    near_depth: f64,
    far_depth: f64,
    /// Extent of what lies in front of it.
    lead: f64,
}

impl WarpSpan {
    /// A span with given view depths at its ends.
    pub fn new(extent: f64, near_depth: f64, far_depth: f64) -> Self {
        Self {
            extent,
            near_depth,
            far_depth,
            levelled: Levelled {
                extent,
                near_depth,
                far_depth,
                lead: 0.0,
            },
        }
    }

    /// The span of a directional light: z0 is the view depth of the nearest point of LVS, and walking along the warp
    /// axis at that depth changes the view depth by `sine` = v · y per metre, the sine of the angle between light and
    /// view direction (Stingl, section 3.2.1, after Wimmer and Scherzer 2006).
    ///
    /// Then n_opt = d ÷ (√(z1/z0) − 1) with z1 − z0 = d sin γ is
    ///
    /// ```text
    /// n_opt = d (√(z0 z1) + z0) ÷ (z1 − z0) = (z0 + √(z0 (z0 + d sin γ))) ÷ sin γ
    /// ```
    ///
    /// which is equation 1 of Scherzer 2005 with Δz = d sin γ.
    pub fn directional(extent: f64, near_depth: f64, sine: f64) -> Self {
        Self::new(extent, near_depth, near_depth + extent * sine)
    }

    /// This span with `lead` more metres of receivers in front of it, over which nothing is levelled: those of a side face
    /// that is stretched over the near face. The projection centre stays where it is.
    #[must_use]
    pub fn led_by(self, lead: f64) -> Self {
        Self {
            extent: self.extent + lead,
            levelled: Levelled {
                lead: self.levelled.lead + lead,
                ..self.levelled
            },
            ..self
        }
    }

    /// [`WarpSpan::directional`] as a rule reads it.
    ///
    /// Every rule has the form n_opt = (z0 + √(z0 z1)) ÷ sin γ, and with s = 1 ÷ sin γ that is the n_opt of a span with
    /// the extent s (z1 − z0): d under [`OptimumRule::Derived`] and [`OptimumRule::Demo`], d ÷ sin γ under
    /// [`OptimumRule::Literal`].
    pub fn directional_by(rule: OptimumRule, extent: f64, near_depth: f64, sine: f64) -> Self {
        match rule {
            OptimumRule::Derived => Self::directional(extent, near_depth, sine),
            OptimumRule::Literal => {
                let mut span = Self::new(extent, near_depth, near_depth + extent);
                span.levelled.extent = extent / sine;
                span
            }
            OptimumRule::Demo => Self::directional(extent, near_depth / sine, sine),
        }
    }

    /// The same span with errors equal at two view depths inside it instead of at its ends: the pseudo-near and the
    /// pseudo-far plane (Stingl, section 4.2). What lies outside them stays covered, with larger errors.
    ///
    /// Along the warp axis the error is (n' + s (z − z0))² ÷ z up to a constant, where s = d ÷ (z1 − z0) metres of y per
    /// metre of view depth. With n'' = n' + s (z_p − z0), the distance from the projection centre to the pseudo-near
    /// plane, it is (n'' + s (z − z_p))² ÷ z: the problem of [`WarpSpan::warp_near`] over the shorter span from z_p to z_q.
    /// Its solution s (z_p + √(z_p z_q)) for n'' gives
    ///
    /// ```text
    /// n_opt = s (z0 + √(z_p z_q)) = d ÷ (z1 − z0) · (z0 + √(z_p z_q))
    /// ```
    ///
    /// Equation 4.2 of Stingl prints the square root outside of the factor; only the form above equals equation 3.2
    /// without pseudo planes. eta goes the same way: −1 is uniform, and 1 gives n' = s z0, the `PSM` of the whole span.
    ///
    /// Planes outside of z0..=z1 are drawn to its ends; a far plane in front of the near plane counts as beside it.
    /// Where both meet, n' is the limit s (z0 + z_p): the error has its minimum or its turning point there.
    #[must_use]
    pub fn levelled_between(self, near_depth: f64, far_depth: f64) -> Self {
        let stretch = self.levelled.extent / (self.levelled.far_depth - self.levelled.near_depth);
        if !(self.near_depth > 0.0 && stretch > 0.0 && stretch.is_finite()) || near_depth.is_nan() || far_depth.is_nan()
        {
            return self;
        }
        let near_depth = near_depth.clamp(self.near_depth, self.far_depth);
        let far_depth = far_depth.clamp(near_depth, self.far_depth);
        if (near_depth, far_depth) == (self.near_depth, self.far_depth) {
            return self;
        }
        let far_depth = far_depth.max(near_depth * (1.0 + SMALLEST_LEVELLED_RANGE));
        Self {
            levelled: Levelled {
                extent: stretch * (far_depth - near_depth),
                near_depth,
                far_depth,
                lead: stretch * (near_depth - self.near_depth),
            },
            ..self
        }
    }

    /// α = z_q ÷ z_p, z1 ÷ z0 without pseudo planes; 1 when there is nothing to level.
    fn depth_ratio(&self) -> f64 {
        let Levelled {
            near_depth, far_depth, ..
        } = self.levelled;
        let ratio = far_depth / near_depth;
        if ratio.is_finite() && near_depth > 0.0 {
            ratio.max(1.0)
        } else {
            1.0
        }
    }

    /// n_opt = d ÷ (√(z1/z0) − 1) (Stingl, equation 3.2): the error along the warp axis is equal at both ends.
    /// Infinite when there is nothing to level.
    pub fn optimal_warp_near(&self) -> f64 {
        self.warp_near(0.0)
    }

    /// n' in metres for a strength eta in −1..=1 (Lloyd, equation 11; Stingl, equation 3.4): infinite at −1, n_opt at 0,
    /// `PSM` at 1. Between −1 and 0 and between 0 and 1 the largest error along the warp axis is linear in eta.
    ///
    /// Both papers' prints lose a bracket: the radicals are √α + 1 and the last denominator is η √α + 1, or else the
    /// branches would not meet at 0 and 1 would not be `PSM`.
    pub fn warp_near(&self, eta: f64) -> f64 {
        let ratio = self.depth_ratio();
        let root = ratio.sqrt();
        let relative = if eta <= 0.0 {
            (1.0 + root - eta * (ratio - 1.0)) / (1.0 + eta)
        } else {
            (1.0 + root) / (eta * root + 1.0)
        };
        let near = self.levelled.extent / (ratio - 1.0) * relative - self.levelled.lead;
        if near.is_finite() && near > 0.0 && near < self.extent * LARGEST_RELATIVE_WARP_NEAR {
            near
        } else {
            f64::INFINITY
        }
    }

    /// The strength eta of a `warp_near` between that of `PSM` and infinity: the inverse of [`WarpSpan::warp_near`].
    pub fn eta(&self, warp_near: f64) -> f64 {
        let ratio = self.depth_ratio();
        if ratio == 1.0 || warp_near.is_infinite() {
            return -1.0;
        }
        let root = ratio.sqrt();
        let near = (warp_near + self.levelled.lead) * (ratio - 1.0) / self.levelled.extent;
        if near >= 1.0 + root {
            (1.0 + root - near) / (near + ratio - 1.0)
        } else {
            ((1.0 + root) / near - 1.0) / root
        }
    }
}

/// n' in metres of a trapezoidal map over `extent` metres: the share `focus` of the extent, from the near end, gets four
/// fifths of the map.
///
/// The map's coordinate along the warp axis is t = f' (z' − n') ÷ (z' (f' − n')) at z' = n' + δ, with f' = n' + d (Lloyd,
/// equation 6). t = 0.8 at δ = `focus` · d gives (Lloyd, section 4.1; the 80 % rule of Martin and Tan 2004, ξ = −0.6)
///
/// ```text
/// n' = 0.2 d δ ÷ (0.8 d − δ)
/// ```
///
/// Infinite (uniform) from `focus` = 0.8 on, where no warp is needed, and for NaN; 0 where nothing is in focus. It can
/// leave the range in which S̄ is least, from `PSM` to n_opt, on both sides: that is Lloyd's argument against it.
pub fn trapezoidal_warp_near(extent: f64, focus: f64) -> f64 {
    if focus >= FOCUSED_MAP || focus.is_nan() {
        return f64::INFINITY;
    }
    let focus = focus.max(0.0);
    (1.0 - FOCUSED_MAP) * extent * focus / (FOCUSED_MAP - focus)
}

/// The share of the map that a trapezoidal map gives to its focus.
const FOCUSED_MAP: f64 = 0.8;

/// Beyond this multiple of the extent a warp bends nothing that single precision could tell: it is uniform.
const LARGEST_RELATIVE_WARP_NEAR: f64 = 1.0e6;

/// Pseudo planes closer together than this share of their depth are moved apart to it, so that the formulas stay
/// regular: n' then differs from its limit by less than a millionth.
const SMALLEST_LEVELLED_RANGE: f64 = 1.0e-6;
