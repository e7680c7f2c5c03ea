//! Draws the things of a transparent phase once more, with other pipelines.

use bevy::{
    core_pipeline::core_3d::Transparent3d,
    ecs::{
        query::ROQueryItem,
        system::{SystemParam, SystemParamItem},
    },
    pbr::DrawMaterial,
    prelude::*,
    render::{
        render_phase::{
            DrawFunctionId, DrawFunctions, PhaseItem, RenderCommand, RenderCommandResult, SortedRenderPhase,
            TrackedRenderPass,
        },
        render_resource::CachedRenderPipelineId,
    },
};

/// Draws nothing: Bevy's own pass leaves out what is drawn layer by layer.
pub(super) struct DrawInLayers;

impl<P: PhaseItem> RenderCommand<P> for DrawInLayers {
    type Param = ();
    type ViewQuery = ();
    type ItemQuery = ();

    fn render<'w>(
        _: &P,
        (): ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (): SystemParamItem<'w, '_, Self::Param>,
        _: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        RenderCommandResult::Success
    }
}

/// The draw functions of materials: Bevy's, and [`DrawInLayers`].
#[derive(SystemParam)]
pub(super) struct MaterialFunctions<'w> {
    functions: Res<'w, DrawFunctions<Transparent3d>>,
}

impl MaterialFunctions<'_> {
    pub(super) fn get(&self) -> Option<(DrawFunctionId, DrawFunctionId)> {
        let functions = self.functions.read();
        Some((functions.get_id::<DrawMaterial>()?, functions.get_id::<DrawInLayers>()?))
    }

    pub(super) fn all(&self) -> &DrawFunctions<Transparent3d> {
        &self.functions
    }
}

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
