//! What is known of the nearest fading surfaces of every pixel, and how shaders read it.

use bevy::{
    core_pipeline::{core_3d::Transparent3d, prepass::NORMAL_PREPASS_FORMAT},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, Extent3d, PipelineCache,
            ShaderStages, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType,
            TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension, binding_types::texture_2d_array,
        },
        renderer::RenderDevice,
        view::ExtractedView,
    },
};

use super::{draw::FadingItems, layers::ExtractedLayers};
use crate::render::atlas::RESULT_FORMAT;

/// Format of numbers of levels.
pub const LEVEL_FORMAT: TextureFormat = TextureFormat::R16Uint;
/// Format of depth.
pub const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// A texture of several layers: all of them, and one by one.
#[derive(Clone, Debug)]
pub struct Layered {
    /// It.
    pub texture: Texture,
    /// All of them.
    pub all: TextureView,
    /// One by one.
    pub each: Vec<TextureView>,
}

impl Layered {
    fn new(device: &RenderDevice, label: &str, size: UVec2, layers: u32, format: TextureFormat) -> Self {
        let texture = device.create_texture(&TextureDescriptor {
            label: Some(label),
            size: Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = |dimension, base_array_layer, array_layer_count| {
            texture.create_view(&TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer,
                array_layer_count: Some(array_layer_count),
                ..default()
            })
        };
        Self {
            all: view(TextureViewDimension::D2Array, 0, layers),
            each: (0..layers)
                .map(|layer| view(TextureViewDimension::D2, layer, 1))
                .collect(),
            texture,
        }
    }
}

/// On a camera's render entity: the nearest fading surfaces of every pixel, one per layer. 15 bytes per pixel and layer,
/// from the first time on that so many layers are needed.
#[derive(Component, Clone, Debug)]
pub struct FadingSurfaces {
    /// Reverse z; 0 where nothing fades.
    pub depth: Layered,
    /// World space, as the normal prepass holds it.
    pub normal: Layered,
    /// Number of the object's level; 0: none.
    pub level: Layered,
    /// The shadow result of that surface: 1 lit, 0 in shadow.
    pub result: Layered,
    /// Pixels.
    pub size: UVec2,
    /// Whether something fades in this frame; else the textures are old.
    pub is_current: bool,
}

/// On a camera's render entity: [`FadingSurfaces`] as shaders of fading materials read them.
#[derive(Component, Clone, Debug)]
pub struct FadingBindGroup(pub BindGroup);

/// For cameras without [`FadingSurfaces`]: textures of one pixel, where nothing fades.
#[derive(Resource)]
pub struct NoSurfaces {
    /// All of them.
    pub bind_group: BindGroup,
}

/// Group 4 of fading pipelines: depth and level for the material's shader; result, and depth again, for the lookup that
/// [`bridge`](crate::render::bridge) appends to Bevy's module. Two modules cannot declare one binding.
pub fn bind_group_layout() -> BindGroupLayoutDescriptor {
    BindGroupLayoutDescriptor::new(
        "umbrage_fading_surfaces",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (
                texture_2d_array(TextureSampleType::Depth),
                texture_2d_array(TextureSampleType::Uint),
                texture_2d_array(TextureSampleType::Float { filterable: false }),
                texture_2d_array(TextureSampleType::Depth),
            ),
        ),
    )
}

impl FadingSurfaces {
    fn new(device: &RenderDevice, size: UVec2, layers: u32) -> Self {
        let create = |label, format| Layered::new(device, label, size, layers, format);
        Self {
            depth: create("umbrage_fading_depth", DEPTH_FORMAT),
            normal: create("umbrage_fading_normal", NORMAL_PREPASS_FORMAT),
            level: create("umbrage_fading_level", LEVEL_FORMAT),
            result: create("umbrage_fading_result", RESULT_FORMAT),
            size,
            is_current: false,
        }
    }

    fn layers(&self) -> u32 {
        self.depth.each.len() as u32
    }

    fn bind_group(&self, device: &RenderDevice, cache: &PipelineCache) -> BindGroup {
        device.create_bind_group(
            "umbrage_fading_surfaces",
            &cache.get_bind_group_layout(&bind_group_layout()),
            &BindGroupEntries::sequential((&self.depth.all, &self.level.all, &self.result.all, &self.depth.all)),
        )
    }
}

pub(super) fn init_no_surfaces(mut commands: Commands, device: Res<RenderDevice>, cache: Res<PipelineCache>) {
    // New textures are zero: no level.
    let surfaces = FadingSurfaces::new(&device, UVec2::ONE, 1);
    commands.insert_resource(NoSurfaces {
        bind_group: surfaces.bind_group(&device, &cache),
    });
}

/// Makes and keeps the textures of cameras in whose pictures something fades. Multisampled cameras get none: there all
/// layers of an object are blended.
pub(super) fn prepare_surfaces(
    mut commands: Commands,
    device: Res<RenderDevice>,
    cache: Res<PipelineCache>,
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    (items, needed): (FadingItems, Res<ExtractedLayers>),
    mut cameras: Query<(
        Entity,
        &ExtractedCamera,
        &ExtractedView,
        &Msaa,
        Option<&mut FadingSurfaces>,
    )>,
) {
    for (entity, camera, view, msaa, surfaces) in &mut cameras {
        let phase = phases.get(&view.retained_view_entity);
        let fades = *msaa == Msaa::Off && phase.is_some_and(|phase| phase.items.values().any(|item| items.has(item)));
        let size = camera.physical_target_size.filter(|size| size.min_element() > 0);
        let fits = |surfaces: &FadingSurfaces, size: UVec2| {
            let is_enough = !fades || surfaces.layers() >= needed.0;
            surfaces.size == size && is_enough
        };
        match (surfaces, size) {
            (Some(mut surfaces), Some(size)) if fits(&surfaces, size) => surfaces.is_current = fades,
            (_, Some(size)) if fades => {
                let mut surfaces = FadingSurfaces::new(&device, size, needed.0.max(1));
                surfaces.is_current = true;
                let bind_group = FadingBindGroup(surfaces.bind_group(&device, &cache));
                commands.entity(entity).insert((surfaces, bind_group));
            }
            (Some(_), _) => {
                commands.entity(entity).remove::<(FadingSurfaces, FadingBindGroup)>();
            }
            (None, _) => {}
        }
    }
}
