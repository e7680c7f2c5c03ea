//! Lists the bins of the phase and sizes the buffers of the indirect draws.
//!
//! Bevy keeps the batches of a binned phase to itself: only drawing the phase shows them. So the phase is drawn once
//! into a render pass that is never submitted, with a draw command that writes down what it is asked to draw.

use std::collections::HashMap;

use bevy::{
    pbr::RenderMeshInstances,
    prelude::*,
    render::{
        render_phase::{TrackedRenderPass, ViewBinnedRenderPhases},
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor, LoadOp, Operations,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, StoreOp, WgpuFeatures,
        },
        renderer::{CurrentView, RenderDevice},
    },
};

use super::{
    CasterCounts, CasterCulling, CasterStatistics,
    bounds::{LocalBounds, MeshBounds},
    layers::prepare_layers,
    phase::{Caster, CollectBins, CollectedBin, DRAW_BYTES, LightViewDraws},
    prepare::CasterViews,
};
use crate::{
    render::{atlas::ShadowAtlas, extract::ExtractedSun, gpu_types::CasterBin},
    shadow::settings::CasterPasses,
};

/// On a camera's render entity: the bins of this frame and the buffers of their draws.
#[derive(Component, Clone, Debug, Default)]
pub struct CasterPlan {
    /// Sorted by first instance.
    pub bins: Vec<CasterBin>,
    /// One past the last instance of any bin.
    pub instance_total: u32,
    /// Indirect draws and counts; `None` when nothing is culled.
    pub indirect: Option<(Buffer, Buffer)>,
    /// Casters drawn by light view of the frame, or by tile of a virtual map; with [`indirect`](Self::indirect) only.
    pub drawn: Option<Buffer>,
    /// Slots of the draw buffers: light views that can be culled and drawn together. Virtual maps have more tiles.
    pub slots: u32,
}

/// Plans the caster pass of the current camera.
pub fn plan_casters(world: &mut World) {
    let Some(camera) = world.get_resource::<CurrentView>().map(|view| view.0) else {
        return;
    };
    let Some(views) = world.get::<CasterViews>(camera).cloned() else {
        return;
    };
    let collected = dry_run(world, camera, &views);
    let bins = bins_with_bounds(world, &collected);
    let instance_total = bins
        .iter()
        .map(|bin| bin.first_instance + bin.instance_count)
        .max()
        .unwrap_or(0);
    let light_view_count = views.light_views.len() as u32;
    let settings = world.get::<ExtractedSun>(camera).map(|sun| &sun.settings);
    let is_virtual = settings.is_some_and(|settings| settings.maps.is_virtual());
    let is_apart = !is_virtual && settings.is_some_and(|settings| settings.caster_passes == CasterPasses::PerMap);

    let device = world.resource::<RenderDevice>();
    // Light views of an atlas are drawn in one pass, or each in its own; tiles may as well be drawn a few at a time.
    let slots = if is_apart {
        light_view_count.min(1)
    } else if is_virtual {
        (1..=light_view_count)
            .rev()
            .find(|slots| fits(device, u64::from(instance_total) * u64::from(*slots)))
            .unwrap_or(light_view_count.min(1))
    } else {
        light_view_count
    };
    let cull = world.resource::<CasterCulling>().0
        && device
            .features()
            .contains(WgpuFeatures::MULTI_DRAW_INDIRECT_COUNT | WgpuFeatures::INDIRECT_FIRST_INSTANCE)
        && instance_total > 0
        && slots > 0
        && fits(device, u64::from(instance_total) * u64::from(slots));
    let old = world.get::<CasterPlan>(camera);
    let old_drawn = old.and_then(|plan| plan.drawn.clone());
    let old = old.and_then(|plan| plan.indirect.clone());
    let indirect = cull.then(|| sized_buffers(device, old, u64::from(instance_total) * u64::from(slots)));
    let drawn = cull.then(|| old_drawn.unwrap_or_else(|| counters(device)));

    let buffer_bytes = indirect
        .as_ref()
        .map_or(0, |(arguments, counts)| arguments.size() + counts.size());
    world.resource_mut::<CasterStatistics>().0.insert(
        camera,
        CasterCounts {
            light_views: light_view_count,
            bins: bins.len() as u32,
            casters: bins.iter().map(|bin| bin.instance_count).sum(),
            buffer_bytes,
        },
    );
    for light_views in [&views.light_views, &views.second_views, &views.fading_views] {
        for (index, light_view) in light_views.iter().enumerate() {
            world.entity_mut(*light_view).insert(LightViewDraws {
                index: if is_apart { 0 } else { index as u32 },
                instance_total,
                indirect: indirect.clone(),
            });
        }
    }
    if let Some(store) = world.get::<ExtractedSun>(camera).map(|sun| sun.settings.store) {
        prepare_layers(world, camera, &views, store);
    }
    world.entity_mut(camera).insert(CasterPlan {
        bins,
        instance_total,
        indirect,
        drawn,
        slots,
    });
}

