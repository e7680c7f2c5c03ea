//! Ray-traced truth: rays that must not leak, and truth of whole pictures against analytic truth.

use std::sync::Arc;

use bevy::{
    math::{Affine3A, DVec2, DVec3, Vec2},
    prelude::*,
};
use umbrage::render::reference::{
    mesh::{AlphaMask, TruthMesh},
    scene::{TruthInstance, TruthScene},
};

fn mesh(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Arc<TruthMesh> {
    let positions = positions.iter().copied().map(Vec3::from).collect();
    Arc::new(TruthMesh::new(positions, Vec::new(), indices.to_vec()).expect("triangles"))
}

/// A box from −1 to 1 with its faces outwards.
fn cube() -> Arc<TruthMesh> {
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i: usize| [0, 1, 2].map(|bit| if i >> bit & 1 == 0 { -1.0 } else { 1.0 }))
        .collect();
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles: Vec<[u32; 3]> = quads
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    mesh(&corners, &triangles)
}

fn instance(mesh: &Arc<TruthMesh>, world_from_local: Affine3A) -> TruthInstance {
    TruthInstance {
        mesh: Arc::clone(mesh),
        world_from_local,
        alpha: None,
        double_sided: false,
        casts: true,
    }
}

/// A direction per index, evenly spread over the sphere (a Fibonacci lattice).
fn direction(index: usize, count: usize) -> DVec3 {
    let z = 1.0 - 2.0 * (index as f64 + 0.5) / count as f64;
    let angle = index as f64 * 2.399_963_229_728_653;
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
}

#[test]
fn sealed_boxes_leak_nothing() {
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::new(3.0, 0.2, 1.7),
        Quat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7),
        Vec3::new(250.3, 12.7, -381.9),
    );
    for transform in [Affine3A::IDENTITY, turned] {
        let scene = TruthScene::new([instance(&cube(), transform)]);
        let center = Vec3::from(transform.translation).as_dvec3();
        let count = 20_000;
        for index in 0..count {
            assert!(
                scene.is_in_shadow(center, direction(index, count), 0.0005),
                "ray {index} leaks"
            );
        }
        // Exactly through edges and corners too.
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for other in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE] {
                let local = (axis + other).as_vec3();
                let world = transform.transform_vector3(local).as_dvec3();
                assert!(scene.is_in_shadow(center, world, 0.0005), "{local} leaks");
            }
        }
    }
}

/// A light in a plane of the scene's axes has a direction with a zero, and that towards it one with a minus: both must
/// find the box.
#[test]
fn zeros_of_either_sign_are_directions() {
    let place = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.25));
    let scene = TruthScene::new((0..20).map(|i| instance(&cube(), place(5.0 * i as f32))));
    for zero in [0.0, -0.0] {
        for (point, to_light) in [
            (DVec3::new(2.0, -3.0, 0.0), DVec3::new(-0.6, 0.8, zero)),
            (DVec3::new(40.0, -3.0, -3.0), DVec3::new(zero, 0.6, 0.8)),
            (DVec3::new(60.5, -3.0, 0.0), DVec3::new(zero, 1.0, zero)),
            (DVec3::new(-9.0, 0.5, 0.5), DVec3::new(1.0, zero, zero)),
        ] {
            assert!(scene.is_in_shadow(point, to_light, 0.001), "{to_light} misses the box");
            let away = DVec3::new(to_light.x, -to_light.y, zero);
            let is_clear = to_light.y == 0.0 || !scene.is_in_shadow(point, away, 0.001);
            assert!(is_clear, "{away} hits something");
        }
    }
}

/// Points on a plane and the sun almost in it: nothing shadows itself, from either side of the single-sided plane.
#[test]
fn grazing_planes_do_not_shadow_themselves() {
    let plane = mesh(
        &[
            [-500.0, 0.0, -500.0],
            [500.0, 0.0, -500.0],
            [500.0, 0.0, 500.0],
            [-500.0, 0.0, 500.0],
        ],
        &[[0, 2, 1], [0, 3, 2]],
    );
    for double_sided in [false, true] {
        let slope = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.4), Vec3::new(3.0, 77.0, -5.0));
        let scene = TruthScene::new([TruthInstance {
            double_sided,
            ..instance(&plane, slope)
        }]);
        let normal = slope.transform_vector3(Vec3::Y).as_dvec3();
        for index in 0..2000 {
            let place = direction(index, 2000) * 400.0;
            let point = slope
                .transform_point3(Vec3::new(place.x as f32, 0.0, place.y as f32))
                .as_dvec3();
            let along = slope.transform_vector3(Vec3::new(1.0, 0.0, 0.3)).as_dvec3().normalize();
            let to_light = along + normal * 0.15;
            assert!(!scene.is_in_shadow(point, to_light, 0.0005), "{point} shadows itself");
            let below = point - normal * 0.01;
            assert!(
                scene.is_in_shadow(below, to_light, 0.0005),
                "{below} is lit through the plane"
            );
        }
    }
}

