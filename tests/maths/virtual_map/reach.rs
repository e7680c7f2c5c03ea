//! How far filters reach over a map.

use bevy_math::{DMat4, DVec2, DVec3, DVec4};
use umbrage::maths::virtual_map::{reach::texels_per_metre, tile::map_uv};

use super::scene::Numbers;

/// 40 m × 10 m seen along −z.
fn parallel() -> DMat4 {
    DMat4::from_scale(DVec3::new(1.0 / 20.0, 1.0 / 5.0, 1.0 / 100.0))
}

/// The same with a perspective along y: w from 0.5 to 1.5.
fn warped() -> DMat4 {
    let warp = DMat4::from_cols(
        DVec4::X,
        DVec4::new(0.0, 1.0, 0.0, 0.5),
        DVec4::Z,
        DVec4::new(0.0, 0.0, 0.0, 1.0),
    );
    warp * parallel()
}

#[test]
fn parallel_maps_are_exact() {
    let found = texels_per_metre(&parallel(), DVec2::new(4000.0, 500.0));
    assert!(
        (found - 100.0).abs() < 1e-9,
        "4000 texels over 40 m, 500 over 10 m: {found}"
    );
    let found = texels_per_metre(&parallel(), DVec2::splat(2000.0));
    assert!((found - 200.0).abs() < 1e-9, "2000 texels over 10 m: {found}");
}

#[test]
fn no_step_in_a_warped_map_is_longer() {
    let (map, texels) = (warped(), DVec2::splat(1024.0));
    let bound = texels_per_metre(&map, texels);
    let world_from_clip = map.inverse();
    let mut numbers = Numbers(5);
    let mut number = || f64::from(numbers.whole(0, 2000) as u32) / 1000.0 - 1.0;
    let mut longest = 0.0_f64;
    for _ in 0..2000 {
        let ndc = DVec3::new(number(), number(), 0.5 + 0.5 * number());
        let point = world_from_clip.project_point3(ndc);
        let step = DVec3::new(number(), number(), number()).normalize_or(DVec3::X) * 1e-6;
        let places = [point, point + step].map(|point| map_uv(&map, point).expect("in front"));
        longest = longest.max((places[1] - places[0]).length() * texels.x / 1e-6);
    }
    assert!(longest <= bound * 1.0001, "{longest} texels per metre, bound {bound}");
    // The two maxima of the bound lie at one corner here, up to the factor that the perspective row adds.
    assert!(longest > bound * 0.5, "{bound} is far above {longest}");
}

#[test]
fn a_centre_inside_the_box_has_no_bound() {
    let mut map = warped();
    map.y_axis.w = 0.4;
    assert_eq!(texels_per_metre(&map, DVec2::ONE), f64::INFINITY);
    assert_eq!(texels_per_metre(&DMat4::ZERO, DVec2::ONE), f64::INFINITY);
}
