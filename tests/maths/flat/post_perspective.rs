//! Perspective shadow maps as films in the world.

use umbrage::maths::light_plane::flat::{
    Camera, Degenerate, Footprints, Light, Tilt,
    construction::single_plane_tilt,
    post_perspective::PostPerspective,
    printed_angle,
    study::{Method, Scene, row, scenes},
};

use super::{at, lamp, near, surface};

/// The single plane of the thesis's first table, with the camera's depth range.
fn single_plane(near_depth: f64, far: f64, light: Light) -> Scene {
    Scene {
        name: "single plane",
        camera: Camera::new(at(1.0, 0.0), 0.0, 30.0_f64.to_radians(), near_depth, far, 4000).expect("sound"),
        surfaces: vec![surface([0.0, -0.452 * 4.0], [0.0, -2.008 * 4.0])],
        light,
    }
}

fn table_light() -> Light {
    lamp(4.0, -4.0 * 9.0_f64.to_radians().tan())
}

fn map_of(scene: &Scene) -> PostPerspective {
    PostPerspective::new(&scene.camera, scene.light, &scene.camera.see(&scene.surfaces)).expect("a map")
}

/// O16: places of such a map are a tilt of any other's, whatever its near plane, in all scenes.
#[test]
fn perspective_shadow_maps_are_tilts() {
    for scene in scenes() {
        let exposure = scene.exposure().unwrap();
        let hits = scene.camera.see(&scene.surfaces);
        let map = map_of(&scene);
        let tilt = map.tilt(&exposure).unwrap();
        let near_planes = [1.0, 0.5, 0.01].map(|share| map.map_from_world(share));
        // Behind the eye the order is turned round.
        let sign = (map.place(hits[0].point).unwrap() * tilt.place(exposure.samples[0].place)).signum();
        for (hit, sample) in hits.iter().zip(&exposure.samples) {
            let place = map.place(hit.point).unwrap();
            near(sign * place, tilt.place(sample.place), 1.0e-10);
            for matrix in near_planes {
                let point = matrix * hit.point.extend(1.0);
                near(point.y / point.z, place, 1.0e-10);
            }
        }
    }
}

/// The table of erratum X6: the thesis's rule depends on the near plane and goes to the real map as that goes to the light.
#[test]
fn the_printed_rule_is_not_a_perspective_shadow_map() {
    let scene = single_plane(1.0, 20.0, table_light());
    let exposure = scene.exposure().unwrap();
    let map = map_of(&scene);
    let texels = exposure.samples.len() as f64;
    let check = |tilt: Tilt, angle: f64, [worst, average, last]: [f64; 3]| {
        near(printed_angle(exposure.angle_of_tilt(tilt).unwrap()), angle, 0.006);
        let found = Footprints::of(&exposure.samples, tilt, texels).unwrap();
        near(found.worst / worst, 1.0, 2.0e-3);
        near(found.average / average, 1.0, 2.0e-3);
        near(found.average_and_deviation() / last, 1.0, 2.0e-3);
    };
    let floor = &scene.surfaces[0];
    check(
        single_plane_tilt(&scene.camera, floor, &exposure).unwrap(),
        9.0,
        [0.9993; 3],
    );
    check(Tilt::default(), 51.02, [2.200, 1.218, 1.725]);
    check(
        map.printed_rule_tilt(1.0, &exposure).unwrap(),
        94.54,
        [5.08, 2.09, 3.52],
    );
    check(
        map.printed_rule_tilt(0.5, &exposure).unwrap(),
        20.93,
        [1.345, 1.029, 1.203],
    );
    check(map.tilt(&exposure).unwrap(), 10.67, [1.050, 1.000, 1.029]);
    let at_light = map.printed_rule_tilt(1.0e-7, &exposure).unwrap();
    near(at_light.parameter, map.tilt(&exposure).unwrap().parameter, 1.0e-5);
}

/// What does change the real map is the camera's depth range.
#[test]
fn the_cameras_depth_range_changes_the_map() {
    for (near_depth, far, angle) in [(1.0, 20.0, 10.67), (1.0, 100.0, 10.76), (0.1, 20.0, 11.91)] {
        let scene = single_plane(near_depth, far, table_light());
        let found = row(&scene, Method::PostPerspective).unwrap();
        near(found.angle.unwrap(), angle, 0.006);
    }
}

