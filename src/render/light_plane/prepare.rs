//! Buffers of the blocks, and where this frame is seen from.

use bevy::{
    prelude::*,
    render::{
        Extract,
        camera::ExtractedCamera,
        render_resource::{Buffer, BufferDescriptor, BufferUsages, ShaderType, StorageBuffer},
        renderer::{RenderDevice, RenderQueue},
        sync_world::{MainEntity, RenderEntity},
        view::ExtractedView,
    },
};

use super::SEE_BLOCKS;
use crate::{
    render::{
        gpu_types::{BlockGrid, GpuSeenBlock},
        read_back::ReadBacks,
    },
    shadow::light_plane::SurfaceSampling,
};

/// On a camera's render entity: it is sampled.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampledCamera(pub SurfaceSampling);

/// On a camera's render entity: its blocks.
#[derive(Component)]
pub(super) struct BlockBuffers {
    /// [`GpuSeenBlock`]s row by row.
    pub(super) blocks: Buffer,
    /// The division of this frame's picture.
    pub(super) grid: StorageBuffer<BlockGrid>,
    /// Copies on their way.
    pub(super) read_backs: ReadBacks,
    /// The camera in the main world.
    pub(super) camera: Entity,
    /// World to clip space of this frame.
    pub(super) clip_from_world: Mat4,
}

pub(super) fn extract_sampled_cameras(
    mut commands: Commands,
    cameras: Extract<Query<(&RenderEntity, Option<&SurfaceSampling>), With<Camera3d>>>,
    known: Query<&SampledCamera>,
) {
    for (camera, sampling) in &cameras {
        let camera = camera.id();
        match (sampling, known.get(camera).ok()) {
            (Some(sampling), known) if known != Some(&SampledCamera(*sampling)) => {
                commands.entity(camera).insert(SampledCamera(*sampling));
            }
            (None, Some(_)) => {
                commands.entity(camera).remove::<(SampledCamera, BlockBuffers)>();
            }
            _ => {}
        }
    }
}

/// Makes or keeps the buffers of every sampled camera, and notes where it stands.
pub(super) fn prepare_blocks(
    mut commands: Commands,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut cameras: Query<(
        Entity,
        &MainEntity,
        &SampledCamera,
        &ExtractedView,
        &ExtractedCamera,
        Option<&mut BlockBuffers>,
    )>,
) {
    for (entity, main_entity, sampled, view, camera, buffers) in &mut cameras {
        let Some(size) = camera.physical_viewport_size.filter(|size| size.min_element() > 0) else {
            continue;
        };
        let block_count = sampled.0.block_count();
        let grid = BlockGrid {
            origin: camera
                .viewport
                .as_ref()
                .map_or(UVec2::ZERO, |viewport| viewport.physical_position),
            picture_size: size,
            block_count,
            padding: UVec2::ZERO,
        };
        let clip_from_world = view
            .clip_from_world
            .unwrap_or_else(|| view.clip_from_view * view.world_from_view.to_matrix().inverse());
        match buffers {
            Some(mut buffers) if buffers.grid.get().block_count == block_count => {
                buffers.grid.set(grid);
                buffers.grid.write_buffer(&device, &queue);
                buffers.clip_from_world = clip_from_world;
            }
            _ => {
                let bytes = GpuSeenBlock::min_size().get() * u64::from(block_count.element_product());
                let mut grid = StorageBuffer::from(grid);
                grid.write_buffer(&device, &queue);
                commands.entity(entity).insert(BlockBuffers {
                    blocks: device.create_buffer(&BufferDescriptor {
                        label: Some(SEE_BLOCKS),
                        size: bytes,
                        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                        mapped_at_creation: false,
                    }),
                    grid,
                    read_backs: ReadBacks::new(&device, SEE_BLOCKS, bytes),
                    camera: main_entity.id(),
                    clip_from_world,
                });
            }
        }
    }
}
