//! Draws the things of a transparent phase once more, with other pipelines.

use bevy::{
    core_pipeline::core_3d::Transparent3d,
    prelude::*,
    render::{
        render_phase::{DrawFunctionId, DrawFunctions, PhaseItem, SortedRenderPhase, TrackedRenderPass},
        render_resource::CachedRenderPipelineId,
    },
};

/// Draws the items of a phase for which `variant` names a pipeline and a draw function, in the batches of Bevy's own pass:
/// an item stands for as many as its range holds.
pub(in crate::render) fn draw_variants<'w>(
    phase: &SortedRenderPhase<Transparent3d>,
    functions: &DrawFunctions<Transparent3d>,
    (world, view): (&'w World, Entity),
    pass: &mut TrackedRenderPass<'w>,
    variant: impl Fn(&Transparent3d) -> Option<(CachedRenderPipelineId, DrawFunctionId)>,
) {
    let mut functions = functions.write();
    functions.prepare(world);
    let mut index = 0;
    while let Some((_, item)) = phase.items.get_index(index) {
        index += item.batch_range().len().max(1);
        let (false, Some((pipeline, draw_function))) = (item.batch_range().is_empty(), variant(item)) else {
            continue;
        };
        let varied = Transparent3d {
            sorting_info: item.sorting_info,
            distance: item.distance,
            pipeline,
            entity: item.entity,
            draw_function,
            batch_range: item.batch_range.clone(),
            extra_index: item.extra_index.clone(),
            indexed: item.indexed,
        };
        if let Some(draw) = functions.get_mut(draw_function)
            && let Err(error) = draw.draw(world, pass, view, &varied)
        {
            error!("a transparent thing could not be drawn: {error}");
        }
    }
}
