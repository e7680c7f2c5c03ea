//! Buffers of the reduction, and where this frame was measured from.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

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
    render::{extract::ExtractedSun, gpu_types::GpuDepthRange},
    shadow::measured::MeasuredView,
};

/// Read-back buffers of a camera: one on the GPU, one being mapped, one to spare.
const READ_BACKS: usize = 3;

/// On a camera's render entity: where its range is reduced to, and read back from.
#[derive(Component)]
pub(super) struct DepthRangeBuffers {
    /// A [`GpuDepthRange`].
    pub(super) range: Buffer,
    /// Copies on their way.
    pub(super) read_backs: Vec<ReadBack>,
    /// The camera in the main world.
    pub(super) camera: Entity,
    /// From where this frame is measured.
    pub(super) view: MeasuredView,
    /// The copy of this frame, from when the pass has run until it is mapped.
    pub(super) current: Option<usize>,
}

/// A buffer that the CPU can map.
pub(super) struct ReadBack {
    pub(super) buffer: Buffer,
    /// From the copy until its content has arrived.
    pub(super) is_busy: Arc<AtomicBool>,
}

impl DepthRangeBuffers {
    fn new(device: &RenderDevice, camera: Entity) -> Self {
        let create = |usage| {
            device.create_buffer(&BufferDescriptor {
                label: Some(REDUCE_DEPTHS),
                size: GpuDepthRange::min_size().get(),
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            range: create(BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC),
            read_backs: (0..READ_BACKS)
                .map(|_| ReadBack {
                    buffer: create(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
                    is_busy: Arc::default(),
                })
                .collect(),
            camera,
            view: MeasuredView::default(),
            current: None,
        }
    }

    /// A buffer whose content has arrived.
    pub(super) fn free(&self) -> Option<usize> {
        let is_free = |read_back: &ReadBack| !read_back.is_busy.load(Ordering::Acquire);
        self.read_backs.iter().position(is_free)
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
        if !sun.is_some_and(|sun| sun.settings.measured.is_on()) {
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
