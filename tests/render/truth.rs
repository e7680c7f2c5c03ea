//! The shadow result against analytic truth: a ground plane and boxes, ray-traced in double precision.

use bevy::{
    camera::visibility::{RenderLayers, VisibilityRange},
    light::DirectionalLightShadowMap,
    math::DVec3,
    mesh::morph::{MeshMorphWeights, MorphAttributes},
    prelude::*,
};
use umbrage::{
    prelude::*,
    render::{capture, reference::extract::truth_scene},
    shadow::technique::Technique,
};

use crate::harness::{Harness, eye};

pub(crate) const SIZE: UVec2 = UVec2::new(240, 135);

pub(crate) struct Cuboid3 {
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

/// A box, a slab that floats, and poles at several distances.
pub(crate) fn boxes() -> Vec<Cuboid3> {
    let at = |x: f64, y: f64, z: f64, sx: f64, sy: f64, sz: f64| Cuboid3 {
        min: DVec3::new(x - sx / 2.0, y, z - sz / 2.0),
        max: DVec3::new(x + sx / 2.0, y + sy, z + sz / 2.0),
    };
    let mut boxes = vec![at(-2.0, 0.0, 0.0, 2.0, 2.0, 2.0), at(3.0, 1.5, 1.0, 3.0, 0.3, 2.0)];
    for i in 0..8 {
        let z = 8.0 - 8.0 * f64::from(i);
        boxes.push(at(-5.0, 0.0, z, 0.3, 4.0, 0.3));
        boxes.push(at(6.0, 0.0, z, 0.3, 4.0, 0.3));
    }
    boxes
}

/// Distance to the nearest surface and its normal.
pub(crate) fn trace(origin: DVec3, direction: DVec3, boxes: &[Cuboid3]) -> Option<(f64, DVec3, usize)> {
    let mut nearest: Option<(f64, DVec3, usize)> = None;
    let mut keep = |t: f64, normal: DVec3, id: usize| {
        if t > 0.0 && nearest.is_none_or(|(other, ..)| t < other) {
            nearest = Some((t, normal, id));
        }
    };
    if direction.y < 0.0 {
        let t = -origin.y / direction.y;
        let hit = origin + t * direction;
        if hit.x.abs() < 60.0 && hit.z.abs() < 60.0 {
            keep(t, DVec3::Y, 0);
        }
    }
    for (index, cuboid) in boxes.iter().enumerate() {
        let (a, b) = ((cuboid.min - origin) / direction, (cuboid.max - origin) / direction);
        let (enter, leave) = (a.min(b), a.max(b));
        let (t_in, t_out) = (enter.max_element(), leave.min_element());
        if t_in < t_out && t_in > 0.0 {
            let axis = if enter.x == t_in {
                0
            } else if enter.y == t_in {
                1
            } else {
                2
            };
            let mut normal = DVec3::ZERO;
            normal[axis] = -direction[axis].signum();
            keep(t_in, normal, 1 + index * 3 + axis);
        }
    }
    nearest
}

/// Direction of the ray through a place in the picture, in pixels; not of unit length.
pub(crate) fn viewing_ray(eye: Transform, x: f64, y: f64) -> DVec3 {
    let tan = (std::f64::consts::FRAC_PI_4 / 2.0).tan();
    let aspect = f64::from(SIZE.x) / f64::from(SIZE.y);
    let ndc = (x / f64::from(SIZE.x) * 2.0 - 1.0, 1.0 - y / f64::from(SIZE.y) * 2.0);
    eye.forward().as_dvec3() + eye.right().as_dvec3() * (ndc.0 * tan * aspect) + eye.up().as_dvec3() * (ndc.1 * tan)
}

/// Share of wrong pixels among those where truth is certain, (false shadow, false lit, certain pixels).
fn wrong_shares(result: &[f32], eye: Transform, light_dir: DVec3, boxes: &[Cuboid3]) -> (f64, f64, usize) {
    let origin = eye.translation.as_dvec3();
    let hit = |x: f64, y: f64| {
        let direction = viewing_ray(eye, x, y);
        trace(origin, direction, boxes).map(|(t, normal, id)| (origin + t * direction, normal, id))
    };
    let (mut false_shadow, mut false_lit, mut certain) = (0, 0, 0);
    for y in 1..SIZE.y - 1 {
        for x in 1..SIZE.x - 1 {
            let centre = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some((point, normal, id)) = hit(centre.0, centre.1) else {
                continue;
            };
            let same_surface = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)]
                .iter()
                .all(|(dx, dy)| hit(centre.0 + dx, centre.1 + dy).is_some_and(|(_, _, other)| other == id));
            if !same_surface || normal.dot(-light_dir) <= 0.15 {
                continue;
            }
            let lit = |offset: f64| trace(point + normal * offset, -light_dir, boxes).is_none();
            if lit(0.0005) != lit(0.002) {
                continue;
            }
            certain += 1;
            let shown_lit = result[(y * SIZE.x + x) as usize] > 0.5;
            match (lit(0.0005), shown_lit) {
                (true, false) => false_shadow += 1,
                (false, true) => false_lit += 1,
                _ => {}
            }
        }
    }
    let share = |count: i32| f64::from(count) / certain as f64;
    (share(false_shadow), share(false_lit), certain)
}

