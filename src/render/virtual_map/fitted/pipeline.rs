//! The compute pipelines that measure needs.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId, ComputePipelineDescriptor,
            PipelineCache, ShaderStages,
            binding_types::{storage_buffer_read_only_sized, storage_buffer_sized, texture_depth_2d, uniform_buffer},
        },
        view::ViewUniform,
    },
    shader::ShaderDefVal,
};

use crate::render::shaders;

/// Invocations of one workgroup per axis.
pub const WORKGROUP_SIDE: u32 = 8;

/// What a pass writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeedPass {
    /// Cells and totals of every pixel.
    Collect,
    /// The same, and a histogram of every cell.
    CollectWithHistograms,
    /// A mapping map of numbers.
    Map,
    /// A mapping map of bytes.
    MapBytes,
}

/// All pipelines, by [`NeedPass`].
#[derive(Resource)]
pub struct NeedPipelines([NeedPipeline; 4]);

/// The pipeline of one pass.
pub struct NeedPipeline {
    /// Bindings 0 view, 1 depth, 3 parameters, and from 4 on what is written.
    pub layout: BindGroupLayoutDescriptor,
    /// In the pipeline cache.
    pub id: CachedComputePipelineId,
}

impl NeedPass {
    const ALL: [Self; 4] = [Self::Collect, Self::CollectWithHistograms, Self::Map, Self::MapBytes];

    /// Buffers that the pass writes, from binding 4 on.
    pub fn output_count(self) -> usize {
        match self {
            Self::Collect => 2,
            Self::CollectWithHistograms => 3,
            Self::Map | Self::MapBytes => 1,
        }
    }

    fn pipeline(self, cache: &PipelineCache, server: &AssetServer) -> NeedPipeline {
        let (file, entry_point, definition) = match self {
            Self::Collect => ("virtual_map/collect_needs.wgsl", "collect_needs", None),
            Self::CollectWithHistograms => ("virtual_map/collect_needs.wgsl", "collect_needs", Some("HISTOGRAM")),
            Self::Map => ("virtual_map/map_needs.wgsl", "map_needs", None),
            Self::MapBytes => ("virtual_map/map_needs.wgsl", "map_needs", Some("BYTES")),
        };
        let output = || storage_buffer_sized(false, None);
        let inputs = (
            (0, uniform_buffer::<ViewUniform>(true)),
            (1, texture_depth_2d()),
            (3, storage_buffer_read_only_sized(false, None)),
            (4, output()),
        );
        let stage = ShaderStages::COMPUTE;
        let mut entries = BindGroupLayoutEntries::with_indices(stage, inputs).to_vec();
        for binding in 5..4 + self.output_count() as u32 {
            entries.extend(BindGroupLayoutEntries::with_indices(stage, ((binding, output()),)).iter());
        }
        let layout = BindGroupLayoutDescriptor::new(entry_point, &entries);
        let id = cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label: Some(entry_point.into()),
            layout: vec![layout.clone()],
            shader: shaders::load(server, file),
            shader_defs: definition.map(ShaderDefVal::from).into_iter().collect(),
            entry_point: Some(entry_point.into()),
            ..default()
        });
        NeedPipeline { layout, id }
    }
}

impl NeedPipelines {
    /// The pipeline of a pass.
    pub fn of(&self, pass: NeedPass) -> &NeedPipeline {
        &self.0[pass as usize]
    }
}

/// Queues the pipelines for compilation.
pub fn init_need_pipelines(mut commands: Commands, cache: Res<PipelineCache>, server: Res<AssetServer>) {
    let pipelines = NeedPass::ALL.map(|pass| pass.pipeline(&cache, &server));
    commands.insert_resource(NeedPipelines(pipelines));
}
