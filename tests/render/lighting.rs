//! What reaches the picture: every path, renderer and kind of camera.

use bevy::{
    camera::RenderTarget,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    light::{NotShadowCaster, TransmittedShadowReceiver},
    pbr::{DefaultOpaqueRendererMethod, ShadowView},
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipelineState, PipelineCache},
        sync_world::RenderEntity,
    },
};
use umbrage::{prelude::*, render::transparent::TransparentSurfaces};

use crate::harness::{Harness, WARM_UP, add_target, eye, results};

const SIZE: UVec2 = UVec2::new(160, 90);
/// Straight enough that the shadow of the slab lies beside it on the ground.
const LIGHT: Vec3 = Vec3::new(-0.6, -0.8, 0.0);
/// On the ground: in the shadow of the slab (x −1..1, 3 m high), and beside it.
const IN_SHADOW: Vec3 = Vec3::new(-2.25, 0.0, 0.0);
const LIT: Vec3 = Vec3::new(2.5, 0.0, 0.0);

fn ground_and_slab(harness: &mut Harness) {
    let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
    let plane = harness.mesh(Plane3d::default().mesh().size(60.0, 60.0));
    let slab = harness.mesh(Cuboid::new(2.0, 0.2, 4.0));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    world.spawn((
        Mesh3d(slab),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, 3.0, 0.0),
    ));
    world.insert_resource(GlobalAmbientLight {
        brightness: 100.0,
        ..default()
    });
}

/// Mean of the three channels where a world point is seen.
fn brightness(harness: &Harness, camera: Entity, target: &Handle<Image>, point: Vec3) -> f32 {
    let world = harness.app.world();
    let transform = world.get::<GlobalTransform>(camera).expect("a camera");
    let projection = world.get::<Projection>(camera).expect("a camera");
    let ndc = (projection.get_clip_from_view() * transform.to_matrix().inverse()).project_point3(point);
    let picture = umbrage::render::capture::read_image(&harness.app, target).expect("the picture can be read");
    let x = ((ndc.x * 0.5 + 0.5) * picture.width as f32) as usize;
    let y = ((0.5 - ndc.y * 0.5) * picture.height as f32) as usize;
    let offset = (y * picture.width as usize + x) * 4;
    picture.bytes[offset..offset + 3]
        .iter()
        .map(|channel| f32::from(*channel))
        .sum::<f32>()
        / 3.0
}

fn assert_shadow(harness: &Harness, camera: Entity, target: &Handle<Image>, what: &str) {
    let (dark, bright) = (
        brightness(harness, camera, target, IN_SHADOW),
        brightness(harness, camera, target, LIT),
    );
    assert!(bright > 60.0, "{what}: the lit ground has brightness {bright}");
    assert!(
        dark < 0.6 * bright,
        "{what}: {dark} in the shadow against {bright} beside it"
    );
}

fn assert_pipelines_compiled(harness: &Harness) {
    let cache = harness.app.sub_app(RenderApp).world().resource::<PipelineCache>();
    for pipeline in cache.pipelines() {
        if let CachedPipelineState::Err(error) = &pipeline.state {
            panic!("a pipeline does not compile: {error}");
        }
    }
}

fn settings(technique: &str) -> SunShadows {
    match technique.parse() {
        Ok(Technique::Umbrage(settings)) => settings,
        other => panic!("{technique} is no technique of Umbrage: {other:?}"),
    }
}

#[test]
fn both_paths_shadow_forward_and_deferred() {
    for technique in ["zp4+lispsm:size=512", "zp2+lispsm:size=512,path=dropin"] {
        for deferred in [false, true] {
            let mut harness = Harness::new(SIZE, eye());
            if deferred {
                harness.app.insert_resource(DefaultOpaqueRendererMethod::deferred());
                harness
                    .app
                    .world_mut()
                    .entity_mut(harness.camera)
                    .insert(DeferredPrepass);
            }
            ground_and_slab(&mut harness);
            harness.sun(LIGHT, settings(technique));
            harness.start();
            assert_pipelines_compiled(&harness);
            assert_shadow(
                &harness,
                harness.camera,
                &harness.target,
                &format!("{technique}, deferred {deferred}"),
            );
        }
    }
}

#[test]
fn two_cameras_and_an_orthographic_one() {
    let mut harness = Harness::new(SIZE, eye());
    ground_and_slab(&mut harness);
    harness.sun(LIGHT, settings("zp3+lispsm:size=512"));
    let second_target = add_target(&mut harness.app, UVec2::new(96, 96));
    let second = harness
        .app
        .world_mut()
        .spawn((
            Camera3d::default(),
            Camera { order: 1, ..default() },
            RenderTarget::Image(second_target.clone().into()),
            Msaa::Off,
            DepthPrepass,
            Projection::Orthographic(OrthographicProjection {
                near: 0.1,
                far: 60.0,
                scale: 0.12,
                ..OrthographicProjection::default_3d()
            }),
            Transform::from_xyz(0.0, 20.0, 8.0).looking_at(Vec3::ZERO, Vec3::Y),
        ))
        .id();
    harness.start();
    assert_shadow(&harness, harness.camera, &harness.target, "first camera");
    assert_shadow(&harness, second, &second_target, "orthographic camera");
}