/// A harness with the ground plane and the boxes.
pub(crate) fn harness_with(boxes: &[Cuboid3]) -> Harness {
    let mut harness = Harness::new(SIZE, eye());
    let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
    let plane = harness.mesh(Plane3d::default().mesh().size(120.0, 120.0));
    harness
        .app
        .world_mut()
        .spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    for cuboid in boxes {
        let size = (cuboid.max - cuboid.min).as_vec3();
        let mesh = harness.mesh(Cuboid::from_size(size));
        let center = ((cuboid.max + cuboid.min) / 2.0).as_vec3();
        harness.app.world_mut().spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(center),
        ));
    }
    harness
}

/// Two independent ways to the truth: rays through the trees of the app's own meshes, and formulas.
#[test]
fn traced_truth_is_analytic_truth() {
    let boxes = boxes();
    let mut harness = harness_with(&boxes);
    harness.start();
    let scene = truth_scene(harness.app.world_mut(), Some(harness.camera)).expect("all meshes are in main memory");
    assert_eq!(scene.len(), boxes.len() + 1);
    let origin = eye().translation.as_dvec3();
    for light in LIGHTS {
        let to_light = -light.as_dvec3().normalize();
        let (mut compared, mut in_shadow, mut different) = (0, 0, 0);
        for index in 0..40_000 {
            let (x, y) = (
                f64::from(index % 200) / 100.0 - 1.0,
                f64::from(index / 200) / 100.0 - 1.0,
            );
            // No round numbers: a ray through an edge of a box may see either side.
            let direction = DVec3::new(x * 0.8 + 0.00137, y * 0.5 - 0.20113, -1.0);
            let Some((t, normal, _)) = trace(origin, direction, &boxes) else {
                continue;
            };
            let point = origin + t * direction;
            let seen = scene.first_surface(origin, direction, 0.01, 1.0e4).expect("a surface");
            let is_same = (seen.t - t).abs() < 1.0e-4 && seen.normal_world.dot(normal) > 0.9999;
            assert!(is_same, "{point}: {seen:?}, not {normal} at {t}");
            let truth = |offset: f64| trace(point + to_light * offset, to_light, &boxes).is_some();
            if normal.dot(to_light) <= 0.15 || truth(0.0005) != truth(0.002) {
                continue;
            }
            compared += 1;
            in_shadow += i32::from(truth(0.001));
            different += i32::from(scene.is_in_shadow(point, to_light, 0.001) != truth(0.001));
        }
        assert!(
            compared > 15_000 && in_shadow > 300,
            "{compared} rays, {in_shadow} in shadow"
        );
        assert_eq!(different, 0, "light {light}, of {compared} rays");
    }
}

