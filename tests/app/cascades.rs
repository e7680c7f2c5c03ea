//! What both paths write into Bevy's cascades, and that Bevy's own behavior comes back.

use bevy::{
    camera::primitives::CascadesFrusta,
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    prelude::*,
};
use umbrage::{
    maths::{
        drop_in::{LookupRoom, fit_slice_with_room, slice_depths},
        fit::{FitInput, FitOptions},
        split::{PseudoPlanes, SplitScheme},
        warp::Warp,
    },
    shadow::{
        full::{MASK_BOUND, mask_cascade},
        settings::{Partitions, ShadowBias, ShadowPath, SunShadows},
        view_volume::view_volume,
    },
};

use crate::support::{app, cascades, spawn_camera, spawn_sun, spawn_town, views};

fn drop_in() -> SunShadows {
    SunShadows::DROP_IN
}

/// The slices that `maths::drop_in` promises something of are those that the path has, split and fitted.
#[test]
fn drop_in_slices_are_those_of_the_promise() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, drop_in());
    app.update();
    let views = views(&app, sun, camera).expect("the camera sees the town");
    let (near, far) = (f64::from(views.near_depth), f64::from(views.far_depth));
    let planes = PseudoPlanes {
        near: f64::NAN,
        far: f64::NAN,
    };
    let depths = slice_depths(&SplitScheme::Logarithmic, near, far, planes, 4);
    let (projection, transform) = (
        app.world().get::<Projection>(camera).expect("a lens"),
        app.world().get::<GlobalTransform>(camera).expect("placed"),
    );
    let view = view_volume(projection, transform).expect("a view");
    let light = app.world().get::<GlobalTransform>(sun).expect("placed");
    let room = LookupRoom {
        filter_texels: 4.0,
        normal_texels: 0.4 * std::f64::consts::SQRT_2,
    };
    for (partition, range) in views.partitions.iter().zip(depths.windows(2)) {
        let found = [partition.light_view.near_depth, partition.light_view.far_depth];
        assert!(
            (f64::from(found[0]) - range[0]).abs() < 1.0e-4 * range[0],
            "{found:?}, not {range:?}"
        );
        let slice = view.split(range[0], range[1]);
        let input = FitInput {
            view: &slice,
            visible: &partition.visible,
            body: &partition.body,
            light_travel: light.forward().as_dvec3(),
            warp: Warp::Lispsm,
            map_size: UVec2::splat(2048),
            guard_texels: 0.0,
            guard_metres: 0.0,
            options: FitOptions::default(),
        };
        let fit = fit_slice_with_room(&input, &room, far).fitted().expect("a light view");
        let difference = fit.clip_from_world_f32() - partition.light_view.clip_from_world;
        let largest = difference.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
        assert!(largest < 1.0e-3, "{range:?}: {largest}");
    }
}

/// Bevy's lookup: the cascade of a view depth, and the place in it after bias.
fn lookup(app: &App, sun: Entity, camera: Entity, point: Vec3, normal: Vec3) -> Option<Vec3> {
    let (cascades, config) = cascades(app, sun);
    let light = app.world().get::<DirectionalLight>(sun).expect("a light");
    let transform = app.world().get::<GlobalTransform>(sun).expect("placed");
    let eye = app.world().get::<GlobalTransform>(camera).expect("placed");
    let depth = (point - eye.translation()).dot(*eye.forward());
    let index = config.bounds.iter().position(|bound| depth < *bound)?;
    let cascade = &cascades.cascades[&camera][index];
    let moved = point
        + normal * light.shadow_normal_bias * std::f32::consts::SQRT_2 * cascade.texel_size
        + *transform.back() * light.shadow_depth_bias;
    let clip = cascade.clip_from_world * moved.extend(1.0);
    (clip.w > 0.0).then(|| clip.truncate() / clip.w)
}

