//! Bias: what a map stores and what a lookup adds.

use bevy_math::{DVec3, IVec2, Vec2, Vec3};
use umbrage::maths::{
    bias::receiver_plane,
    depth_offset::{
        DepthFormat, DepthOffset, StoredDepth, constant_offset, linear_depth, metres_of_offset, slope_scaled_offset,
        texel_span, vertex_depth_error, world_slope_offset,
    },
    filter::lookup::hard,
    warp::Warp,
};

use crate::{
    overhead::{EXTENT, HEIGHT, MILLIMETRE, SIZE, atlas, lookup, plane_at, slope_of, slope_scaled, tilted},
    support::{fit, huge_scene, light_at, papers_camera},
};

/// The share of lookups on a plane that find it lit, with itself as the only caster.
fn lit_share(normal: Vec3, offset: DepthOffset) -> f32 {
    let height = tilted(normal);
    let map = atlas(tilted(normal));
    let mut lit = 0.0;
    for i in 0..40 {
        for j in 0..40 {
            let (x, z) = (i as f32 * 0.237 - 4.7, j as f32 * 0.241 - 4.9);
            lit += hard(&map, &lookup(plane_at(Vec3::new(x, height(x, z), z), normal), offset));
        }
    }
    lit / 1600.0
}

/// Scherzer, oracle 14.
#[test]
fn slope_scaled_offsets() {
    let size = Vec2::splat(SIZE);
    for degrees in [0.0_f32, 20.0, 60.0] {
        let plane = plane_at(Vec3::ZERO, slope_of(degrees));
        let texel = 2.0 * EXTENT / SIZE;
        let slope = degrees.to_radians().tan() * texel / HEIGHT;
        let expected = 2.0 * slope + 4.0 * 0.001;
        let offset = slope_scaled_offset(&plane, size, 2.0, 4.0 * 0.001);
        assert!(
            (offset - expected).abs() < 1e-5,
            "{offset}, not {expected} at {degrees}°"
        );
    }
    let facing = plane_at(Vec3::ZERO, Vec3::Y);
    assert!(
        slope_scaled(2.0, 0.0).at(&facing, size, 1.0).depth < 1e-7,
        "zero for a plane that faces the light"
    );
    // The same depth for every texel, whatever the slope.
    let constant = DepthOffset::Constant { metres: 0.1 };
    for degrees in [0.0, 30.0, 80.0] {
        let plane = plane_at(Vec3::ZERO, slope_of(degrees));
        assert!(
            (constant.at(&plane, size, 0.5).depth - 0.1 / HEIGHT).abs() < 1e-7,
            "{degrees}°"
        );
        assert!(
            (metres_of_offset(&plane, constant_offset(&plane, 0.3)) - 0.3).abs() < 1e-5,
            "{degrees}°"
        );
    }
    // In the world: the same where texels are square and the plane rises along one axis.
    for degrees in [10.0_f32, 45.0, 75.0] {
        let plane = plane_at(Vec3::ZERO, slope_of(degrees));
        let world = world_slope_offset(&plane, size, degrees.to_radians().cos(), 1.5);
        let map = slope_scaled_offset(&plane, size, 1.5, 0.0);
        assert!((world / map - 1.0).abs() < 1e-3, "{world} and {map} at {degrees}°");
    }
    let averted = world_slope_offset(&plane_at(Vec3::ZERO, Vec3::Y), size, -0.4, 1.0);
    assert!(averted.is_finite(), "limited");
    // Both axes count for the span of a texel, the larger one for the slope.
    let diagonal = plane_at(Vec3::ZERO, Vec3::new(-0.3, 1.0, -0.3));
    let ratio = texel_span(&diagonal, size) / slope_scaled_offset(&diagonal, size, 1.0, 0.0);
    assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
}

/// The unit of a polygon offset, per format (Scherzer, section 2.4 c of the oracle sheet).
#[test]
fn smallest_steps() {
    assert_eq!(DepthFormat::Unorm16.step(0.5), 2.0_f32.powi(-16));
    assert_eq!(DepthFormat::Unorm24.step(0.5), 2.0_f32.powi(-24));
    assert_eq!(DepthFormat::Float32.step(0.7), 2.0_f32.powi(-24));
    assert_eq!(DepthFormat::Float32.step(1.0), 2.0_f32.powi(-23));
    assert_eq!(DepthFormat::Float32.step(0.3), 2.0_f32.powi(-25));
    assert!(DepthFormat::Float32.step(0.0) > 0.0, "a cleared map");
    let next = f32::from_bits(0.3_f32.to_bits() + 1);
    assert_eq!(next - 0.3, DepthFormat::Float32.step(0.3));
}