/// A glass pane over the shadow's edge: it has no shadow result of its own and takes the fallback map.
#[test]
fn transparent_receivers_take_the_fallback_map() {
    let mut harness = Harness::new(SIZE, eye());
    ground_and_slab(&mut harness);
    let glass = harness.material(StandardMaterial {
        base_color: Color::srgba(0.9, 0.9, 0.9, 0.9),
        alpha_mode: AlphaMode::Blend,
        ..default()
    });
    let pane = harness.mesh(Plane3d::default().mesh().size(8.0, 2.0));
    // Half a metre over the ground, where the slab's shadow has moved a little.
    harness
        .app
        .world_mut()
        .spawn((Mesh3d(pane), MeshMaterial3d(glass), Transform::from_xyz(0.0, 0.5, 0.0)));
    harness.sun(LIGHT, settings("zp4+lispsm:size=512"));
    harness.start();
    let over = |x: f32| brightness(&harness, harness.camera, &harness.target, Vec3::new(x, 0.5, 0.0));
    let (dark, bright) = (over(-1.9), over(2.5));
    assert!(
        dark < 0.7 * bright,
        "{dark} on the pane in the shadow against {bright} beside it"
    );
}

/// A glass pane with a layer: its shadow result is that of an opaque pane in its place, by every kind of maps, and reaches the
/// picture without a fallback map.
#[test]
fn transparent_receivers_have_a_layer() {
    for technique in [
        "zp4+lispsm:size=512",
        "tiled:n=4,tile=128",
        "queried:max=8,tile=128,tile_max=256",
        "fitted:n=8,tile_max=256",
        "fitted:slices=2,n=8,tile_max=256",
    ] {
        let mut harness = Harness::new(SIZE, eye());
        ground_and_slab(&mut harness);
        let of = |alpha_mode| StandardMaterial {
            base_color: Color::srgba(0.9, 0.9, 0.9, 0.9),
            alpha_mode,
            ..default()
        };
        let (board, glass) = (
            harness.material(of(AlphaMode::Opaque)),
            harness.material(of(AlphaMode::Blend)),
        );
        let mesh = harness.mesh(Plane3d::default().mesh().size(8.0, 6.0));
        let place = Transform::from_xyz(0.0, 0.5, 0.0);
        let pane = (Mesh3d(mesh), MeshMaterial3d(board), place, NotShadowCaster);
        let pane = harness.app.world_mut().spawn(pane).id();
        let keys = "transparent_layer=nearest,fallback=off";
        let separator = if technique.contains(':') { "," } else { ":" };
        harness.sun(LIGHT, settings(&format!("{technique}{separator}{keys}")));
        harness.start();
        let camera = harness.camera;
        let expected = harness.shadow_result(camera);
        let has_layer = |harness: &Harness| {
            let entity = harness
                .app
                .world()
                .get::<RenderEntity>(camera)
                .expect("it is drawn")
                .id();
            let render_world = harness.app.sub_app(RenderApp).world();
            render_world.get::<TransparentSurfaces>(entity).is_some()
        };
        assert!(!has_layer(&harness), "{technique}: nothing is transparent");

        harness.app.world_mut().entity_mut(pane).insert(MeshMaterial3d(glass));
        harness.frames(WARM_UP);
        assert_pipelines_compiled(&harness);
        let depths = harness.camera_texture::<TransparentSurfaces>(camera, |surfaces| &surfaces.layers[0].depth.0);
        let found =
            results(&harness.camera_texture::<TransparentSurfaces>(camera, |surfaces| &surfaces.layers[0].result.0));
        let behind = harness.shadow_result(camera);
        let (mut pixels, mut dark, mut off, mut through) = (0, 0, 0, 0);
        let surfaces = depths.to_f32().into_iter().zip(found);
        for ((depth, found), (expected, behind)) in surfaces.zip(expected.iter().zip(&behind)) {
            if depth > 0.0 {
                pixels += 1;
                dark += usize::from(*expected < 0.5);
                off += usize::from((found - expected).abs() > 0.02);
                through += usize::from((behind - expected).abs() > 0.02);
            }
        }
        println!("{technique}: {pixels} pixels of glass, {dark} in shadow, {off} off; through it {through}");
        assert!(
            pixels > 300 && dark > 60,
            "{technique}: {pixels} pixels, {dark} in shadow"
        );
        // Planes come from depths alone, those of the board from its normals too: pixels at its rim.
        assert!(off * 100 <= pixels, "{technique}: {off} of {pixels} pixels are off");
        assert!(
            through > 10 * off.max(1),
            "{technique}: what is behind has another shadow"
        );
        let over = |x: f32| brightness(&harness, camera, &harness.target, Vec3::new(x, 0.5, 0.0));
        let (dark, bright) = (over(-1.9), over(2.5));
        assert!(
            dark < 0.7 * bright,
            "{technique}: {dark} in the shadow against {bright}"
        );
    }
}

