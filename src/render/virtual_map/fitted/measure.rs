//! The pass that measures needs: what it reads, what it writes, and the grid that comes of it.

use bevy::{
    math::UVec2,
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntry, BindGroupLayout, Buffer, BufferDescriptor, BufferInitDescriptor, BufferUsages,
            CommandEncoder, ComputePassDescriptor, IntoBinding, PipelineCache, ShaderType, TextureView,
            encase::StorageBuffer,
        },
        renderer::RenderDevice,
        view::{ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    cells::{
        CELL_WORDS, HISTOGRAM_WORDS, TEXEL_WORDS, TOTALS_WORDS, byte_mapping_map, histograms, mapping_map, need_cells,
        totals, totals_of_map, words,
    },
    pipeline::{NeedPass, NeedPipelines, WORKGROUP_SIDE},
};
use crate::{
    maths::virtual_map::grid::{GridOptions, NeedGrid},
    render::gpu_types::{NeedParameters, NeedTotals},
    shadow::fitted::{FittedMaps, NeedMapping},
};

/// What one pass measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Which pass.
    pub pass: NeedPass,
    /// Texels of the mapping map; the picture's size without one.
    pub map_size: UVec2,
    /// Pixels of the picture.
    pub picture: UVec2,
    /// Cells per axis of the grid.
    pub cells: u32,
}

impl Measurement {
    /// For a picture and a grid of `cells` per axis, as the settings say.
    pub fn new(settings: &FittedMaps, picture: UVec2, cells: u32) -> Self {
        let (pass, map_size) = match settings.mapping {
            NeedMapping::Full if settings.discard > 0.0 => (NeedPass::CollectWithHistograms, picture),
            NeedMapping::Full => (NeedPass::Collect, picture),
            NeedMapping::Low { size, bytes } => {
                let pass = if bytes { NeedPass::MapBytes } else { NeedPass::Map };
                (pass, UVec2::splat(size).clamp(UVec2::ONE, picture))
            }
        };
        Self {
            pass,
            map_size,
            picture,
            cells,
        }
    }

    /// Bytes of the buffers that the pass writes.
    pub fn sizes(&self) -> Vec<u64> {
        let (cells, texels) = (
            self.cells as usize * self.cells as usize,
            self.map_size.element_product() as usize,
        );
        let words = match self.pass {
            NeedPass::Collect => vec![cells * CELL_WORDS, TOTALS_WORDS],
            NeedPass::CollectWithHistograms => vec![cells * CELL_WORDS, TOTALS_WORDS, cells * HISTOGRAM_WORDS],
            NeedPass::Map => vec![texels * TEXEL_WORDS],
            NeedPass::MapBytes => vec![texels],
        };
        words.into_iter().map(|words| 4 * words as u64).collect()
    }

    /// The grid and the counts from what the buffers hold. `None` for a grid that is not a power of two.
    pub fn grid(&self, contents: &[Vec<u8>], options: &GridOptions) -> Option<(NeedGrid, NeedTotals)> {
        let words: Vec<Vec<u32>> = contents.iter().map(|bytes| words(bytes)).collect();
        let piece = |index: usize| words.get(index).map_or(&[][..], Vec::as_slice);
        let map = match self.pass {
            NeedPass::Collect | NeedPass::CollectWithHistograms => {
                let cells = need_cells(piece(0));
                let grid = NeedGrid::collected(cells, &histograms(piece(2)), self.picture, options)?;
                return Some((grid, totals(piece(1))));
            }
            NeedPass::Map => mapping_map(piece(0), self.map_size, self.picture),
            NeedPass::MapBytes => byte_mapping_map(piece(0), self.map_size, self.picture),
        };
        // A texel stands for the pixels around it, of which the outer ones may look into another cell.
        let texel = (self.picture.as_vec2() / self.map_size.as_vec2()).max_element().ceil() as u32;
        let options = GridOptions {
            rect_guard: options.rect_guard.max(texel),
            ..*options
        };
        Some((NeedGrid::new(&map, &options), totals_of_map(&map)))
    }
}

/// On a camera's render entity: buffers of the passes, by z-partition.
#[derive(Component, Clone, Debug)]
pub struct NeedBuffers(pub Vec<PassBuffers>);

impl NeedBuffers {
    /// Buffers of these sizes, by pass.
    pub fn new(device: &RenderDevice, sizes: &[Vec<u64>]) -> Self {
        Self(sizes.iter().map(|sizes| PassBuffers::new(device, sizes)).collect())
    }

