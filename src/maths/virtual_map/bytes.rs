//! The thesis's encoding of the mapping map in four bytes (Giegl, sections 5.6 and 5.17), for comparison.
//!
//! Two errors are part of it and measured by tests: a place of a byte falls into a neighbouring tile in 2.9 % of all
//! cases (n = 32), and the encoder is one level low, which [`byte_level`] makes up for with a rounding of its own. The
//! default, [`need_level`](super::mapping::need_level), has neither.

/// R = −exponent(frexp(√2 Δ)): the rounded log2 of the need 1 ÷ Δ, *minus one* (section 5.17). With L = −log2 Δ it
/// equals ⌈L − ½⌉ − 1, so that a need of 2¹⁶ gives 15. Extents are clamped to 2⁻³⁰ first: edge-on patches have none,
/// and the listing would give them no need at all. NaN has the largest need.
pub fn byte_need(extent: f64) -> u8 {
    let level = -extent.max(SMALLEST_EXTENT).log2();
    ((level - 0.5).ceil() - 1.0).clamp(0.0, f64::from(u8::MAX)) as u8
}

/// What an 8-bit normalised channel holds after R ÷ 256 was written to it: R itself up to 127, one less from 129 on.
pub fn stored_byte(need: u8) -> u8 {
    (f64::from(need) / 256.0 * 255.0).round() as u8
}

/// log2 of the need of one picture pixel for a stored need of one pixel of the mapping map, as the refinement test of
/// section 5.9 has it: R + round(log2(picture ÷ map) + ½), with halves rounded up.
///
/// The ½ pays back the level that [`byte_need`] lost, where the ratio is a power of two and rounding goes up. Where
/// halves go to even, as in WGSL, everything is one level too coarse: never port this arithmetic.
pub fn byte_level(need: u8, picture_to_map: f64) -> f64 {
    f64::from(need) + (picture_to_map.log2() + 0.5 + 0.5).floor()
}

/// The byte of a place 0..=1 in the map.
pub fn byte_place(uv: f64) -> u8 {
    (uv * 255.0).round() as u8
}

/// The place that lands in the tile `byte >> log2(256 ÷ n)` for every n up to 256: the middle of the byte's 256th.
pub fn place_of_byte(byte: u8) -> f64 {
    (f64::from(byte) + 0.5) / 256.0
}

/// 2⁻³⁰.
const SMALLEST_EXTENT: f64 = 1.0 / (1_u64 << 30) as f64;