/// Rays meet a morphed mesh where its weights put it, and other instances of the mesh where they are.
#[test]
fn truth_follows_morph_targets() {
    let mut harness = Harness::new(SIZE, eye());
    let mut raised = Mesh::from(Plane3d::default().mesh().size(4.0, 4.0));
    let count = raised.count_vertices();
    let step = |height: f32| vec![MorphAttributes::new(Vec3::Y * height, Vec3::ZERO, Vec3::ZERO); count];
    raised.set_morph_targets([step(2.0), step(-0.5)].concat());
    let mesh = harness.mesh(raised);
    let weights = |weights: &[f32]| MeshMorphWeights::Value {
        weights: weights.to_vec(),
    };
    let at = |x: f32| Transform::from_xyz(x, 1.0, 0.0);
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(mesh.clone()), at(0.0), weights(&[0.75, 0.5])));
    world.spawn((Mesh3d(mesh.clone()), at(10.0), weights(&[0.0, 0.0])));
    world.spawn((Mesh3d(mesh), at(20.0)));
    let flat = world.resource_mut::<Assets<Mesh>>().add(Cuboid::new(1.0, 1.0, 1.0));
    world.spawn((Mesh3d(flat), at(30.0), weights(&[1.0])));
    harness.start();
    let scene = truth_scene(harness.app.world_mut(), None).expect("all meshes are in main memory");
    for (x, height) in [
        (0.0, 1.0 + 0.75 * 2.0 - 0.5 * 0.5),
        (10.0, 1.0),
        (20.0, 1.0),
        (30.0, 1.5),
    ] {
        let origin = DVec3::new(x + 0.1, 50.0, 0.2);
        let seen = scene
            .first_surface(origin, DVec3::NEG_Y, 0.01, 1.0e4)
            .expect("a surface");
        assert!((50.0 - seen.t - height).abs() < 1.0e-5, "{} at {x}", 50.0 - seen.t);
    }
}

/// Shares of false shadow and of false lit pixels.
pub(crate) fn errors(light_dir: Vec3, technique: &str) -> (f64, f64) {
    let boxes = boxes();
    let mut harness = harness_with(&boxes);
    let light = harness.sun(light_dir, SunShadows::default());
    let technique = technique_of(technique);
    technique.apply(&mut harness.app.world_mut().commands().entity(light));
    harness.app.world_mut().flush();
    if matches!(technique, Technique::Bevy(_)) {
        // As many texels as the techniques of these tests have.
        harness.app.insert_resource(DirectionalLightShadowMap { size: 512 });
    }
    let result = match &technique {
        Technique::Umbrage(settings) if settings.path == ShadowPath::Full => {
            harness.start();
            harness.shadow_result(harness.camera)
        }
        _ => {
            let mask = harness.add_mask(light, SIZE);
            harness.start();
            let texels = capture::read_image(&harness.app, &mask).expect("the mask can be read");
            texels.bytes.iter().map(|value| f32::from(*value) / 255.0).collect()
        }
    };
    let (false_shadow, false_lit, certain) = wrong_shares(&result, eye(), light_dir.as_dvec3().normalize(), &boxes);
    assert!(certain > 10_000, "only {certain} pixels can be judged");
    println!("{technique}, light {light_dir}: false shadow {false_shadow:.5}, false lit {false_lit:.5} of {certain}");
    (false_shadow, false_lit)
}

