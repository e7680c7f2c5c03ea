//! The way of the shadow result into Bevy's lighting, against Bevy's own lookup with the same matrices.

use bevy::{
    light::{
        CascadeShadowConfigBuilder, Cascades, DirectionalLightShadowMap, ShadowFilteringMethod, SimulationLightSystems,
        cascade::Cascade,
    },
    prelude::*,
};
use umbrage::{
    prelude::*,
    render::capture,
    shadow::views::{LightView, SunViews},
};

use crate::harness::{Harness, eye};

const SIZE: UVec2 = UVec2::new(160, 90);

/// Towards the light, in metres.
const BIAS: f32 = 0.05;
const MAP_SIZE: u32 = 512;

/// Who draws and reads the only map.
enum Lookup {
    /// Umbrage's full path.
    Full(SunShadows),
    /// Bevy, with the matrices of this light view.
    Bevy(LightView),
}

/// Overwrites Bevy's cascades.
#[derive(Resource)]
struct Overwrite(LightView);

fn overwrite_cascades(light_view: Res<Overwrite>, mut lights: Query<&mut Cascades>) {
    for mut cascades in &mut lights {
        for cascade in cascades.cascades.values_mut().flatten() {
            *cascade = Cascade {
                world_from_cascade: light_view.0.world_from_light,
                clip_from_cascade: light_view.0.clip_from_light,
                clip_from_world: light_view.0.clip_from_world,
                texel_size: light_view.0.texel_size,
            };
        }
    }
}

/// The mask (one value per pixel) and the light view of the only map.
fn mask_of(lookup: Lookup) -> (Vec<u8>, Option<LightView>) {
    let mut harness = Harness::new(SIZE, eye());
    let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
    let ball = harness.mesh(Sphere::new(1.0).mesh().uv(24, 16));
    let plane = harness.mesh(Plane3d::default().mesh().size(60.0, 60.0));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    for i in 0..5 {
        let place = Transform::from_xyz(i as f32 * 2.4 - 5.0, 1.5, -3.0 + i as f32);
        world.spawn((Mesh3d(ball.clone()), MeshMaterial3d(material.clone()), place));
    }
    let full = match lookup {
        Lookup::Full(settings) => Some(settings),
        Lookup::Bevy(light_view) => {
            harness.app.insert_resource(DirectionalLightShadowMap {
                size: MAP_SIZE as usize,
            });
            harness.app.insert_resource(Overwrite(light_view)).add_systems(
                PostUpdate,
                overwrite_cascades
                    .after(SimulationLightSystems::UpdateDirectionalLightCascades)
                    .before(SimulationLightSystems::UpdateLightFrusta),
            );
            None
        }
    };
    let one_cascade = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 1000.0,
        ..default()
    };
    let light = harness.sun(Vec3::new(-0.6, -0.8, -0.2), full.clone().unwrap_or_default());
    let mut entity = harness.app.world_mut().entity_mut(light);
    if full.is_none() {
        entity.remove::<SunShadows>();
        entity.insert(one_cascade.build());
    }
    if let Some(mut directional) = entity.get_mut::<DirectionalLight>() {
        directional.shadow_depth_bias = BIAS;
        directional.shadow_normal_bias = 0.0;
    }
    let mask = harness.add_mask(light, SIZE);
    let mut camera = harness.app.world_mut().entity_mut(harness.camera);
    camera.insert(ShadowFilteringMethod::Hardware2x2);
    harness.start();
    let light_view = full.map(|_| {
        let views = harness.app.world().get::<SunViews>(light).expect("the sun has views");
        views.cameras[&harness.camera].partitions[0].light_view.clone()
    });
    let texels = capture::read_image(&harness.app, &mask).expect("the mask can be read");
    (texels.bytes, light_view)
}

#[test]
fn full_path_equals_bevys_lookup_with_the_same_matrices() {
    for warp in ["uniform", "lispsm"] {
        let technique = format!("{warp}:size={MAP_SIZE},filter=pcf2,bias=constant,bias_m={BIAS}");
        let Ok(Technique::Umbrage(settings)) = technique.parse() else {
            panic!("{technique} is no technique of Umbrage");
        };
        let (full, light_view) = mask_of(Lookup::Full(settings));
        let (bevy, _) = mask_of(Lookup::Bevy(light_view.expect("the full path has a light view")));
        let in_shadow = bevy.iter().filter(|value| **value < 128).count();
        assert!(in_shadow > 300, "{warp}: only {in_shadow} pixels are in shadow");
        let decided_otherwise = full
            .iter()
            .zip(&bevy)
            .filter(|(a, b)| (**a > 127) != (**b > 127))
            .count();
        assert_eq!(
            decided_otherwise, 0,
            "{warp}: pixels that are lit by one path and not by the other"
        );
        // Fractions pass through a 16-bit float: at most one step of 8 bits.
        let largest = full.iter().zip(&bevy).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(
            largest <= Some(1),
            "{warp}: filtered values differ by {largest:?} of 255"
        );
    }
}

/// The normals of rounded foliage face away from the sun where its leaves do not: the mask says what the leaves see of it.
#[test]
fn planes_decide_what_faces_away() {
    for (normal, light_dir, expected) in [
        (Vec3::Z, Vec3::new(0.1, -0.3, -1.0), 255),
        (Vec3::NEG_Z, Vec3::new(0.1, -0.3, -1.0), 255),
        (Vec3::Z, Vec3::new(0.1, -0.3, 1.0), 0),
        (Vec3::NEG_Y, Vec3::new(0.1, -0.3, 1.0), 0),
    ] {
        let size = UVec2::new(64, 36);
        let mut harness = Harness::new(size, Transform::from_xyz(0.0, 0.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y));
        let card = Mesh::from(Rectangle::new(3.0, 3.0));
        let normals = vec![normal.to_array(); card.count_vertices()];
        let card = harness.mesh(card.with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals));
        let material = harness.material(Color::WHITE);
        let place = Transform::from_rotation(Quat::from_rotation_y(0.3));
        harness
            .app
            .world_mut()
            .spawn((Mesh3d(card), MeshMaterial3d(material), place));
        let sun = harness.sun(light_dir, SunShadows::LOW);
        let mask = harness.add_mask(sun, size);
        harness.start();
        let mask = capture::read_image(&harness.app, &mask).expect("the mask can be read");
        let middle = (14..22).flat_map(|y| (26..38).map(move |x| y * size.x as usize + x));
        let found: Vec<u8> = middle.map(|pixel| mask.bytes[pixel]).collect();
        assert!(
            found.iter().all(|code| *code == expected),
            "normal {normal}, light along {light_dir}: {found:?}"
        );
    }
}