#[test]
fn holes_and_sides_are_those_of_the_renderer() {
    let quad = TruthMesh::new(
        [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]]
            .map(Vec3::from)
            .to_vec(),
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(Vec2::from)
            .to_vec(),
        vec![[0, 2, 1], [0, 3, 2]],
    );
    let quad = Arc::new(quad.expect("two triangles"));
    let mask = Arc::new(AlphaMask {
        width: 2,
        height: 1,
        alpha: vec![255, 0],
        base: 1.0,
        cutoff: 0.5,
    });
    let holes = TruthScene::new([TruthInstance {
        alpha: Some(mask),
        double_sided: true,
        ..instance(&quad, Affine3A::IDENTITY)
    }]);
    let below = |x: f64| DVec3::new(x, -3.0, 0.1);
    assert!(holes.is_in_shadow(below(-0.5), DVec3::Y, 0.001), "the solid half");
    assert!(!holes.is_in_shadow(below(0.5), DVec3::Y, 0.001), "the hole");

    let single = TruthScene::new([instance(&quad, Affine3A::IDENTITY)]);
    assert!(
        single.is_in_shadow(below(0.0), DVec3::Y, 0.001),
        "its front faces the light"
    );
    let above = DVec3::new(0.0, 3.0, 0.1);
    assert!(
        !single.is_in_shadow(above, DVec3::NEG_Y, 0.001),
        "its back is not drawn"
    );
    let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let mirrored = TruthScene::new([instance(&quad, mirrored)]);
    assert!(
        !mirrored.is_in_shadow(below(0.0), DVec3::Y, 0.001),
        "winding turns with the mirror"
    );
}

#[test]
fn alpha_repeats_and_blends() {
    let mask = AlphaMask {
        width: 2,
        height: 1,
        alpha: vec![255, 0],
        base: 1.0,
        cutoff: 0.5,
    };
    for (u, solid) in [
        (0.25, true),
        (0.75, false),
        (1.25, true),
        (-0.25, false),
        (0.45, true),
        (0.55, false),
    ] {
        assert_eq!(mask.is_solid(DVec2::new(u, 0.5)), solid, "at {u}");
    }
    let empty = AlphaMask {
        alpha: Vec::new(),
        ..mask
    };
    assert!(empty.is_solid(DVec2::NAN));
}

#[test]
fn instances_share_their_mesh() {
    let cube = cube();
    let many = |count: usize| {
        let place =
            |i: usize| Affine3A::from_translation(Vec3::new((i % 400) as f32 * 4.0, 0.0, (i / 400) as f32 * 4.0));
        TruthScene::new((0..count).map(|i| instance(&cube, place(i))))
    };
    let (few, forest) = (many(1000), many(100_000));
    assert_eq!((few.len(), forest.len()), (1000, 100_000));
    assert!(forest.bytes() < 64 << 20, "{} bytes", forest.bytes());
    assert!(forest.is_in_shadow(DVec3::new(400.0, -5.0, 400.0), DVec3::Y, 0.001));
    assert!(!forest.is_in_shadow(DVec3::new(402.0, -5.0, 402.0), DVec3::Y, 0.001));
    let statistics = forest.statistics();
    assert_eq!(
        (
            statistics.instances,
            statistics.casters,
            statistics.meshes,
            statistics.triangles
        ),
        (100_000, 100_000, 1, 1_200_000)
    );
    // 400 × 250 cubes of 2 m, 4 m apart.
    let area = (399.0 * 4.0 + 2.0) * (249.0 * 4.0 + 2.0);
    assert!((statistics.area_m2 / area - 1.0).abs() < 1.0e-4, "{statistics:?}");
}

#[test]
fn nothing_and_nonsense_are_lit() {
    let nothing = TruthScene::new([]);
    assert!(nothing.is_empty() && !nothing.is_in_shadow(DVec3::ZERO, DVec3::Y, 0.001));
    assert!(TruthMesh::new(vec![Vec3::ZERO; 3], Vec::new(), vec![[0, 1, 2], [0, 1, 9]]).is_none());
    assert!(TruthMesh::new(vec![Vec3::NAN; 3], Vec::new(), vec![[0, 1, 2]]).is_none());
    let cube = cube();
    let flat = TruthScene::new([
        instance(&cube, Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0))),
        instance(&cube, Affine3A::from_translation(Vec3::NAN)),
    ]);
    assert!(flat.is_empty());
    let scene = TruthScene::new([instance(&cube, Affine3A::IDENTITY)]);
    for (point, light) in [
        (DVec3::NAN, DVec3::Y),
        (DVec3::ZERO, DVec3::ZERO),
        (DVec3::ZERO, DVec3::NAN),
        (DVec3::splat(1.0e300), DVec3::Y),
    ] {
        assert!(!scene.is_in_shadow(point, light, 0.001), "{point} {light}");
    }
}
