//! The phase item and its draw commands: Bevy's shadow bins, pipelines and bind groups, our draws.

use std::{ops::Range, sync::Mutex};

use bevy::{
    ecs::{
        query::ROQueryItem,
        system::{
            SystemParamItem,
            lifetimeless::{Read, SRes},
        },
    },
    pbr::{
        RenderMeshInstances, SetMaterialBindGroup, SetMeshBindGroup, SetPrepassEmptyMaterialBindGroup,
        SetPrepassViewBindGroup, ShadowBatchSetKey, ShadowBinKey,
    },
    prelude::*,
    render::{
        mesh::{RenderMesh, RenderMeshBufferInfo, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_phase::{
            BinnedPhaseItem, CachedRenderPipelinePhaseItem, DrawFunctionId, PhaseItem, PhaseItemExtraIndex,
            RenderCommand, RenderCommandResult, TrackedRenderPass,
        },
        render_resource::{Buffer, CachedRenderPipelineId},
        sync_world::MainEntity,
    },
};

use super::layers::{SetCasterLayerBindGroup, SetCasterPipeline};
use crate::render::gpu_types::CasterBin;

/// A caster in the phase that all light views of a camera share.
pub struct Caster {
    batch_set_key: ShadowBatchSetKey,
    representative: (Entity, MainEntity),
    batch_range: Range<u32>,
    extra_index: PhaseItemExtraIndex,
}

impl PhaseItem for Caster {
    fn entity(&self) -> Entity {
        self.representative.0
    }
    fn main_entity(&self) -> MainEntity {
        self.representative.1
    }
    fn draw_function(&self) -> DrawFunctionId {
        self.batch_set_key.draw_function
    }
    fn batch_range(&self) -> &Range<u32> {
        &self.batch_range
    }
    fn batch_range_mut(&mut self) -> &mut Range<u32> {
        &mut self.batch_range
    }
    fn extra_index(&self) -> PhaseItemExtraIndex {
        self.extra_index.clone()
    }
    fn batch_range_and_extra_index_mut(&mut self) -> (&mut Range<u32>, &mut PhaseItemExtraIndex) {
        (&mut self.batch_range, &mut self.extra_index)
    }
}

impl BinnedPhaseItem for Caster {
    type BatchSetKey = ShadowBatchSetKey;
    type BinKey = ShadowBinKey;
    fn new(
        batch_set_key: Self::BatchSetKey,
        _bin_key: Self::BinKey,
        representative: (Entity, MainEntity),
        batch_range: Range<u32>,
        extra_index: PhaseItemExtraIndex,
    ) -> Self {
        Self {
            batch_set_key,
            representative,
            batch_range,
            extra_index,
        }
    }
}

impl CachedRenderPipelinePhaseItem for Caster {
    fn cached_pipeline(&self) -> CachedRenderPipelineId {
        self.batch_set_key.pipeline
    }
}

/// On the master view: collects the bins of the phase during the dry run.
#[derive(Component, Default)]
pub struct CollectBins(pub Mutex<Vec<CollectedBin>>);

/// One bin as the dry run sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollectedBin {
    /// Entity whose mesh all instances share.
    pub representative: MainEntity,
    /// Geometry and instances; without bounds.
    pub bin: CasterBin,
    /// Whether the mesh has indices; without, it is drawn unculled.
    pub indexed: bool,
}

/// On the render view of a light view: where its indirect draws lie.
#[derive(Component, Clone, Debug)]
pub struct LightViewDraws {
    /// Index of the light view.
    pub index: u32,
    /// Instances of all bins: the stride of one light view in both buffers.
    pub instance_total: u32,
    /// Indirect draws and their counts; `None`: draw everything unculled.
    pub indirect: Option<(Buffer, Buffer)>,
}

/// Bytes of one indexed indirect draw.
pub const DRAW_BYTES: u64 = 20;

/// Draws a bin's instances: all of them, or those that the compute pass found in the light view.
pub struct DrawCasterMesh;

impl<P: PhaseItem> RenderCommand<P> for DrawCasterMesh {
    type Param = (
        SRes<RenderAssets<RenderMesh>>,
        SRes<RenderMeshInstances>,
        SRes<MeshAllocator>,
    );
    type ViewQuery = (Option<Read<CollectBins>>, Option<Read<LightViewDraws>>);
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        (collect, draws): ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (meshes, instances, allocator): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let (meshes, instances, allocator) = (meshes.into_inner(), instances.into_inner(), allocator.into_inner());
        let Some(mesh_id) = instances.mesh_asset_id(item.main_entity()) else {
            return RenderCommandResult::Skip;
        };
        let (Some(mesh), Some(vertices)) = (meshes.get(mesh_id), allocator.mesh_vertex_slice(&mesh_id)) else {
            return RenderCommandResult::Skip;
        };
        let range = item.batch_range();
        let mut bin = CasterBin {
            first_instance: range.start,
            instance_count: range.len() as u32,
            base_vertex: vertices.range.start,
            ..default()
        };
        let index_slice = match mesh.buffer_info {
            RenderMeshBufferInfo::Indexed { index_format, count } => {
                let Some(indices) = allocator.mesh_index_slice(&mesh_id) else {
                    return RenderCommandResult::Skip;
                };
                bin.first_index = indices.range.start;
                bin.index_count = count;
                Some((indices, index_format))
            }
            RenderMeshBufferInfo::NonIndexed => None,
        };
        if let Some(collect) = collect {
            if let Ok(mut bins) = collect.0.lock() {
                bins.push(CollectedBin {
                    representative: item.main_entity(),
                    bin,
                    indexed: index_slice.is_some(),
                });
            }
            return RenderCommandResult::Skip;
        }
        let Some(draws) = draws else {
            return RenderCommandResult::Skip;
        };
        pass.set_vertex_buffer(0, vertices.buffer.slice(..));
        let Some((indices, index_format)) = index_slice else {
            pass.draw(vertices.range, range.clone());
            return RenderCommandResult::Success;
        };
        pass.set_index_buffer(indices.buffer.slice(..), index_format);
        let Some((arguments, counts)) = &draws.indirect else {
            let index_range = bin.first_index..bin.first_index + bin.index_count;
            pass.draw_indexed(index_range, bin.base_vertex as i32, range.clone());
            return RenderCommandResult::Success;
        };
        // The bin was not in this frame's plan: nothing was culled for it.
        if range.end > draws.instance_total {
            return RenderCommandResult::Skip;
        }
        let slot = u64::from(draws.index) * u64::from(draws.instance_total) + u64::from(range.start);
        pass.multi_draw_indexed_indirect_count(arguments, slot * DRAW_BYTES, counts, slot * 4, bin.instance_count);
        RenderCommandResult::Success
    }
}

/// Casters whose fragments the material decides (alpha mask).
pub type DrawCaster = (
    SetCasterPipeline,
    SetPrepassViewBindGroup<0>,
    SetCasterLayerBindGroup,
    SetMeshBindGroup<2>,
    SetMaterialBindGroup<3>,
    DrawCasterMesh,
);

/// Opaque casters: no material is bound.
pub type DrawCasterDepthOnly = (
    SetCasterPipeline,
    SetPrepassViewBindGroup<0>,
    SetCasterLayerBindGroup,
    SetMeshBindGroup<2>,
    SetPrepassEmptyMaterialBindGroup<3>,
    DrawCasterMesh,
);