/// Scherzer, oracle 17: slope-scaled by one texel suffices, nothing does not, and one constant for a fan of slopes is
/// that of the steepest.
#[test]
fn planes_do_not_shade_themselves() {
    let fan = [0.0, 20.0, 40.0, 60.0, 70.0, 80.0].map(slope_of);
    for normal in [slope_of(30.0), slope_of(60.0), Vec3::new(0.5, 0.7, 0.4).normalize()] {
        assert!(lit_share(normal, DepthOffset::None) < 0.7, "moiré on {normal}");
        assert_eq!(
            lit_share(normal, slope_scaled(1.0, 16.0)),
            1.0,
            "slope-scaled on {normal}"
        );
        let world_slope = DepthOffset::WorldSlope { factor: 1.0 };
        assert_eq!(
            lit_share(normal, world_slope),
            1.0,
            "slope-scaled in the world on {normal}"
        );
        assert_eq!(lit_share(normal, MILLIMETRE), 1.0, "receiver plane on {normal}");
        let footprint = DepthOffset::Footprint {
            metres: 0.001,
            share: 0.5,
        };
        assert_eq!(lit_share(normal, footprint), 1.0, "footprint on {normal}");
    }
    let smallest_constant = |normals: &[Vec3]| {
        let (mut low, mut high) = (0.0_f32, 10.0_f32);
        for _ in 0..14 {
            let metres = 0.5 * (low + high);
            let constant = DepthOffset::Constant { metres };
            if normals.iter().all(|normal| lit_share(*normal, constant) == 1.0) {
                high = metres;
            } else {
                low = metres;
            }
        }
        high
    };
    let for_all = smallest_constant(&fan);
    let needed = fan.map(|normal| smallest_constant(&[normal]));
    let largest = needed.iter().copied().fold(0.0, f32::max);
    assert!((for_all - largest).abs() < 0.01, "{for_all} against {largest}");
    let mean = needed.iter().sum::<f32>() / 6.0;
    assert!(
        for_all > 2.0 * mean,
        "one constant displaces more: {for_all} against {mean}"
    );
    // Half a texel at 80°.
    let half_texel = EXTENT / SIZE * 80.0_f32.to_radians().tan();
    assert!(
        (largest / half_texel - 1.0).abs() < 0.1,
        "{largest} against {half_texel}"
    );
}

/// Scherzer, oracle 15: depth is affine along a ray, and a constant offset grows with w: 26.46 times over the paper's
/// range. A constant in metres does not.
#[test]
fn constant_depth_grows_over_a_warped_map() {
    let light_view = fit(&papers_camera(0.1, 70.0), &huge_scene(), light_at(90.0), Warp::Lispsm);
    let matrix = light_view.clip_from_world_f32();
    let plane = |depth: f32| receiver_plane(matrix, Vec3::NEG_Z * depth, Vec3::Y, Vec3::Y).expect("in the map");
    let (near, far) = (plane(0.1), plane(70.0));
    let growth = metres_of_offset(&far, 1e-4) / metres_of_offset(&near, 1e-4);
    assert!((growth - 26.458).abs() < 0.02, "{growth}");
    for plane in [near, far] {
        assert!((metres_of_offset(&plane, constant_offset(&plane, 0.05)) - 0.05).abs() < 1e-6);
    }
    let along = |metres: f64| {
        let point = DVec3::new(0.3, metres, -20.0);
        light_view.clip_from_world.project_point3(point).z
    };
    let (first, second) = (along(1.0) - along(0.0), along(9.0) - along(8.0));
    assert!(
        (first - second).abs() < 1e-12 && first > 0.0,
        "affine: {first}, {second}"
    );
}

/// Scherzer, oracle 16.
#[test]
fn linear_depth_per_vertex_is_wrong_inside_warped_triangles() {
    let (start, end) = (2.745_751, 72.645_751);
    assert!(vertex_depth_error(start, end, 0.0).abs() < 1e-12 && vertex_depth_error(start, end, 1.0).abs() < 1e-9);
    let middle = vertex_depth_error(start, end, 0.5);
    assert!((middle - 32.4).abs() < 0.01, "{middle}");
    assert!(
        (middle - (end - start).powi(2) / (2.0 * (end + start))).abs() < 1e-9,
        "{middle}"
    );
    // A small triangle far away: hardly any.
    assert!(vertex_depth_error(50.0, 51.0, 0.5) < 0.005);
    assert_eq!(
        [0.0, 5.0, 10.0].map(|height| linear_depth(height, 0.0, 10.0)),
        [0.0, 0.5, 1.0]
    );
}

