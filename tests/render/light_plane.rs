//! Perspective-optimal light planes: blocks against their twin, footprints against the theory, shadows against truth.

use bevy::{math::DVec3, prelude::*};
use umbrage::{
    maths::light_plane::space::{FilmError, SeenPicture, block_pixels, reduce_block},
    prelude::*,
    render::{
        capture,
        light_maps::LightMaps,
        mask::ShadowMask,
        reference::{
            extract::truth_scene,
            pixels::{self, PixelRays, Traced},
            sampling::samples,
        },
    },
    shadow::light_plane::{LightPlaneStates, NoFilms, SeenSurfaces, SurfaceSampling},
};

use crate::{
    harness::{Harness, WARM_UP, eye},
    room::Room,
    truth::{LIGHTS, boxes, errors, harness_with, settings},
};

/// Not a multiple of the blocks in either direction.
const ODD: UVec2 = UVec2::new(161, 91);

fn picture_of(harness: &Harness) -> &SeenPicture {
    let seen = harness.app.world().get::<SeenSurfaces>(harness.camera);
    &seen.expect("the camera was sampled").picture
}

fn view_depths(harness: &Harness) -> Vec<f32> {
    let mask = harness.app.world().get::<ShadowMask>(harness.camera).expect("a mask");
    let depth = mask.depth.clone();
    capture::read_image(&harness.app, &depth)
        .expect("depths can be read")
        .to_f32()
}