/// Draws the phase into a pass that is thrown away, and returns the bins it would have drawn.
fn dry_run(world: &World, camera: Entity, views: &CasterViews) -> Vec<CollectedBin> {
    let (Some(atlas), Some(phase), Some(collect)) = (
        world.get::<ShadowAtlas>(camera),
        world
            .resource::<ViewBinnedRenderPhases<Caster>>()
            .get(&views.retained_master),
        world.get::<CollectBins>(views.master),
    ) else {
        return Vec::new();
    };
    let device = world.resource::<RenderDevice>();
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
        label: Some("umbrage_caster_dry_run"),
    });
    let pass = encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("umbrage_caster_dry_run"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &atlas.view,
            depth_ops: Some(Operations {
                load: LoadOp::Load,
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    let mut pass = TrackedRenderPass::new(device, pass);
    if let Err(error) = phase.render(&mut pass, world, views.master) {
        error!("the caster phase could not be listed: {error}");
    }
    drop(pass);
    collect
        .0
        .lock()
        .map(|mut bins| std::mem::take(&mut *bins))
        .unwrap_or_default()
}

/// Bins with their local bounds, sorted by first instance.
fn bins_with_bounds(world: &World, collected: &[CollectedBin]) -> Vec<CasterBin> {
    let instances = world.resource::<RenderMeshInstances>();
    let bounds = world.resource::<MeshBounds>();
    let mut known: HashMap<_, LocalBounds> = HashMap::new();
    let mut bins: Vec<CasterBin> = collected
        .iter()
        .filter(|collected| collected.indexed)
        .map(|collected| {
            let mut bin = collected.bin;
            let local = instances
                .mesh_asset_id(collected.representative)
                .map_or(LocalBounds::Unbounded, |mesh| {
                    *known.entry(mesh).or_insert_with(|| bounds.get(mesh))
                });
            match local {
                LocalBounds::Box { center, half_extents } => {
                    bin.center_local = center.extend(0.0);
                    bin.half_extents_local = half_extents.extend(0.0);
                }
                LocalBounds::Unbounded => bin.unbounded = 1,
            }
            bin
        })
        .collect();
    bins.sort_by_key(|bin| bin.first_instance);
    bins
}

/// Whether the device can bind buffers for that many draws; beyond it everything is drawn unculled.
fn fits(device: &RenderDevice, draws: u64) -> bool {
    with_room(draws) * DRAW_BYTES <= device.limits().max_storage_buffer_binding_size
}

/// Room to grow by half before the next allocation.
fn with_room(draws: u64) -> u64 {
    draws + draws / 2
}

/// Counters for the light views of a frame, or for the tiles of a virtual map: those beyond them share the last.
const COUNTERS: u64 = 4096;

fn counters(device: &RenderDevice) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: Some("umbrage_casters_drawn"),
        size: COUNTERS * 4,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// Buffers for one draw and one count per (light view, instance); old ones are kept while they are large enough.
fn sized_buffers(device: &RenderDevice, old: Option<(Buffer, Buffer)>, draws: u64) -> (Buffer, Buffer) {
    match old {
        Some((arguments, counts)) if arguments.size() >= draws * DRAW_BYTES && counts.size() >= draws * 4 => {
            (arguments, counts)
        }
        _ => {
            let draws = with_room(draws);
            let create = |label, size| {
                device.create_buffer(&BufferDescriptor {
                    label: Some(label),
                    size,
                    usage: BufferUsages::STORAGE
                        | BufferUsages::INDIRECT
                        | BufferUsages::COPY_DST
                        | BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                })
            };
            (
                create("umbrage_caster_draws", draws * DRAW_BYTES),
                create("umbrage_caster_counts", draws * 4),
            )
        }
    }
}
