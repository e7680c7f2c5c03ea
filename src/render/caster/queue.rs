//! Queues casters into the phase, following Bevy's own shadow queue.

use bevy::{
    pbr::{
        PreparedMaterial, RenderMaterialInstances, RenderMeshInstanceFlags, RenderMeshInstances, ShadowBatchSetKey,
        ShadowBinKey, ShadowsDepthOnlyDrawFunction, SpecializedShadowMaterialPipelineCache,
    },
    prelude::*,
    render::{
        camera::{DirtySpecializations, PendingQueues},
        erased_render_asset::ErasedRenderAssets,
        mesh::allocator::MeshAllocator,
        render_phase::{BinnedRenderPhaseType, DrawFunctions, ViewBinnedRenderPhases},
        view::RenderShadowMapVisibleEntities,
    },
};

use super::{
    phase::{Caster, DrawCaster, DrawCasterDepthOnly},
    prepare::CasterViews,
};

/// Casters whose pipeline or material was not ready in the last frame.
#[derive(Resource, Default)]
pub struct PendingCasters(PendingQueues);

/// Adds and removes the casters that changed since the last frame.
pub fn queue_casters(
    cameras: Query<&CasterViews>,
    mut phases: ResMut<ViewBinnedRenderPhases<Caster>>,
    pipelines: Res<SpecializedShadowMaterialPipelineCache>,
    visible: Query<&RenderShadowMapVisibleEntities>,
    dirty: Res<DirtySpecializations>,
    mut pending: ResMut<PendingCasters>,
    instances: Res<RenderMeshInstances>,
    material_instances: Res<RenderMaterialInstances>,
    materials: Res<ErasedRenderAssets<PreparedMaterial>>,
    allocator: Res<MeshAllocator>,
    draw_functions: Res<DrawFunctions<Caster>>,
) {
    let draw_functions = draw_functions.read();
    let (Some(draw), Some(draw_depth_only)) = (
        draw_functions.get_id::<DrawCaster>(),
        draw_functions.get_id::<DrawCasterDepthOnly>(),
    ) else {
        return;
    };
    for views in &cameras {
        let cascade = views.retained_cascade;
        let Some(phase) = phases.get_mut(&views.retained_master) else {
            continue;
        };
        let Some(view_pipelines) = pipelines.get(&cascade) else {
            continue;
        };
        let Some(visible) = visible
            .get(views.light)
            .ok()
            .and_then(|visible| visible.subviews.get(&cascade))
            .and_then(|visible| visible.get::<Mesh3d>())
        else {
            continue;
        };
        let pending = pending.0.prepare_for_new_frame(views.retained_master);
        for &main_entity in dirty.iter_to_dequeue(cascade, visible) {
            phase.remove(main_entity);
        }
        let candidates: Vec<_> = if views.fresh {
            visible.iter_visible().map(|(render, main)| (*render, *main)).collect()
        } else {
            dirty
                .iter_to_queue(cascade, visible, &pending.prev_frame)
                .map(|(render, main)| (*render, *main))
                .collect()
        };
        for (render_entity, main_entity) in candidates {
            let Some(instance) = instances.render_mesh_queue_data(main_entity) else {
                pending.current_frame.insert((render_entity, main_entity));
                continue;
            };
            if !instance.flags().contains(RenderMeshInstanceFlags::SHADOW_CASTER) {
                continue;
            }
            let Some(material) = material_instances
                .instances
                .get(&main_entity)
                .and_then(|instance| materials.get(instance.asset_id))
            else {
                pending.current_frame.insert((render_entity, main_entity));
                continue;
            };
            if !material.properties.shadows_enabled {
                continue;
            }
            let Some(&(pipeline, bevy_draw)) = view_pipelines.get(&main_entity) else {
                pending.current_frame.insert((render_entity, main_entity));
                continue;
            };
            let Some(slabs) = allocator.mesh_slabs(&instance.mesh_asset_id()) else {
                continue;
            };
            let depth_only = Some(bevy_draw) == material.properties.get_draw_function(ShadowsDepthOnlyDrawFunction);
            phase.add(
                ShadowBatchSetKey {
                    pipeline,
                    draw_function: if depth_only { draw_depth_only } else { draw },
                    material_bind_group_index: (!depth_only).then_some(material.binding.group.0),
                    slabs,
                },
                ShadowBinKey {
                    asset_id: instance.mesh_asset_id().into(),
                },
                (Entity::PLACEHOLDER, main_entity),
                instance.current_uniform_index,
                if instance.should_batch() {
                    BinnedRenderPhaseType::BatchableMesh
                } else {
                    BinnedRenderPhaseType::UnbatchableMesh
                },
            );
        }
    }
}