    /// Whether they have these sizes.
    pub fn is_for(&self, sizes: &[Vec<u64>]) -> bool {
        self.0.len() == sizes.len() && self.0.iter().zip(sizes).all(|(buffers, sizes)| buffers.is_for(sizes))
    }

    /// What all passes write.
    pub fn outputs(&self) -> Vec<Buffer> {
        self.0
            .iter()
            .flat_map(|buffers| buffers.outputs.iter().cloned())
            .collect()
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(PassBuffers::bytes).sum()
    }
}

/// What one pass reads and writes.
#[derive(Clone, Debug)]
pub struct PassBuffers {
    /// What the pass reads: `NeedParameters`.
    pub parameters: Buffer,
    /// In the order of the bindings from 4 on.
    pub outputs: Vec<Buffer>,
}

impl PassBuffers {
    /// Buffers of these sizes.
    fn new(device: &RenderDevice, sizes: &[u64]) -> Self {
        let create = |label, size, usage| {
            device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        Self {
            parameters: create(
                "umbrage_need_parameters",
                NeedParameters::min_size().get(),
                BufferUsages::STORAGE | BufferUsages::COPY_DST,
            ),
            outputs: sizes.iter().map(|size| create("umbrage_needs", *size, usage)).collect(),
        }
    }

    fn is_for(&self, sizes: &[u64]) -> bool {
        self.outputs
            .iter()
            .map(|buffer| buffer.size())
            .eq(sizes.iter().copied())
    }

    fn bytes(&self) -> u64 {
        self.parameters.size() + self.outputs.iter().map(|buffer| buffer.size()).sum::<u64>()
    }
}

/// Records the pass for pictures of a camera, given by their depths: the needs of all of them are collected together. False
/// while the pipeline or a picture is missing.
pub fn record(
    world: &World,
    camera: Entity,
    depths: &[&TextureView],
    measurement: &Measurement,
    parameters: &NeedParameters,
    buffers: &PassBuffers,
    encoder: &mut CommandEncoder,
) -> bool {
    let (Some(pipelines), Some(cache), Some(device)) = (
        world.get_resource::<NeedPipelines>(),
        world.get_resource::<PipelineCache>(),
        world.get_resource::<RenderDevice>(),
    ) else {
        return false;
    };
    let pipeline = pipelines.of(measurement.pass);
    let layout = cache.get_bind_group_layout(&pipeline.layout);
    let bind_groups: Option<Vec<_>> = depths
        .iter()
        .map(|depth| bind_group(world, camera, depth, &layout, buffers))
        .collect();
    let (Some(compute), Some(bind_groups), false) =
        (cache.get_compute_pipeline(pipeline.id), bind_groups, depths.is_empty())
    else {
        return false;
    };
    let contents = storage_bytes(parameters);
    let upload = device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("umbrage_need_parameters_upload"),
        contents: &contents,
        usage: BufferUsages::COPY_SRC,
    });
    encoder.copy_buffer_to_buffer(&upload, 0, &buffers.parameters, 0, contents.len() as u64);
    for output in &buffers.outputs {
        encoder.clear_buffer(output, 0, None);
    }
    let groups = (measurement.map_size + WORKGROUP_SIDE - 1) / WORKGROUP_SIDE;
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some("umbrage_needs"),
        timestamp_writes: None,
    });
    pass.set_pipeline(compute);
    for (bind_group, offset) in &bind_groups {
        pass.set_bind_group(0, bind_group, &[*offset]);
        pass.dispatch_workgroups(groups.x, groups.y, 1);
    }
    true
}

fn bind_group(
    world: &World,
    camera: Entity,
    depth: &TextureView,
    layout: &BindGroupLayout,
    buffers: &PassBuffers,
) -> Option<(BindGroup, u32)> {
    let view = world.get_resource::<ViewUniforms>()?.uniforms.binding()?;
    let offset = world.get::<ViewUniformOffset>(camera)?.offset;
    let inputs = [
        (0, view),
        (1, depth.into_binding()),
        (3, buffers.parameters.as_entire_binding()),
    ];
    let outputs = (4..).zip(buffers.outputs.iter().map(|output| output.as_entire_binding()));
    let entries: Vec<BindGroupEntry> = (inputs.into_iter().chain(outputs))
        .map(|(binding, resource)| BindGroupEntry { binding, resource })
        .collect();
    let device = world.get_resource::<RenderDevice>()?;
    Some((device.create_bind_group("umbrage_needs", layout, &entries), offset))
}

fn storage_bytes(parameters: &NeedParameters) -> Vec<u8> {
    let mut buffer = StorageBuffer::new(Vec::new());
    // Writing into a vector cannot fail: it grows.
    let _ = buffer.write(parameters);
    buffer.into_inner()
}