fn technique_of(text: &str) -> Technique {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

pub(crate) fn settings(text: &str) -> SunShadows {
    match technique_of(text) {
        Technique::Umbrage(settings) => settings,
        Technique::Bevy(_) => panic!("{text} is no technique of Umbrage"),
    }
}

pub(crate) const LIGHTS: [Vec3; 3] = [
    Vec3::new(-0.5, -0.8, -0.4),
    Vec3::new(0.9, -0.45, 0.3),
    Vec3::new(0.1, -0.5, -0.9),
];

/// At default bias, the best technique is nearly exact: neither acne (false shadow) nor detached shadows (false lit).
#[test]
fn warped_partitions_are_nearly_exact() {
    for light in LIGHTS {
        for filter in ["hard", "pcf2", "pcf2,select=depth"] {
            let (false_shadow, false_lit) = errors(light, &format!("zp4+lispsm:size=512,filter={filter}"));
            // Measured on llvmpipe: at most 0.0011 and 0.0011; the bound leaves a factor of two.
            assert!(
                false_shadow < 0.0022,
                "{filter}: {false_shadow} of the pixels are wrongly in shadow"
            );
            assert!(
                false_lit < 0.0022,
                "{filter}: {false_lit} of the pixels are wrongly lit"
            );
        }
    }
}

/// The order of techniques that the project exists for, at equal texels.
#[test]
fn warps_and_partitions_beat_uniform() {
    for light in LIGHTS {
        let total = |technique: &str| {
            let (false_shadow, false_lit) = errors(light, technique);
            false_shadow + false_lit
        };
        let uniform = total("uniform:size=512,filter=hard");
        let warped = total("lispsm:size=512,filter=hard");
        let both = total("zp4+lispsm:size=256,filter=hard");
        assert!(
            warped <= uniform,
            "light {light}: lispsm {warped} against uniform {uniform}"
        );
        assert!(
            both < uniform,
            "light {light}: zp4+lispsm {both} against uniform {uniform}"
        );
    }
}

/// Better matrices alone, in Bevy's own passes: fewer wrong pixels than stock cascades with as many texels, of both kinds
/// together, with one map and with four.
#[test]
fn the_drop_in_path_beats_stock_cascades() {
    for light in LIGHTS {
        let total = |technique: &str| {
            let (false_shadow, false_lit) = errors(light, technique);
            false_shadow + false_lit
        };
        let stock = total("bevy");
        for technique in ["lispsm:path=dropin,size=1024", "zp4+lispsm:path=dropin,size=512"] {
            let drop_in = total(technique);
            assert!(drop_in < stock, "light {light}: {technique} {drop_in} against {stock}");
        }
    }
}

/// Flat ground under a sun that nearly touches it: no acne where nothing is in the way, down to one degree.
#[test]
fn grazing_light_gives_no_acne() {
    for elevation in [1.0_f32, 2.0, 4.0] {
        for technique in ["lispsm:size=512", "zp4+lispsm:size=256,filter=hard"] {
            let mut harness = Harness::new(SIZE, eye());
            let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
            let plane = harness.mesh(Plane3d::default().mesh().size(120.0, 120.0));
            let pole = harness.mesh(Cuboid::new(0.3, 4.0, 0.3));
            let world = harness.app.world_mut();
            world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
            // Behind the light's way: it makes a scene with height, and its shadow leaves the picture.
            world.spawn((
                Mesh3d(pole),
                MeshMaterial3d(material),
                Transform::from_xyz(-40.0, 2.0, -30.0),
            ));
            let radians = elevation.to_radians();
            harness.sun(Vec3::new(-radians.cos(), -radians.sin(), -0.1), settings(technique));
            harness.start();
            let result = harness.shadow_result(harness.camera);
            let below_horizon = (SIZE.x * SIZE.y * 2 / 3) as usize..;
            let ground = &result[below_horizon];
            let dark = ground.iter().filter(|lit| **lit < 0.9).count();
            assert_eq!(
                dark,
                0,
                "{technique}, {elevation} degrees: {dark} of {} pixels",
                ground.len()
            );
        }
    }
}

/// A wall of fins that are about as wide as a pixel, all of it lit: depths of neighbouring pixels belong to different
/// faces, so no plane fits them, and the bias must know that.
#[test]
fn a_facade_of_fins_is_not_speckled() {
    const FINS: u32 = 90;
    let light_dir = DVec3::new(-0.8, -0.5, -0.35).normalize();
    let mut boxes: Vec<Cuboid3> = (0..FINS)
        .map(|i| {
            let z = -1.1 * f64::from(i);
            Cuboid3 {
                min: DVec3::new(-8.0, 0.0, z),
                max: DVec3::new(-7.65, 14.0, z + 0.5),
            }
        })
        .collect();
    boxes.push(Cuboid3 {
        min: DVec3::new(-12.0, 0.0, -1.1 * f64::from(FINS)),
        max: DVec3::new(-8.0, 14.0, 1.0),
    });
    let mut harness = harness_with(&boxes);
    harness.sun(light_dir.as_vec3(), settings("zp4+lispsm:size=2048"));
    harness.start();
    let result = harness.shadow_result(harness.camera);
    let (width, height) = (SIZE.x as usize, SIZE.y as usize);
    let tan = (std::f64::consts::FRAC_PI_4 / 2.0).tan();
    let eye = eye();
    let (right, up, forward) = (eye.right().as_dvec3(), eye.up().as_dvec3(), eye.forward().as_dvec3());
    let origin = eye.translation.as_dvec3();
    let is_lit_wall = |x: f64, y: f64| {
        let ndc = (x / width as f64 * 2.0 - 1.0, 1.0 - y / height as f64 * 2.0);
        let direction = forward + right * (ndc.0 * tan * f64::from(SIZE.x) / f64::from(SIZE.y)) + up * (ndc.1 * tan);
        trace(origin, direction, &boxes).is_some_and(|(t, normal, id)| {
            let point = origin + t * direction;
            id != 0 && trace(point + normal * 1.0e-3, -light_dir, &boxes).is_none()
        })
    };
    let (mut lit, mut speckled) = (0, 0);
    for (index, shown) in result.iter().enumerate() {
        let (x, y) = ((index % width) as f64, (index / width) as f64);
        let is_lit =
            (0..25).all(|i| is_lit_wall(x + (f64::from(i % 5) + 0.5) / 5.0, y + (f64::from(i / 5) + 0.5) / 5.0));
        lit += u32::from(is_lit);
        speckled += u32::from(is_lit && *shown < 0.9);
    }
    let share = f64::from(speckled) / f64::from(lit);
    println!("{speckled} of {lit} wholly lit pixels are darker than 0.9");
    assert!(lit > 1_500, "only {lit} pixels of the wall are lit");
    assert!(share < 0.02, "{share} of the lit wall is speckled");
}

/// Levels of detail: truth has the one that the camera draws, and nothing on layers that it does not see.
#[test]
fn truth_has_what_the_camera_draws() {
    let mut harness = harness_with(&[]);
    let material = harness.material(Color::WHITE);
    let cuboid = harness.mesh(Cuboid::new(1.0, 1.0, 1.0));
    let eye_distance = eye().translation.length();
    for range in [0.0..eye_distance + 5.0, eye_distance + 5.0..1_000.0] {
        harness.app.world_mut().spawn((
            Mesh3d(cuboid.clone()),
            MeshMaterial3d(material.clone()),
            VisibilityRange::abrupt(range.start, range.end),
        ));
    }
    harness.app.world_mut().spawn((
        Mesh3d(cuboid.clone()),
        MeshMaterial3d(material.clone()),
        RenderLayers::layer(3),
    ));
    harness.start();
    let camera = harness.camera;
    let mut instances = |camera| truth_scene(harness.app.world_mut(), camera).map(|scene| scene.len());
    assert_eq!(instances(Some(camera)), Ok(2), "the ground and the near level");
    assert_eq!(instances(None), Ok(4));
}
