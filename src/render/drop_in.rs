//! The drop-in path's part in the render world: the bias of casters, see [`shadow::drop_in`](crate::shadow::drop_in).
//!
//! Bevy draws a cascade and reads it with one matrix. This system gives the drawing side another one before the view
//! uniforms are written, so that casters lie a little deeper than receivers.

use bevy::{
    pbr::LightEntity,
    prelude::*,
    render::{
        Extract, ExtractSchedule, Render, RenderApp, RenderSystems,
        sync_world::{MainEntity, MainEntityHashMap},
        view::{ExtractedView, prepare_view_uniforms},
    },
};

use crate::shadow::{timing::SystemTimes, views::SunViews};

/// By light and camera (main world): [`LightView::caster_depth_bias`](crate::shadow::views::LightView) of every cascade.
#[derive(Resource, Default)]
struct CasterDepthBiases(MainEntityHashMap<MainEntityHashMap<Vec<f32>>>);

/// Moves the casters of drop-in suns away from the light.
pub struct DropInPlugin;

impl Plugin for DropInPlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<CasterDepthBiases>()
            .add_systems(ExtractSchedule, extract_caster_depth_biases)
            .add_systems(
                Render,
                times
                    .clock("bias_shadow_views", bias_shadow_views)
                    .in_set(RenderSystems::PrepareResources)
                    .before(prepare_view_uniforms),
            );
    }
}

fn extract_caster_depth_biases(mut biases: ResMut<CasterDepthBiases>, suns: Extract<Query<(Entity, &SunViews)>>) {
    biases.0.clear();
    for (sun, views) in &suns {
        let by_camera = views.cameras.iter().map(|(camera, views)| {
            let partitions = views.partitions.iter();
            let of_cascades = partitions.map(|partition| partition.light_view.caster_depth_bias);
            (MainEntity::from(*camera), of_cascades.collect())
        });
        biases.0.insert(MainEntity::from(sun), by_camera.collect());
    }
}

fn bias_shadow_views(biases: Res<CasterDepthBiases>, mut shadow_views: Query<&mut ExtractedView, With<LightEntity>>) {
    for mut view in &mut shadow_views {
        let id = view.retained_view_entity;
        let found = biases
            .0
            .get(&id.main_entity)
            .and_then(|by_camera| by_camera.get(&id.auxiliary_entity))
            .and_then(|of_cascades| of_cascades.get(id.subview_index as usize));
        if let (Some(bias), Some(clip_from_world)) = (found, view.clip_from_world)
            && *bias != 0.0
        {
            view.clip_from_world = Some(deeper(clip_from_world, *bias));
        }
    }
}

/// A light view whose depths, after the division by w, are smaller (farther from the light) by `bias`.
fn deeper(clip_from_world: Mat4, bias: f32) -> Mat4 {
    Mat4::from_translation(Vec3::NEG_Z * bias) * clip_from_world
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_fall_by_the_bias_at_every_w() {
        let clip_from_world = Mat4::perspective_infinite_reverse_rh(1.0, 1.0, 0.5);
        for point in [Vec3::new(0.2, -0.1, -1.0), Vec3::new(3.0, 1.0, -20.0)] {
            let (before, after) = (
                clip_from_world.project_point3(point),
                deeper(clip_from_world, 0.125).project_point3(point),
            );
            assert!(
                (before - after - Vec3::Z * 0.125).abs().max_element() < 1.0e-6,
                "{before} {after}"
            );
        }
    }
}
