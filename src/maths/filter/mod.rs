//! Filters of shadow lookups: CPU twins of `shaders/filter.wgsl`, in the same single precision and by the same names.
//!
//! Depths are never filtered, only the outcomes of comparisons (percentage closer filtering, Reeves et al. 1987). Every
//! tap compares with the depth of the receiver's plane at its own texel, so that kernels of any size need no more bias
//! than one texel does.
//!
//! | step | functions |
//! |---|---|
//! | compare | [`lookup::compare`], [`lookup::receiver_depth`] |
//! | casters that fade | [`fading::fading_depth`], [`fading::depth_without_share`], [`fading::fading_share`] |
//! | one lookup | [`lookup::hard`], [`lookup::four_taps`], [`lookup::bilinear`] |
//! | taps | [`disc::disc_tap`], [`disc::pixel_angle`] |
//! | kernel in the world | [`kernel::kernel_per_metre`], [`kernel::scaled`] |
//! | disc of taps | [`disc::disc`] |
//! | penumbra | [`penumbra::search_blockers`], [`penumbra::penumbra_radius`], [`penumbra::soft`] |
//!
//! [`eye_blur`] filters the result on the screen: the twin of `shaders/blur/eye_blur.wgsl`.

pub mod disc;
pub mod eye_blur;
pub mod fading;
pub mod kernel;
pub mod lookup;
pub mod penumbra;
