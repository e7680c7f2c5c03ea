//! Which layer of nearest surfaces a fading level is found in.

use bevy::{
    camera::primitives::Aabb,
    platform::collections::HashMap,
    prelude::*,
    render::{
        Extract,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BufferInitDescriptor,
            BufferUsages, PipelineCache, ShaderStages, ShaderType, binding_types::uniform_buffer,
        },
        renderer::RenderDevice,
    },
};

use super::tag::MOST_LAYERS;
use crate::{
    lod::{casters::ShadowOnly, chain::LodCoat, eyes::LodEyes, settings::LodSettings},
    maths::lod::layers::{Ball, free_layer},
};

/// A level of an object: of plain blending both fade.
type Level = (u32, bool);

fn level(coat: &LodCoat) -> Level {
    (coat.object, coat.wins_ties)
}

/// The layers of all levels that fade.
#[derive(Resource, Default)]
pub struct FadingLayers(HashMap<Level, (Ball, u32)>);

impl FadingLayers {
    /// That of a level; the first one of others.
    pub fn of(&self, coat: &LodCoat) -> u32 {
        self.0.get(&level(coat)).map_or(0, |(_, layer)| *layer)
    }

    /// Layers in use.
    pub fn count(&self) -> u32 {
        self.0.values().map(|(_, layer)| layer + 1).max().unwrap_or(0)
    }
}

/// Gives levels that begin to fade a layer, which they keep as long as they do.
pub(super) fn choose_layers(
    parts: Query<(&LodCoat, &GlobalTransform, Option<&Aabb>), Without<ShadowOnly>>,
    eyes: Res<LodEyes>,
    settings: Res<LodSettings>,
    mut layers: ResMut<FadingLayers>,
) {
    if parts.is_empty() && layers.0.is_empty() {
        return;
    }
    let mut balls: HashMap<Level, Ball> = HashMap::default();
    for (coat, place, bounds) in &parts {
        let bounds = bounds.copied().unwrap_or_default();
        let ball = Ball {
            center: place.affine().transform_point3a(bounds.center).into(),
            radius: place.radius_vec3a(bounds.half_extents),
        };
        balls
            .entry(level(coat))
            .and_modify(|whole| *whole = whole.with(ball))
            .or_insert(ball);
    }
    layers.0.retain(|level, _| balls.contains_key(level));
    let mut new: Vec<(Level, Ball)> = balls
        .into_iter()
        .filter(|(level, _)| !layers.0.contains_key(level))
        .collect();
    new.sort_by_key(|(level, _)| *level);
    let cameras: Vec<Vec3> = eyes.cameras().collect();
    let count = settings.fading_layers.clamp(1, MOST_LAYERS);
    for (level, ball) in new {
        let layer = free_layer(ball, layers.0.values().copied(), &cameras, count);
        layers.0.insert(level, (ball, layer));
    }
}

/// Render world: layers in use.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct ExtractedLayers(pub u32);

pub(super) fn extract_layers(layers: Extract<Res<FadingLayers>>, mut extracted: ResMut<ExtractedLayers>) {
    extracted.0 = layers.count();
}

/// Group 4 of the pass that finds the nearest surfaces: which layer it draws.
#[derive(ShaderType)]
struct LayerNumber {
    layer: UVec4,
}

/// Its layout.
pub fn bind_group_layout() -> BindGroupLayoutDescriptor {
    BindGroupLayoutDescriptor::new(
        "umbrage_fading_layer",
        &BindGroupLayoutEntries::sequential(ShaderStages::FRAGMENT, (uniform_buffer::<LayerNumber>(false),)),
    )
}

/// One of them per layer.
#[derive(Resource)]
pub struct LayerBindGroups(pub Vec<BindGroup>);

pub(super) fn init_layer_bind_groups(mut commands: Commands, device: Res<RenderDevice>, cache: Res<PipelineCache>) {
    let layout = cache.get_bind_group_layout(&bind_group_layout());
    let bind_group = |layer: u32| {
        let buffer = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("umbrage_fading_layer"),
            contents: &[layer, 0, 0, 0].map(u32::to_ne_bytes).concat(),
            usage: BufferUsages::UNIFORM,
        });
        let entries = BindGroupEntries::sequential((buffer.as_entire_binding(),));
        device.create_bind_group("umbrage_fading_layer", &layout, &entries)
    };
    commands.insert_resource(LayerBindGroups((0..MOST_LAYERS).map(bind_group).collect()));
}
