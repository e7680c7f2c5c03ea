//! Bit for bit: the caster phase against Bevy's own shadow phase, and culling on against off.

use std::sync::Mutex;

use bevy::{
    core_pipeline::schedule::Core3d,
    light::NotShadowCaster,
    mesh::{
        VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::Shadow,
    prelude::*,
    render::{
        RenderApp,
        render_phase::ViewBinnedRenderPhases,
        render_resource::{
            Extent3d, LoadOp, Operations, RenderPassDepthStencilAttachment, RenderPassDescriptor, StoreOp, Texture,
            TextureDescriptor, TextureDimension, TextureUsages, TextureViewDescriptor,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        sync_world::RenderEntity,
    },
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use umbrage::{
    prelude::*,
    render::{
        SunShadowPasses,
        atlas::{ATLAS_FORMAT, ShadowAtlas},
        capture,
        caster::{CasterCulling, pass::draw_casters, plan::CasterPlan, prepare::CasterViews},
    },
};

use crate::harness::{Harness, eye};

/// Bevy's shadow phase, drawn with our matrices into a texture of our own.
#[derive(Resource, Default)]
struct Reference(Mutex<Option<Texture>>);

fn draw_reference(
    world: &World,
    view: ViewQuery<(&CasterViews, &ShadowAtlas)>,
    phases: Res<ViewBinnedRenderPhases<Shadow>>,
    device: Res<RenderDevice>,
    reference: Res<Reference>,
    mut ctx: RenderContext,
) {
    let (views, atlas) = view.into_inner();
    let Some(phase) = phases.get(&views.retained_cascade) else {
        return;
    };
    let mut texture = reference.0.lock().expect("one thread");
    let side = atlas.layout.side;
    let texture = texture.get_or_insert_with(|| {
        device.create_texture(&TextureDescriptor {
            label: Some("reference"),
            size: Extent3d {
                width: side,
                height: side,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: ATLAS_FORMAT,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    });
    let target = texture.create_view(&TextureViewDescriptor::default());
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("reference"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &target,
            depth_ops: Some(Operations {
                load: LoadOp::Clear(0.0),
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    for (index, light_view) in views.light_views.iter().enumerate() {
        let rect = atlas.rect(index);
        pass.set_viewport(rect.x as f32, rect.y as f32, rect.z as f32, rect.w as f32, 0.0, 1.0);
        pass.set_scissor_rect(rect.x, rect.y, rect.z, rect.w);
        phase.render(&mut pass, world, *light_view).expect("Bevy's phase draws");
    }
}

/// What casters are made of.
#[derive(Resource, Clone)]
struct Stock {
    meshes: [Handle<Mesh>; 3],
    materials: [Handle<StandardMaterial>; 3],
}

/// Ground, casters of three meshes and three materials (one with holes), and a skinned box.
pub(crate) fn scene(harness: &mut Harness, casters: usize) {
    let materials = [
        harness.material(Color::srgb(0.7, 0.3, 0.2)),
        harness.material(StandardMaterial {
            cull_mode: None,
            ..Color::srgb(0.2, 0.3, 0.7).into()
        }),
        harness.holes(),
    ];
    let meshes = [
        harness.mesh(Cuboid::new(0.4, 2.0, 0.4)),
        harness.mesh(Cone::new(0.7, 1.5).mesh().resolution(9)),
        harness.mesh(Rectangle::new(1.2, 1.8)),
    ];
    let plane = harness.mesh(Plane3d::default().mesh().size(80.0, 80.0));
    let stock = Stock { meshes, materials };
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let world = harness.app.world_mut();
    world.spawn((
        Mesh3d(plane),
        MeshMaterial3d(stock.materials[0].clone()),
        NotShadowCaster,
    ));
    for _ in 0..casters {
        let bundle = random_caster(&stock, &mut random);
        world.spawn(bundle);
    }
    skinned_box(world, &stock);
    world.insert_resource(stock);
}

fn random_caster(stock: &Stock, random: &mut ChaCha8Rng) -> (Mesh3d, MeshMaterial3d<StandardMaterial>, Transform) {
    let place = Vec3::new(
        random.random_range(-25.0..25.0),
        random.random_range(0.0..3.0),
        random.random_range(-60.0..12.0),
    );
    (
        Mesh3d(stock.meshes[random.random_range(0..3)].clone()),
        MeshMaterial3d(stock.materials[random.random_range(0..3)].clone()),
        Transform::from_translation(place)
            .with_rotation(Quat::from_rotation_y(random.random_range(0.0..6.0)))
            .with_scale(Vec3::splat(random.random_range(0.5..1.6))),
    )
}

/// A box whose upper half a joint pulls 3 m aside: its rest-pose bounds are wrong.
fn skinned_box(world: &mut World, stock: &Stock) {
    let mut mesh = Cuboid::new(1.0, 6.0, 1.0).mesh().build().translated_by(Vec3::Y * 3.0);
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("a cuboid has positions");
    };
    let joints: Vec<[u16; 4]> = positions.iter().map(|p| [u16::from(p[1] > 3.0), 0, 0, 0]).collect();
    let weights = vec![[1.0_f32, 0.0, 0.0, 0.0]; positions.len()];
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(vec![Mat4::IDENTITY, Mat4::IDENTITY]);
    let joints = vec![
        world.spawn(Transform::from_xyz(0.0, 0.0, 4.0)).id(),
        world.spawn(Transform::from_xyz(3.0, 0.0, 4.0)).id(),
    ];
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(stock.materials[0].clone()),
        SkinnedMesh {
            inverse_bindposes,
            joints,
        },
        Transform::default(),
    ));
}

/// One frame's worth of random spawns, despawns, moves, hidings and material switches.
fn mutate(world: &mut World, random: &mut ChaCha8Rng) {
    let stock = world.resource::<Stock>().clone();
    let mut query = world.query_filtered::<Entity, (With<Mesh3d>, Without<NotShadowCaster>, Without<SkinnedMesh>)>();
    let casters: Vec<Entity> = query.iter(world).collect();
    for entity in casters {
        let mut entity = world.entity_mut(entity);
        match random.random_range(0..20) {
            0 => entity.despawn(),
            1 | 2 => {
                if let Some(mut transform) = entity.get_mut::<Transform>() {
                    transform.translation += Vec3::new(random.random_range(-1.0..1.0), 0.3, 0.0);
                }
            }
            3 => {
                entity.insert(MeshMaterial3d(stock.materials[random.random_range(0..3)].clone()));
            }
            4 => {
                entity.insert(Visibility::Hidden);
            }
            5 => {
                entity.insert(Visibility::Inherited);
            }
            6 => {
                entity.insert(Mesh3d(stock.meshes[random.random_range(0..3)].clone()));
            }
            _ => {}
        }
    }
    for _ in 0..6 {
        let bundle = random_caster(&stock, random);
        world.spawn(bundle);
    }
}

fn started(technique: &str, casters: usize) -> Harness {
    let mut harness = Harness::new(UVec2::new(160, 90), eye());
    harness
        .app
        .sub_app_mut(RenderApp)
        .init_resource::<Reference>()
        .add_systems(
            Core3d,
            draw_reference.in_set(SunShadowPasses::DrawCasters).after(draw_casters),
        );
    let Ok(Technique::Umbrage(settings)) = technique.parse() else {
        panic!("{technique} is no technique of Umbrage");
    };
    harness.sun(Vec3::new(-0.5, -0.7, -0.3), settings);
    scene(&mut harness, casters);
    harness.start();
    harness
}

fn reference(harness: &Harness) -> capture::Texels {
    let render_world = harness.app.sub_app(RenderApp).world();
    let texture = render_world
        .resource::<Reference>()
        .0
        .lock()
        .expect("one thread")
        .clone()
        .expect("it was drawn");
    capture::read_texture(render_world, &texture, 0).expect("the reference can be read")
}

fn differing(a: &capture::Texels, b: &capture::Texels) -> usize {
    assert_eq!((a.width, a.height), (b.width, b.height), "sizes of the textures");
    a.to_f32()
        .iter()
        .zip(b.to_f32())
        .filter(|(a, b)| a.to_bits() != b.to_bits())
        .count()
}

#[test]
fn caster_phase_equals_bevys_shadow_phase_under_changes() {
    let mut harness = started("zp4+lispsm:size=256", 150);
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for frame in 0..8 {
        let atlas = harness.atlas();
        let drawn = atlas.to_f32().iter().filter(|depth| **depth > 0.0).count();
        assert!(drawn > 5_000, "frame {frame}: only {drawn} texels hold a caster");
        assert_eq!(
            differing(&atlas, &reference(&harness)),
            0,
            "frame {frame}: texels differ from Bevy's shadow phase"
        );
        mutate(harness.app.world_mut(), &mut random);
        harness.frames(1);
    }
}

#[test]
fn culling_changes_no_texel() {
    for technique in [
        "zp9+lispsm:size=128",
        "zp4:size=256",
        "lispsm:size=512",
        "zp16:size=128,split=uniform",
        "fp2+lispsm:size=128",
    ] {
        let mut harness = started(technique, 200);
        let culled = harness.atlas();
        let indirect = indirect_draws(&harness);
        harness.app.sub_app_mut(RenderApp).insert_resource(CasterCulling(false));
        harness.frames(1);
        assert_eq!(
            differing(&culled, &harness.atlas()),
            0,
            "{technique}: texels differ without culling"
        );
        let (drawn, all) = indirect;
        assert!(
            drawn > 0 && (drawn < all || technique.starts_with("lispsm")),
            "{technique}: {drawn} of {all} drawn"
        );
    }
}

/// Maps drawn in passes of their own hold what they hold when one pass draws all.
#[test]
fn shared_passes_change_no_texel() {
    for technique in [
        "zp4+lispsm:size=256",
        "fp2+lispsm:size=128",
        "zp2:size=256,store=second",
    ] {
        let shared = started(technique, 200);
        let each = started(&format!("{technique},passes=each"), 200);
        assert_eq!(
            differing(&shared.atlas(), &each.atlas()),
            0,
            "{technique}: texels differ"
        );
        assert!(shared.atlas().to_f32().iter().filter(|depth| **depth > 0.0).count() > 1000);
        let slots = |harness: &Harness| {
            let camera = harness
                .app
                .world()
                .get::<RenderEntity>(harness.camera)
                .expect("drawn")
                .id();
            let world = harness.app.sub_app(RenderApp).world();
            world.get::<CasterPlan>(camera).expect("a plan").slots
        };
        assert!(slots(&shared) > 1 && slots(&each) == 1, "{technique}");
    }
}

/// Draws that passed culling, and what would be drawn without it.
fn indirect_draws(harness: &Harness) -> (u32, u32) {
    use bevy::render::{render_resource::*, renderer::RenderQueue};
    let camera = harness
        .app
        .world()
        .get::<RenderEntity>(harness.camera)
        .expect("the camera is drawn")
        .id();
    let world = harness.app.sub_app(RenderApp).world();
    let plan = world.get::<CasterPlan>(camera).expect("there is a plan");
    let views = world
        .get::<CasterViews>(camera)
        .expect("there are views")
        .light_views
        .len() as u32;
    let (_, counts) = plan.indirect.as_ref().expect("culling is on");
    let device = world.resource::<RenderDevice>();
    let read = device.create_buffer(&BufferDescriptor {
        label: None,
        size: counts.size(),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(counts, 0, &read, 0, counts.size());
    world.resource::<RenderQueue>().submit([encoder.finish()]);
    read.slice(..)
        .map_async(MapMode::Read, |result| result.expect("the counts can be mapped"));
    device.poll(PollType::wait_indefinitely()).expect("the GPU answers");
    let drawn = read
        .slice(..)
        .get_mapped_range()
        .chunks_exact(4)
        .map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
        .sum();
    (
        drawn,
        views * plan.bins.iter().map(|bin| bin.instance_count).sum::<u32>(),
    )
}
