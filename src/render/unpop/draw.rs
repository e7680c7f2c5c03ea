//! Draws fading parts: among transparent things, with the nearest surfaces bound.

use std::any::TypeId;

use bevy::{
    core_pipeline::core_3d::Transparent3d,
    ecs::{
        query::ROQueryItem,
        system::{
            SystemParam, SystemParamItem,
            lifetimeless::{Read, SRes},
        },
    },
    pbr::{
        DrawMaterial, DrawMesh, RenderMaterialInstances, SetMaterialBindGroup, SetMeshBindGroup, SetMeshViewBindGroup,
        SetMeshViewBindingArrayBindGroup,
    },
    prelude::*,
    render::render_phase::{
        DrawFunctionId, DrawFunctions, PhaseItem, RenderCommand, RenderCommandResult, SetItemPipeline,
        TrackedRenderPass, ViewSortedRenderPhases,
    },
};

use super::{
    material::FadingMaterial,
    surfaces::{FadingBindGroup, NoSurfaces},
};

/// Bevy's commands for materials, and the nearest surfaces.
pub type DrawFading = (
    SetItemPipeline,
    SetMeshViewBindGroup<0>,
    SetMeshViewBindingArrayBindGroup<1>,
    SetMeshBindGroup<2>,
    SetMaterialBindGroup<3>,
    SetFadingBindGroup,
    DrawMesh,
);

/// Binds the nearest surfaces as group 4.
pub struct SetFadingBindGroup;

impl<P: PhaseItem> RenderCommand<P> for SetFadingBindGroup {
    type Param = SRes<NoSurfaces>;
    type ViewQuery = Option<Read<FadingBindGroup>>;
    type ItemQuery = ();

    fn render<'w>(
        _: &P,
        own: ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        none: SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let bind_group = own.map_or(&none.into_inner().bind_group, |own| &own.0);
        pass.set_bind_group(4, bind_group, &[]);
        RenderCommandResult::Success
    }
}

/// Tells fading parts from other transparent things.
#[derive(SystemParam)]
pub struct FadingItems<'w> {
    functions: Res<'w, DrawFunctions<Transparent3d>>,
}

impl FadingItems<'_> {
    /// Their draw function.
    pub fn function(&self) -> Option<DrawFunctionId> {
        self.functions.read().get_id::<DrawFading>()
    }

    /// Whether an item is a fading part; from [`draw_by_own_function`] on.
    pub fn has(&self, item: &Transparent3d) -> bool {
        Some(item.draw_function) == self.function()
    }
}

/// Gives fading parts their draw function: Bevy queues all materials with its own.
pub(in crate::render) fn draw_by_own_function(
    mut phases: ResMut<ViewSortedRenderPhases<Transparent3d>>,
    functions: Res<DrawFunctions<Transparent3d>>,
    materials: Res<RenderMaterialInstances>,
) {
    let functions = functions.read();
    let (Some(bevys), Some(own)) = (functions.get_id::<DrawMaterial>(), functions.get_id::<DrawFading>()) else {
        return;
    };
    let is_fading = |item: &Transparent3d| {
        let material = materials.instances.get(&item.entity.1);
        material.is_some_and(|material| material.asset_id.type_id() == TypeId::of::<FadingMaterial>())
    };
    for phase in phases.values_mut() {
        for item in phase.items.values_mut() {
            if item.draw_function == bevys && is_fading(item) {
                item.draw_function = own;
            }
        }
    }
}
