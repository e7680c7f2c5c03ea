//! The re-parametrised `LiSPSM`: eta follows the angle between light and view (Stingl, section 3.2.2, after Lloyd).

use std::f64::consts::FRAC_PI_2;

/// eta_b: what is left of the warp where the light enters the view cone.
const ETA_AT_CONE: f64 = -0.2;

/// Share of the way from the cone to a right angle over which the warp comes back to n_opt.
const FADE_OUTSIDE_CONE: f64 = 0.3;

/// eta(γ) of the re-parametrised `LiSPSM` (Stingl, equation 3.3): −1 (uniform) for light along the view, −0.2 where the
/// light enters the view cone, 0 (n_opt) well outside of it.
///
/// With γ_a = Θ/3, γ_b = Θ, γ_c = Θ + 0.3 (90° − Θ): −1 up to γ_a, a straight line to −0.2 at γ_b, a quarter of a sine to 0
/// at γ_c. `light_angle` is γ, between light and view direction; all formulas are symmetric about 90°, so it is folded.
/// `half_opening` is Θ. Both in radians; NaN gives −1.
///
/// Limit: eta knows the angle only. For large depth ranges S̄ just inside the cone is still above the unwarped one.
pub fn reparametrised_eta(light_angle: f64, half_opening: f64) -> f64 {
    if light_angle.is_nan() || half_opening.is_nan() {
        return -1.0;
    }
    let angle = FRAC_PI_2 - (light_angle.abs() - FRAC_PI_2).abs();
    let cone = half_opening.clamp(0.0, FRAC_PI_2);
    let (start, end) = (cone / 3.0, cone + FADE_OUTSIDE_CONE * (FRAC_PI_2 - cone));
    if angle >= end {
        0.0
    } else if angle > cone {
        ETA_AT_CONE - ETA_AT_CONE * (FRAC_PI_2 * (angle - cone) / (end - cone)).sin()
    } else if angle > start {
        -1.0 + (ETA_AT_CONE + 1.0) * (angle - start) / (cone - start)
    } else {
        -1.0
    }
}

/// W_lz: the extent along the warp axis, in metres, of a whole symmetric view frustum (Stingl, equation 3.5).
///
/// Seen side-on the frustum is a trapezoid with the parallel sides 2 n tan Θ and 2 f tan Θ and the slanted side
/// W_s = (f − n) ÷ cos Θ at the angle Θ to the view. The warp axis stands at the angle 90° − γ to the view, so the near side
/// spans 2 n tan Θ cos γ of it and the slanted sides W_s sin(Θ + γ) and W_s sin(Θ − γ), the last only where the light is
/// inside the cone (else it lies within the others). The thesis prints 1 − cos(Θ − γ) for the last factor, which is right at
/// γ = Θ only: with the sine, γ = 0 gives the far plane's 2 f tan Θ.
///
/// `half_opening` is Θ, `light_angle` is γ in 0..=90°, both in radians.
pub fn frustum_extent(near: f64, far: f64, half_opening: f64, light_angle: f64) -> f64 {
    let slant = (far - near) / half_opening.cos();
    let near_side = 2.0 * near * half_opening.tan() * light_angle.cos();
    near_side + slant * (half_opening + light_angle).sin() + slant * (half_opening - light_angle).max(0.0).sin()
}
