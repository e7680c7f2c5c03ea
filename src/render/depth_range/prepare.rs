//! Buffers of the reduction, and where this frame was measured from.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, ShaderType},
        renderer::RenderDevice,
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use super::REDUCE_DEPTHS;
use crate::{
    render::{extract::ExtractedSun, gpu_types::GpuDepthRange, read_back::ReadBacks},
    shadow::measured::MeasuredView,
};

/// On a camera's render entity: where its range is reduced to, and read back from.
#[derive(Component)]
pub(super) struct DepthRangeBuffers {
    /// A [`GpuDepthRange`].
    pub(super) range: Buffer,
    /// Copies on their way.
    pub(super) read_backs: ReadBacks,
    /// The camera in the main world.
    pub(super) camera: Entity,
    /// From where this frame is measured.
    pub(super) view: MeasuredView,
}

impl DepthRangeBuffers {
    fn new(device: &RenderDevice, camera: Entity) -> Self {
        let size = GpuDepthRange::min_size().get();
        Self {
            range: device.create_buffer(&BufferDescriptor {
                label: Some(REDUCE_DEPTHS),
                size,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            read_backs: ReadBacks::new(device, REDUCE_DEPTHS, size),
            camera,
            view: MeasuredView::default(),
        }
    }
}

/// Makes, keeps or removes the buffers of every camera, and notes where it stands.
pub(super) fn prepare_depth_ranges(
    mut commands: Commands,
    device: Res<RenderDevice>,
    time: Option<Res<Time>>,
    mut cameras: Query<(
        Entity,
        &MainEntity,
        &ExtractedView,
        Option<&ExtractedSun>,
        Option<&mut DepthRangeBuffers>,
    )>,
) {
    let seconds = time.map_or(0.0, |time| time.elapsed_secs_f64());
    for (entity, camera, view, sun, buffers) in &mut cameras {
        if !sun.is_some_and(|sun| sun.settings.measures().is_on()) {
            if buffers.is_some() {
                commands.entity(entity).remove::<DepthRangeBuffers>();
            }
            continue;
        }
        let view = MeasuredView {
            world_from_view: view.world_from_view,
            clip_from_view: view.clip_from_view,
            seconds,
        };
        if let Some(mut buffers) = buffers {
            buffers.view = view;
        } else {
            let buffers = DepthRangeBuffers {
                view,
                ..DepthRangeBuffers::new(&device, camera.id())
            };
            commands.entity(entity).insert(buffers);
        }
    }
}