/// A plane and three boxes before a sky.
fn scene(size: UVec2) -> Harness {
    let mut harness = Harness::new(size, eye());
    let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
    let plane = harness.mesh(Plane3d::default().mesh().size(60.0, 60.0));
    let cuboid = harness.mesh(Cuboid::new(2.0, 2.0, 2.0));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    for (x, z) in [(-2.0, 0.0), (4.0, -8.0), (-6.0, -25.0)] {
        world.spawn((
            Mesh3d(cuboid.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(x, 1.0, z),
        ));
    }
    harness
}

/// Every block of the GPU is what the CPU makes of the same depths.
#[test]
fn blocks_equal_their_twin() {
    let mut harness = scene(ODD);
    let light = harness.sun(LIGHTS[0], settings("optimal:size=256"));
    harness.add_mask(light, ODD);
    harness.start();
    // In NDC; the projection has no far plane.
    let depths: Vec<f32> = view_depths(&harness)
        .iter()
        .map(|depth| if *depth > 0.0 { 0.2 / depth } else { 0.0 })
        .collect();
    let picture = picture_of(&harness);
    assert_eq!(
        (picture.size, picture.grid),
        (ODD, SurfaceSampling::default().block_count())
    );
    let world_from_clip = picture.clip_from_world.inverse();
    let (mut surfaces, mut normals) = (0, 0);
    for (index, seen) in (0..).zip(&picture.blocks) {
        let block = UVec2::new(index % picture.grid.x, index / picture.grid.x);
        let Some(twin) = reduce_block(&depths, ODD, picture.grid, block) else {
            assert_eq!(*seen, None, "block {block} has only sky");
            continue;
        };
        let seen = seen.unwrap_or_else(|| panic!("block {block} sees a surface"));
        assert_eq!((seen.pixels, seen.pixel), (twin.pixels, twin.pixel), "block {block}");
        for (found, wanted) in seen.depths_ndc.into_iter().zip(twin.depths_ndc) {
            assert!(
                (found / wanted - 1.0).abs() < 1.0e-4,
                "block {block}: {found}, not {wanted}"
            );
        }
        let rounding = 4.0e-6 * twin.depths_ndc[0];
        let is_same_plane = (seen.plane.depth_ndc - twin.plane.depth_ndc).abs() < rounding
            && (seen.plane.slope - twin.plane.slope).abs().max_element() < rounding
            && (0..2).all(|end| (seen.plane.offsets[end] - twin.plane.offsets[end]).abs() < 8.0 * rounding);
        assert!(is_same_plane, "block {block}: {:?}, not {:?}", seen.plane, twin.plane);
        let ndc = (twin.pixel.as_dvec2() + 0.5) / ODD.as_dvec2() * 2.0 - 1.0;
        let depth = f64::from(depths[(twin.pixel.y * ODD.x + twin.pixel.x) as usize]);
        let position = world_from_clip.project_point3(DVec3::new(ndc.x, -ndc.y, depth));
        let distance = (position - eye().translation.as_dvec3()).length();
        assert!(
            (seen.position - position).length() < 2.0e-4 * distance,
            "block {block}: {}",
            seen.position
        );
        surfaces += 1;
        // All surfaces are along the axes.
        normals += usize::from(seen.normal.abs().max_element() > 0.999);
    }
    assert!(surfaces > 700, "{surfaces} blocks with surfaces");
    assert!(
        normals as f64 > 0.97 * f64::from(surfaces),
        "{normals} of {surfaces} normals are right"
    );
    let pixels: u32 = picture.blocks.iter().flatten().map(|block| block.pixels).sum();
    assert_eq!(pixels as usize, depths.iter().filter(|depth| **depth > 0.0).count());
    assert_eq!(block_pixels(ODD, picture.grid, picture.grid - 1).zw(), ODD);
}

/// Pixels per texel: the largest over the smallest, and the mean over |Ω| ÷ N, the fewest that N texels can cover
/// (Theorem 1; Ω are the pixels of the picture, N the texels of the film).
struct Evenness {
    spread: f64,
    over_bound: f64,
}

impl Evenness {
    /// Over the pixels of a picture that a plane fills.
    fn of(maps: &LightMaps, rays: &PixelRays, traced: &Traced) -> Self {
        let areas: Vec<f64> = samples(maps, rays, traced)
            .iter()
            .flatten()
            .map(|sample| sample.mean_size.powi(2))
            .collect();
        let visible = f64::from(rays.size.element_product());
        assert!(areas.len() as f64 > 0.9 * visible, "{} pixels count", areas.len());
        let low = areas.iter().copied().fold(f64::INFINITY, f64::min);
        let high = areas.iter().copied().fold(0.0, f64::max);
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        Self {
            spread: high / low,
            over_bound: mean * maps.maps[0].size.as_dvec2().element_product() / visible,
        }
    }

    #[track_caller]
    fn assert_within_a_hundredth(&self, what: &str) {
        let Self { spread, over_bound } = *self;
        println!("{what}: largest ÷ smallest {spread:.5}, mean ÷ bound {over_bound:.5}");
        assert!((1.0..1.01).contains(&spread), "{what}: areas differ by {spread}");
        assert!((1.0..1.01).contains(&over_bound), "{what}: {over_bound} x the bound");
    }
}

/// One plane that fills the picture: every texel covers the same area in pixels, as small as there are texels (Theorem 1).
#[test]
fn one_plane_is_sampled_evenly_and_fully() {
    let size = UVec2::new(160, 90);
    let eye = Transform::from_xyz(0.0, 3.0, 0.0).looking_to(Vec3::new(0.15, -0.9, -1.0), Vec3::Y);
    for technique in [
        "optimal:cover=body,size=2048,filter=hard",
        "optimal:cover=body,size=2048,filter=hard,damping=0",
    ] {
        let mut harness = Harness::new(size, eye);
        let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
        let plane = harness.mesh(Plane3d::default().mesh().size(200.0, 200.0));
        harness.app.world_mut().spawn((Mesh3d(plane), MeshMaterial3d(material)));
        let light_dir = Vec3::new(-0.6, -1.0, 0.3);
        let light = harness.sun(light_dir, settings(technique));
        harness.add_mask(light, size);
        harness.start();
        let camera = harness.camera;
        let maps = LightMaps::of(harness.app.world(), light, camera);
        assert_eq!(maps.maps.len(), 1, "one film");
        let depths = view_depths(&harness);
        let truth = truth_scene(harness.app.world_mut(), Some(camera)).expect("meshes are in main memory");
        let rays = PixelRays::of_camera(size, &eye, std::f64::consts::FRAC_PI_4);
        let traced = pixels::trace(&truth, &rays, &depths, 120.0, -light_dir.as_dvec3().normalize(), |_| {});
        Evenness::of(&maps, &rays, &traced).assert_within_a_hundredth(technique);
    }
}

/// The same in the level that was made for it, with the film over what was seen that is the default.
#[test]
fn the_room_of_one_plane_is_sampled_evenly_and_fully() {
    let mut room = Room::load("one_plane");
    let shot = room.shots[0].clone();
    assert_eq!(shot.name, "down", "the shot that the plane fills");
    room.aim(&shot);
    for technique in ["optimal", "optimal:damping=0", "optimal:size=2048"] {
        room.apply(technique, shot.far);
        // Films are laid when the first picture has come back.
        room.harness.frames(WARM_UP);
        let (_, depths) = room.draw();
        let (rays, traced) = room.trace(&shot, &depths);
        let maps = LightMaps::of(room.harness.app.world(), room.sun, room.harness.camera);
        assert_eq!(maps.maps.len(), 2, "one film, and a coarse map for what was not seen");
        Evenness::of(&maps, &rays, &traced).assert_within_a_hundredth(technique);
    }
}

/// Films lose no shadow and make none, one or several of them, whatever they divide.
#[test]
fn films_agree_with_truth() {
    for light in LIGHTS {
        let (uniform_shadow, uniform_lit) = errors(light, "uniform:size=1024");
        for technique in [
            "optimal:size=1024",
            "optimal:size=1024,cover=body",
            "optimal:size=1024,frusta=4",
            "optimal:size=1024,frusta=3,divide=tiles,metric=stretch",
            "optimal:size=1024,frusta=4,seam=0.2",
            "optimal:size=1024,frusta=4,near=auto,far=auto",
            "optimal:size=1024,path=dropin",
            "optimal:size=512,frusta=4,path=dropin",
        ] {
            let (false_shadow, false_lit) = errors(light, technique);
            assert!(
                false_shadow + false_lit <= uniform_shadow + uniform_lit,
                "{technique}, light {light}: {false_shadow} + {false_lit}, uniform {uniform_shadow} + {uniform_lit}"
            );
        }
    }
}

/// A frame after a jump, when the films still belong to another view, what comes into sight has its shadows.
#[test]
fn what_comes_into_sight_is_in_a_map() {
    for technique in ["optimal:size=1024", "optimal:size=1024,frusta=4,divide=tiles"] {
        let mut harness = harness_with(&boxes());
        let light = harness.sun(LIGHTS[0], settings(technique));
        harness.start();
        let camera = harness.camera;
        let before = LightMaps::of(harness.app.world(), light, camera);
        let turned = Transform::from_xyz(-14.0, 3.0, 4.0).looking_at(Vec3::new(0.0, 1.0, -10.0), Vec3::Y);
        *harness.app.world_mut().get_mut::<Transform>(camera).expect("a camera") = turned;
        harness.frames(1);
        let maps = LightMaps::of(harness.app.world(), light, camera);
        assert_ne!(before, maps, "the films follow");
        let mut inside = 0;
        for x in -20..=20 {
            for z in -30..=10 {
                let point = DVec3::new(f64::from(x), 0.0, f64::from(z));
                let local = turned.to_matrix().inverse().transform_point3(point.as_vec3());
                let depth = f64::from(-local.z);
                let tangents = Vec2::new(local.x, local.y) / -local.z;
                if depth < 1.0 || tangents.y.abs() > 0.4 || tangents.x.abs() > 0.7 {
                    continue;
                }
                inside += 1;
                assert!(maps.select(point, depth).is_some(), "{technique}: {point} is in no map");
            }
        }
        assert!(inside > 200, "{inside} points are in view");
    }
}

/// Where films have no answer, a uniform map does, and says why.
#[test]
fn a_uniform_map_stands_in() {
    let state = |harness: &Harness, light: Entity| {
        let states = harness.app.world().get::<LightPlaneStates>(light).expect("states");
        states
            .cameras
            .get(&harness.camera)
            .and_then(|state| state.films.clone())
    };
    // Before the first picture has come back.
    let mut harness = scene(ODD);
    let light = harness.sun(LIGHTS[0], settings("optimal:size=256"));
    umbrage::cli::headless::finish(&mut harness.app);
    harness.frames(1);
    assert_eq!(state(&harness, light), Some(Err(NoFilms::NoPicture)));
    harness.frames(6);
    assert!(matches!(state(&harness, light), Some(Ok(report)) if report.count == 1 && report.gain > 1.0));
    // A camera that sees only sky, inside the bounds of the scene.
    let mut harness = scene(ODD);
    let light = harness.sun(LIGHTS[0], settings("optimal:size=256"));
    let camera = harness.camera;
    *harness.app.world_mut().get_mut::<Transform>(camera).expect("a camera") =
        Transform::from_xyz(0.0, 1.0, 10.0).looking_to(Vec3::new(0.0, 0.5, 0.3), Vec3::Z);
    harness.start();
    assert_eq!(
        state(&harness, light),
        Some(Err(NoFilms::Film(FilmError::NothingVisible)))
    );
    assert!(
        harness.shadow_result(camera).iter().all(|lit| *lit == 1.0),
        "the sky is lit"
    );
    // Another technique asks for no samples.
    *harness.app.world_mut().get_mut::<SunShadows>(light).expect("settings") = settings("lispsm:size=256");
    harness.frames(2);
    assert!(harness.app.world().get::<SurfaceSampling>(camera).is_none());
    assert_eq!(state(&harness, light), None);
}

/// Light along the view, both ways.
#[test]
fn light_along_the_view() {
    for sign in [1.0, -1.0] {
        let mut harness = scene(ODD);
        let forward = eye().forward() * sign;
        let light = harness.sun(forward, settings("optimal:size=512,frusta=2"));
        harness.start();
        let camera = harness.camera;
        let maps = LightMaps::of(harness.app.world(), light, camera);
        assert!(maps.maps.iter().all(|map| map.clip_from_world.is_finite()) && !maps.maps.is_empty());
        let result = harness.shadow_result(camera);
        if sign > 0.0 {
            // Every shadow hides behind what casts it; the bias leaves a rim.
            let dark = result.iter().filter(|lit| **lit < 0.5).count();
            assert!(dark < result.len() / 100, "{dark} pixels are dark");
        }
    }
}