/// Scherzer, oracle 18: a sphere over open ground.
#[test]
fn maps_of_back_faces() {
    let (center, radius) = (Vec3::new(1.0, 4.0, -2.0), 3.0);
    let half_height = |x: f32, z: f32| {
        (radius * radius - (x - center.x).powi(2) - (z - center.z).powi(2))
            .max(0.0)
            .sqrt()
    };
    let is_over = |x: f32, z: f32| half_height(x, z) > 0.0;
    let nothing = -0.5 * HEIGHT;
    // The ground is a single sheet: with front faces culled it is not in the map.
    let front = move |x: f32, z: f32| {
        if is_over(x, z) {
            center.y + half_height(x, z)
        } else {
            0.0
        }
    };
    let back = move |x: f32, z: f32| {
        if is_over(x, z) {
            center.y - half_height(x, z)
        } else {
            nothing
        }
    };
    let depth = |height: f32| height / HEIGHT + 0.5;
    let stored =
        |kind: StoredDepth| atlas(move |x, z| (kind.combine(depth(front(x, z)), depth(back(x, z))) - 0.5) * HEIGHT);
    let (nearest, culled) = (stored(StoredDepth::Nearest), stored(StoredDepth::BackFaces));
    for x in 0..64 {
        for y in 0..64 {
            let texel = IVec2::new(128 + x, 64 + y);
            assert!(culled(texel) <= nearest(texel), "back faces lie farther from the light");
            let midpoint = stored(StoredDepth::Midpoint)(texel);
            assert!(culled(texel) <= midpoint && midpoint <= nearest(texel));
            let dual = stored(StoredDepth::Dual { largest: 0.01 })(texel);
            assert!(
                midpoint <= dual && nearest(texel) - dual <= 0.01 + 1e-6,
                "a limited midpoint"
            );
        }
    }
    let normal = Vec3::new(0.2, 1.0, 0.1).normalize();
    let ground = tilted(normal);
    let mut differences = 0;
    for i in 0..60 {
        for j in 0..60 {
            let (x, z) = (i as f32 * 0.5 - 15.0, j as f32 * 0.5 - 15.0);
            let point = Vec3::new(x, ground(x, z), z);
            let open = hard(&culled, &lookup(plane_at(point, normal), DepthOffset::None));
            let reference_map = atlas(|x, z| if is_over(x, z) { center.y } else { nothing });
            let reference = hard(&reference_map, &lookup(plane_at(point, normal), DepthOffset::None));
            differences += u32::from(open != reference);
        }
    }
    assert_eq!(differences, 0, "no moiré without any bias, and the same shadow");
    // Nothing behind: the pass of the second surface leaves the cleared map.
    assert_eq!(StoredDepth::SecondDepth.combine(0.8, 0.0), 0.0);
    assert_eq!(StoredDepth::Midpoint.combine(0.8, 0.0), 0.0);
    assert!((StoredDepth::Midpoint.combine(0.8, 0.2) - 0.5).abs() < 1e-6);
    assert!((StoredDepth::Dual { largest: 0.1 }.combine(0.8, 0.0) - 0.7).abs() < 1e-6);
}

/// Scherzer, section 4.2, row 8: behind the warp a comparison decides as with linear depth, bias included. An offset of
/// linear depth is one of metres.
#[test]
fn linear_depth_decides_as_the_maps_depth_does() {
    let light_view = fit(&papers_camera(0.1, 70.0), &huge_scene(), light_at(70.0), Warp::Lispsm);
    let (towards_light, light_z) = (-light_at(70.0).normalize(), light_view.axes.z);
    let (lowest, highest) = (-200.0, 200.0);
    let linear = |point: DVec3| linear_depth(light_z.dot(point), lowest, highest);
    let mapped = |point: DVec3| light_view.clip_from_world.project_point3(point).z;
    for depth in [0.1, 0.9, 8.0, 69.0] {
        let receiver = DVec3::new(0.2, -0.1, -1.0) * depth;
        for (bias, distance) in [
            (0.0, 0.001),
            (0.0, -0.001),
            (0.05, 0.049),
            (0.05, 0.051),
            (0.05, 9.0),
            (2.0, 1.9),
        ] {
            let caster = receiver + towards_light * distance;
            let in_linear = linear(caster) > linear(receiver) + bias / (highest - lowest);
            let in_map = mapped(caster) > mapped(receiver) + bias * light_view.depth_per_metre_at(receiver);
            assert_eq!(in_linear, in_map, "{distance} m above {receiver}, bias {bias}");
            assert_eq!(in_map, distance > bias);
        }
    }
}