#[test]
fn drop_in_cascades_contain_every_receiver_after_bias() {
    for count in 1..=4 {
        let mut app = app();
        spawn_town(&mut app);
        let camera = spawn_camera(&mut app);
        let sun = spawn_sun(
            &mut app,
            SunShadows {
                partitions: Partitions {
                    count,
                    ..Partitions::default()
                },
                map_size: 512,
                ..drop_in()
            },
        );
        app.update();
        let (cascades, config) = cascades(&app, sun);
        assert_eq!(
            (cascades.cascades[&camera].len(), config.bounds.len()),
            (count as usize, count as usize)
        );
        assert!(config.bounds.is_sorted_by(|a, b| a < b), "{config:?}");
        let views = views(&app, sun, camera).expect("the camera sees the town");
        let margin = 1.0 - 3.0 * 2.0 / 512.0;
        let mut corners = 0;
        for partition in &views.partitions {
            // Only vertices of B that the camera sees are receivers; the others are casters.
            for vertex in partition.body.vertices() {
                let vertex = vertex.as_vec3();
                let eye = app.world().get::<GlobalTransform>(camera).expect("placed");
                let depth = (vertex - eye.translation()).dot(*eye.forward());
                let (near, far) = (partition.light_view.near_depth, partition.light_view.far_depth);
                if depth < near + 0.01 || depth > far - 0.01 {
                    continue;
                }
                for normal in [Vec3::Y, Vec3::Z, Vec3::X, Vec3::NEG_X] {
                    let ndc = lookup(&app, sun, camera, vertex, normal).expect("in front");
                    assert!(ndc.truncate().abs().max_element() < margin, "{vertex}: {ndc}");
                    assert!(ndc.z > 0.0 && ndc.z <= 1.0, "{vertex}: {ndc}");
                    corners += 1;
                }
            }
            for depth in [partition.light_view.near_depth, partition.light_view.far_depth - 1.0e-3] {
                let eye = app.world().get::<GlobalTransform>(camera).expect("placed");
                let ahead = eye.translation() + *eye.forward() * depth;
                let ndc = lookup(&app, sun, camera, ahead.with_y(ahead.y.max(0.0)), Vec3::Y).expect("in front");
                assert!(ndc.truncate().abs().max_element() < margin, "{depth} m ahead: {ndc}");
            }
        }
        assert!(corners > 0, "some corners were tried");
    }
}

#[test]
fn cascades_are_rigid_and_compose() {
    for settings in [drop_in(), SunShadows::HIGH] {
        let mut app = app();
        spawn_town(&mut app);
        let camera = spawn_camera(&mut app);
        let sun = spawn_sun(&mut app, settings);
        app.update();
        for cascade in &cascades(&app, sun).0.cascades[&camera] {
            let rotation = Mat3::from_mat4(cascade.world_from_cascade);
            assert!(
                (rotation * rotation.transpose()).abs_diff_eq(Mat3::IDENTITY, 1.0e-5),
                "rigid"
            );
            assert!((rotation.determinant() - 1.0).abs() < 1.0e-5, "not mirrored");
            assert!(cascade.clip_from_cascade.determinant() > 0.0, "not mirrored");
            assert!(cascade.texel_size > 0.0);
            let point = Vec3::new(3.0, 1.0, -15.0);
            let composed = cascade.clip_from_cascade * cascade.world_from_cascade.inverse();
            let (a, b) = (
                composed.project_point3(point),
                cascade.clip_from_world.project_point3(point),
            );
            assert!(a.distance(b) <= 1.0e-3 * b.length().max(1.0), "{a} {b}");
        }
        let frusta = app.world().get::<CascadesFrusta>(sun).expect("frusta");
        let count = cascades(&app, sun).0.cascades[&camera].len();
        assert_eq!(frusta.frusta[&camera].len(), count, "Bevy's frusta follow");
    }
}

#[test]
fn the_full_path_has_a_master_view_and_a_mask_layer() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    let views = views(&app, sun, camera).expect("the camera sees the town");
    let (cascades, config) = cascades(&app, sun);
    let [master, mask] = &cascades.cascades[&camera][..] else {
        panic!("two cascades");
    };
    assert_eq!(master.clip_from_world, views.master.clip_from_world);
    assert_eq!(master.clip_from_world.row(3), Vec4::W, "the master view is uniform");
    assert_eq!(mask.clip_from_world, mask_cascade().clip_from_world);
    assert_eq!(config.bounds[1], MASK_BOUND);
    assert!(config.bounds[0] > views.far_depth && config.bounds[0] < views.far_depth * 1.01);
    assert_eq!(config.overlap_proportion, 0.0);
    // Every caster of every partition is inside the master view.
    for vertex in views.partitions.iter().flat_map(|partition| partition.body.vertices()) {
        let ndc = views.master.clip_from_world.project_point3(vertex.as_vec3());
        assert!(
            ndc.truncate().abs().max_element() < 1.0 && ndc.z > 0.0 && ndc.z < 1.0,
            "{ndc}"
        );
    }
}

