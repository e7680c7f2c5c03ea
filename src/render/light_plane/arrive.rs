//! From the GPU back to the cameras of the main world.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::{
    prelude::*,
    render::render_resource::{ShaderType, encase},
};

use super::prepare::BlockBuffers;
use crate::{
    maths::light_plane::space::{BlockPlane, SeenBlock, SeenPicture},
    render::gpu_types::{BlockGrid, GpuSeenBlock},
    shadow::light_plane::{SeenSurfaces, SurfaceSampling},
};

/// Pictures that have come back from the GPU, with their cameras in the main world; shared by both worlds.
#[derive(Resource, Clone, Default)]
pub(super) struct ArrivedPictures(Arc<Mutex<Vec<(Entity, SeenSurfaces)>>>);

impl ArrivedPictures {
    fn push(&self, camera: Entity, surfaces: SeenSurfaces) {
        // A list of values is whole whatever its last writer did.
        let mut list = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        list.push((camera, surfaces));
    }

    fn take(&self) -> Vec<(Entity, SeenSurfaces)> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Maps the copies of the frame just submitted; their pictures arrive when the GPU has made them.
pub(super) fn map_blocks(mut cameras: Query<&mut BlockBuffers>, arrived: Res<ArrivedPictures>) {
    for mut buffers in &mut cameras {
        let (arrived, camera) = (arrived.clone(), buffers.camera);
        let (grid, clip_from_world) = (*buffers.grid.get(), buffers.clip_from_world);
        buffers.read_backs.map(move |bytes| {
            let picture = picture(bytes, grid, clip_from_world);
            arrived.push(camera, SeenSurfaces { picture });
        });
    }
}

/// The picture that the bytes of a buffer of [`GpuSeenBlock`]s hold.
fn picture(bytes: &[u8], grid: BlockGrid, clip_from_world: Mat4) -> SeenPicture {
    let stride = GpuSeenBlock::min_size().get() as usize;
    let blocks = bytes.chunks_exact(stride).map(|bytes| {
        let mut block = GpuSeenBlock::default();
        encase::StorageBuffer::new(bytes).read(&mut block).ok()?;
        seen_block(&block)
    });
    SeenPicture {
        clip_from_world: clip_from_world.as_dmat4(),
        size: grid.picture_size,
        grid: grid.block_count,
        blocks: blocks.collect(),
    }
}

fn seen_block(block: &GpuSeenBlock) -> Option<SeenBlock> {
    (block.pixel_count > 0).then(|| SeenBlock {
        position: block.position.as_dvec3(),
        normal: block.normal.as_dvec3(),
        depths_ndc: [block.nearest_ndc, block.farthest_ndc],
        pixel: block.pixel,
        pixels: block.pixel_count,
        plane: BlockPlane {
            depth_ndc: block.plane_ndc,
            slope: block.slope,
            offsets: block.offsets.to_array(),
        },
    })
}

/// Gives cameras what has arrived, the latest last.
pub(super) fn receive_pictures(
    mut commands: Commands,
    arrived: Res<ArrivedPictures>,
    sampled: Query<(), With<SurfaceSampling>>,
) {
    for (camera, surfaces) in arrived.take() {
        if sampled.contains(camera) {
            commands.entity(camera).insert(surfaces);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_blocks() {
        let block = GpuSeenBlock {
            position: Vec3::new(1.0, 2.0, 3.0),
            nearest_ndc: 0.5,
            normal: Vec3::Y,
            farthest_ndc: 0.25,
            pixel: UVec2::new(7, 9),
            pixel_count: 12,
            plane_ndc: 0.375,
            slope: Vec2::new(0.5, 0.125),
            offsets: Vec2::new(-0.25, 1.0),
        };
        let mut buffer = encase::StorageBuffer::new(Vec::new());
        buffer.write(&[block, GpuSeenBlock::default()]).expect("a vector grows");
        let grid = BlockGrid {
            picture_size: UVec2::new(64, 32),
            block_count: UVec2::new(2, 1),
            ..default()
        };
        let picture = picture(&buffer.into_inner(), grid, Mat4::IDENTITY);
        assert_eq!(picture.blocks.len(), 2);
        assert_eq!(picture.blocks[1], None, "only sky");
        let seen = picture.blocks[0].expect("a surface");
        assert_eq!(
            (seen.depths_ndc, seen.pixels, seen.pixel),
            ([0.5, 0.25], 12, UVec2::new(7, 9))
        );
        assert_eq!((seen.plane.depth_ndc, seen.plane.offsets), (0.375, [-0.25, 1.0]));
        assert_eq!((picture.size, picture.grid), (UVec2::new(64, 32), UVec2::new(2, 1)));
    }
}