/// A second map of the whole scene is drawn in frames with a surface that reads it, and in no others.
#[test]
fn the_fallback_map_is_drawn_only_for_transparent_surfaces() {
    let mut harness = Harness::new(SIZE, eye());
    ground_and_slab(&mut harness);
    harness.sun(LIGHT, settings("lispsm:size=256"));
    harness.start();
    let maps = |harness: &mut Harness| {
        let world = harness.app.sub_app_mut(RenderApp).world_mut();
        // Cascade 1 is the layer that carries the shadow result.
        let is_fallback = |view: &&ShadowView| view.pass_name.ends_with("cascade_0");
        world.query::<&ShadowView>().iter(world).filter(is_fallback).count()
    };
    assert_eq!(maps(&mut harness), 0, "maps of Bevy's without glass");
    let glass = harness.material(StandardMaterial {
        base_color: Color::srgba(0.9, 0.9, 0.9, 0.9),
        alpha_mode: AlphaMode::Blend,
        ..default()
    });
    let pane = harness.mesh(Plane3d::default().mesh().size(8.0, 2.0));
    let pane = harness
        .app
        .world_mut()
        .spawn((Mesh3d(pane), MeshMaterial3d(glass)))
        .id();
    harness.frames(WARM_UP);
    assert_eq!(maps(&mut harness), 1, "maps of Bevy's with glass");
    harness.app.world_mut().despawn(pane);
    harness.frames(WARM_UP);
    assert_eq!(maps(&mut harness), 0, "maps of Bevy's once the glass is gone");
}

/// A sun whose settings change while running: each change shows in the next frames.
#[test]
fn techniques_switch_while_running() {
    let mut harness = Harness::new(SIZE, eye());
    ground_and_slab(&mut harness);
    let sun = harness.sun(LIGHT, settings("lispsm:size=512"));
    harness.start();
    for technique in [
        "zp4:size=256",
        "zp2+lispsm:size=512,path=dropin",
        "zp16+lispsm:size=128",
        "uniform:size=512",
    ] {
        harness.app.world_mut().entity_mut(sun).insert(settings(technique));
        harness.frames(WARM_UP);
        assert_shadow(&harness, harness.camera, &harness.target, technique);
    }
    harness.app.world_mut().entity_mut(sun).remove::<SunShadows>();
    harness.frames(WARM_UP);
    assert_shadow(&harness, harness.camera, &harness.target, "Bevy's own cascades");
}

/// Nothing to see, nothing to cast: everything is lit and nothing fails.
#[test]
fn an_empty_scene_is_lit() {
    let mut harness = Harness::new(SIZE, eye());
    harness.sun(LIGHT, settings("zp4+lispsm:size=256"));
    harness.start();
    harness.frames(2);
    assert_pipelines_compiled(&harness);
}

/// A multisampled camera keeps the fallback map; the scene is neither black nor unshadowed.
#[test]
fn multisampled_cameras_keep_the_fallback_map() {
    let mut harness = Harness::new(SIZE, eye());
    ground_and_slab(&mut harness);
    let mut camera = harness.app.world_mut().entity_mut(harness.camera);
    camera.remove::<DepthPrepass>().insert(Msaa::Sample4);
    harness.sun(LIGHT, settings("zp4+lispsm:size=512"));
    harness.start();
    assert_pipelines_compiled(&harness);
    assert_shadow(&harness, harness.camera, &harness.target, "multisampled camera");
}

/// A sheet like a leaf between camera and sun: light shines through it, but not in the shadow of a slab behind it.
#[test]
fn light_falls_through_a_thin_sheet_but_not_through_a_shadow() {
    for technique in ["zp4+lispsm:size=512", "uniform:size=1024,path=dropin"] {
        let mut harness = Harness::new(SIZE, eye());
        let sheet = harness.mesh(Rectangle::new(8.0, 6.0));
        let leaf = harness.material(StandardMaterial {
            base_color: Color::srgb(0.8, 0.8, 0.8),
            diffuse_transmission: 0.8,
            cull_mode: None,
            ..default()
        });
        let slab = harness.mesh(Cuboid::new(2.0, 2.0, 0.2));
        let stone = harness.material(Color::srgb(0.6, 0.6, 0.6));
        let world = harness.app.world_mut();
        world.spawn((
            Mesh3d(sheet),
            MeshMaterial3d(leaf),
            Transform::from_xyz(0.0, 2.0, 0.0),
            TransmittedShadowReceiver,
        ));
        world.spawn((
            Mesh3d(slab),
            MeshMaterial3d(stone),
            Transform::from_xyz(1.125, 3.0, -3.0),
        ));
        world.insert_resource(GlobalAmbientLight {
            brightness: 100.0,
            ..default()
        });
        harness.sun(Vec3::new(-0.3, -0.4, 0.8), settings(technique));
        harness.start();
        let [dark, bright] =
            [0.0, 3.0].map(|x| brightness(&harness, harness.camera, &harness.target, Vec3::new(x, 1.5, 0.0)));
        assert!(bright > 60.0, "{technique}: {bright} where the sun shines through");
        assert!(
            dark < 0.6 * bright,
            "{technique}: {dark} in the slab's shadow against {bright} beside it"
        );
    }
}