/// Section 2.2.3: with light on the view plane, parallel in the cube, one plane gets the best film.
#[test]
fn light_across_the_view_is_the_ideal_case() {
    for light in [lamp(5.0, 0.0), Light::Directional { travel: at(-1.0, 0.0) }] {
        let scene = single_plane(1.0, 20.0, light);
        let exposure = scene.exposure().unwrap();
        let best = single_plane_tilt(&scene.camera, &scene.surfaces[0], &exposure).unwrap();
        near(
            map_of(&scene).tilt(&exposure).unwrap().parameter,
            best.parameter,
            1.0e-9,
        );
    }
    // With surfaces of several directions it is exact no more.
    let mut scene = single_plane(1.0, 20.0, lamp(5.0, 0.0));
    scene.surfaces.push(surface([0.0, -8.0], [3.0, -8.0]));
    let (best, real) = (
        row(&scene, Method::L1).unwrap(),
        row(&scene, Method::PostPerspective).unwrap(),
    );
    assert!(real.footprints.average > 1.01 * best.footprints.average);
}

/// Qualitative claim 1 of section 4: the thesis's rule gives much the same angle wherever the light stands above the
/// single plane, far from the best.
#[test]
fn the_printed_rule_hardly_follows_the_light() {
    let angles = [-2.0, -0.6, 0.3].map(|z| {
        let scene = single_plane(1.0, 20.0, lamp(4.0, z));
        printed_angle(map_of(&scene).printed_rule_angle(1.0).unwrap())
    });
    assert!(angles.iter().all(|angle| (90.0..105.0).contains(angle)), "{angles:?}");
}

/// The sun, from ahead and from behind: places agree with the tilt, or the refusal has a name.
#[test]
fn parallel_light_has_perspective_shadow_maps() {
    for travel in [at(-1.0, 0.3), at(-1.0, -0.3), at(-1.0, 0.0)] {
        let scene = single_plane(1.0, 20.0, Light::Directional { travel });
        let exposure = scene.exposure().unwrap();
        let map = map_of(&scene);
        let tilt = map.tilt(&exposure).unwrap();
        let hits = scene.camera.see(&scene.surfaces);
        let sign = (map.place(hits[0].point).unwrap() * tilt.place(exposure.samples[0].place)).signum();
        for (hit, sample) in hits.iter().zip(&exposure.samples) {
            near(sign * map.place(hit.point).unwrap(), tilt.place(sample.place), 1.0e-9);
        }
    }
    let scene = single_plane(1.0, 20.0, Light::Directional { travel: at(0.0, 0.0) });
    let hits = scene.camera.see(&scene.surfaces);
    let refused = PostPerspective::new(&scene.camera, scene.light, &hits).map(|_| ());
    assert_eq!(refused, Err(Degenerate::NoLightDirection));
    assert_eq!(
        PostPerspective::new(&scene.camera, table_light(), &[]).map(|_| ()),
        Err(Degenerate::NothingVisible)
    );
}

/// Section 2.2.3: light from inside of the picture, with surfaces all around it in the cube, would need the camera pulled
/// back. Half of a circle of surfaces still has a map.
#[test]
fn light_inside_the_picture_is_refused() {
    let mut scene = single_plane(1.0, 20.0, lamp(1.0, -4.0));
    scene.surfaces.push(surface([-1.0, -8.1], [3.0, -8.1]));
    scene.surfaces.push(surface([2.0, -3.9], [2.0, -8.0]));
    scene.surfaces.push(surface([1.2, -2.1], [1.9, -3.0]));
    let hits = scene.camera.see(&scene.surfaces);
    let refused = PostPerspective::new(&scene.camera, scene.light, &hits).map(|_| ());
    assert_eq!(refused, Err(Degenerate::TooWide));
    scene.surfaces = vec![surface([-1.0, -8.1], [3.0, -8.1])];
    let hits = scene.camera.see(&scene.surfaces);
    assert!(PostPerspective::new(&scene.camera, scene.light, &hits).is_ok());
}
