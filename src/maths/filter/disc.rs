//! A disc of taps around the receiver.
//!
//! The taps lie on Vogel's spiral (H. Vogel, *A better way to construct the sunflower head*, Mathematical Biosciences
//! 44, 1979): tap i of n at radius √((i + ½) ÷ n) and i golden angles. Every tap stands for the same area, and no two
//! come nearer than 1.5 ÷ √n radii: the property for which Poisson discs are used (Stingl 2011, section 3.6), without a
//! table, for any number of taps. Each pixel turns the disc by its own angle, from the interleaved gradient noise of J.
//! Jimenez (*Next generation post processing in Call of Duty: Advanced Warfare*, SIGGRAPH 2014 course): bands become
//! fine noise, which the blur of [`eye_blur`](super::eye_blur) removes.

use bevy_math::{Vec2, Vec4Swizzles};

use super::{
    kernel::Kernel,
    lookup::{Lookup, MapTexels, bilinear, compare, receiver_texel},
};

/// Numbers of taps on offer: 8 for blocker searches, 64 as in Stingl, figure 3.21. Any other works too.
pub const TAP_COUNTS: [u32; 4] = [8, 16, 32, 64];

/// π (3 − √5): the turn from tap to tap.
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// A tap of the unit disc.
pub fn disc_tap(index: u32, count: u32, angle: f32) -> Vec2 {
    let radius = ((index as f32 + 0.5) / count as f32).sqrt();
    let (sine, cosine) = (index as f32 * GOLDEN_ANGLE + angle).sin_cos();
    Vec2::new(cosine, sine) * radius
}

/// The angle by which a pixel turns its disc, radians. `pixel`: its coordinates in the picture.
pub fn pixel_angle(pixel: Vec2) -> f32 {
    let inner = pixel.dot(Vec2::new(0.067_110_56, 0.005_837_15));
    std::f32::consts::TAU * (52.982_92 * inner.fract()).fract()
}

/// The share of taps that are lit. `smooth`: every tap is a [`bilinear`] lookup instead of a single comparison.
pub fn disc(maps: &impl MapTexels, lookup: &Lookup, kernel: &Kernel, count: u32, angle: f32, smooth: bool) -> f32 {
    let mut lit = 0.0;
    for index in 0..count {
        let texel = tap_texel(lookup, kernel, disc_tap(index, count, angle));
        if smooth {
            lit += bilinear(maps, lookup, texel);
        } else {
            lit += compare(maps, lookup, texel.floor());
        }
    }
    lit / count as f32
}

/// Texel coordinates of a tap.
pub(super) fn tap_texel(lookup: &Lookup, kernel: &Kernel, tap: Vec2) -> Vec2 {
    receiver_texel(lookup) + (kernel.across * tap.x + kernel.along * tap.y) * lookup.rect.zw()
}