#[test]
fn cameras_that_see_nothing_are_lit() {
    for settings in [drop_in(), SunShadows::HIGH] {
        let mut app = app();
        spawn_town(&mut app);
        let seeing = spawn_camera(&mut app);
        let blind = app
            .world_mut()
            .spawn((
                Camera3d::default(),
                Transform::from_xyz(0.0, 100.0, 0.0).looking_to(Vec3::Y, Vec3::Z),
            ))
            .id();
        let sun = spawn_sun(&mut app, settings);
        app.update();
        let (cascades, config) = cascades(&app, sun);
        assert_eq!(cascades.cascades[&seeing].len(), config.bounds.len());
        assert_eq!(cascades.cascades[&blind].len(), config.bounds.len());
        for cascade in &cascades.cascades[&blind] {
            assert_eq!(cascade.clip_from_world, mask_cascade().clip_from_world);
        }
    }
}

#[test]
fn removal_restores_bevys_shadows() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let config = CascadeShadowConfigBuilder {
        num_cascades: 3,
        maximum_distance: 77.0,
        ..default()
    }
    .build();
    let sun = spawn_sun(&mut app, drop_in());
    let light = DirectionalLight {
        shadow_maps_enabled: true,
        shadow_depth_bias: 0.07,
        shadow_normal_bias: 0.9,
        ..default()
    };
    app.world_mut()
        .entity_mut(sun)
        .remove::<SunShadows>()
        .insert((light, config.clone()));
    app.world_mut().resource_mut::<DirectionalLightShadowMap>().size = 1024;
    app.update();
    let (stock_cascades, _) = cascades(&app, sun);

    for path in [ShadowPath::DropIn, ShadowPath::Full] {
        let settings = SunShadows {
            path,
            map_size: 4096,
            ..SunShadows::HIGH
        };
        app.world_mut().entity_mut(sun).insert(settings);
        app.update();
        app.update();
        let size = app.world().resource::<DirectionalLightShadowMap>().size;
        assert_eq!(size, if path == ShadowPath::DropIn { 4096 } else { 1024 });
        assert_ne!(cascades(&app, sun).1.bounds, config.bounds);
    }

    app.world_mut().entity_mut(sun).remove::<SunShadows>();
    app.update();
    let (cascades, restored) = cascades(&app, sun);
    assert_eq!(restored.bounds, config.bounds);
    assert_eq!(restored.overlap_proportion, config.overlap_proportion);
    assert_eq!(restored.minimum_distance, config.minimum_distance);
    let light = app.world().get::<DirectionalLight>(sun).expect("a light");
    assert_eq!((light.shadow_depth_bias, light.shadow_normal_bias), (0.07, 0.9));
    assert_eq!(app.world().resource::<DirectionalLightShadowMap>().size, 1024);
    let matrices = |cascades: &bevy::light::Cascades| -> Vec<Mat4> {
        cascades.cascades[&camera]
            .iter()
            .map(|cascade| cascade.clip_from_world)
            .collect()
    };
    app.update();
    assert_eq!(matrices(&self::cascades(&app, sun).0), matrices(&stock_cascades));
    assert_eq!(cascades.cascades[&camera].len(), 3);
}

#[test]
fn only_the_drop_in_path_touches_bevys_bias() {
    let mut app = app();
    spawn_town(&mut app);
    spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, drop_in());
    let mut biases = |bias, path| {
        let mut settings = app.world_mut().get_mut::<SunShadows>(sun).expect("settings");
        settings.bias = bias;
        settings.path = path;
        app.update();
        let light = app.world().get::<DirectionalLight>(sun).expect("a light");
        (light.shadow_depth_bias, light.shadow_normal_bias)
    };
    assert_eq!(biases(ShadowBias::None, ShadowPath::DropIn), (0.0, 0.0));
    assert_eq!(
        biases(ShadowBias::Constant { metres: 0.3 }, ShadowPath::DropIn),
        (0.3, 0.0)
    );
    let (depth, normal) = biases(ShadowBias::Footprint { scale: 1.0 }, ShadowPath::DropIn);
    // Most of the bias is on the casters' side (`caster_depth_bias`).
    assert!(depth > 0.0 && depth < DirectionalLight::DEFAULT_SHADOW_DEPTH_BIAS && normal > 0.0);
    let stock = (
        DirectionalLight::DEFAULT_SHADOW_DEPTH_BIAS,
        DirectionalLight::DEFAULT_SHADOW_NORMAL_BIAS,
    );
    assert_eq!(biases(ShadowBias::Footprint { scale: 1.0 }, ShadowPath::Full), stock);
}
