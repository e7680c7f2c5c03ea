//! Textures of the history, and the frame before.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Texture, TextureFormat, TextureView, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
        view::ExtractedView,
    },
};

use super::BLEND_HISTORY;
use crate::render::{
    atlas::{ShadowResult, create_target},
    extract::ExtractedSun,
    gpu_types::GpuHistoryFrame,
};

/// Visibility and view depth in metres.
pub(super) const HISTORY_FORMAT: TextureFormat = TextureFormat::Rg16Float;

/// On a camera's render entity whose sun asks for a history: the blended results of this frame and the one before.
#[derive(Component)]
pub struct HistoryTargets {
    /// As large as the shadow result: visibility and view depth.
    pub textures: [Texture; 2],
    pub(super) views: [TextureView; 2],
    /// Which of both this frame writes.
    pub(super) current: usize,
    /// Whether the other one holds the frame before.
    pub(super) is_valid: bool,
    /// The camera of the frame that was drawn last.
    last: Option<GpuHistoryFrame>,
    pub(super) frame: UniformBuffer<GpuHistoryFrame>,
}

impl HistoryTargets {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
        let [(first, first_view), (second, second_view)] =
            [0, 1].map(|_| create_target(device, BLEND_HISTORY, size, HISTORY_FORMAT));
        Self {
            textures: [first, second],
            views: [first_view, second_view],
            current: 0,
            is_valid: false,
            last: None,
            frame: UniformBuffer::default(),
        }
    }

    fn size(&self) -> UVec2 {
        UVec2::new(self.textures[0].width(), self.textures[0].height())
    }
}

/// Makes, keeps or removes the textures of every camera, and turns this frame's camera into that of the frame before.
pub(super) fn prepare_histories(
    mut commands: Commands,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut cameras: Query<(
        Entity,
        &ExtractedView,
        Option<&ExtractedSun>,
        Option<&ShadowResult>,
        Option<&mut HistoryTargets>,
    )>,
) {
    for (entity, view, sun, result, targets) in &mut cameras {
        let frames = sun.map_or(1, |sun| sun.settings.stable.frames());
        let (Some(result), true) = (result, frames > 1) else {
            if targets.is_some() {
                commands.entity(entity).remove::<HistoryTargets>();
            }
            continue;
        };
        let now = frame_of(view);
        let prepare = |targets: &mut HistoryTargets| {
            targets.current = 1 - targets.current;
            let before = targets.last.replace(now).unwrap_or(now);
            targets.frame.set(GpuHistoryFrame {
                new_share: 1.0 / frames as f32,
                is_valid: u32::from(targets.is_valid),
                ..before
            });
            // Until the pass has run again.
            targets.is_valid = false;
            targets.frame.write_buffer(&device, &queue);
        };
        match targets {
            Some(mut targets) if targets.size() == result.size => prepare(&mut targets),
            _ => {
                let mut targets = HistoryTargets::new(&device, result.size);
                prepare(&mut targets);
                commands.entity(entity).insert(targets);
            }
        }
    }
}

/// A camera as the next frame will need it.
fn frame_of(view: &ExtractedView) -> GpuHistoryFrame {
    let view_from_world = view.world_from_view.to_matrix().inverse();
    GpuHistoryFrame {
        clip_from_world: view
            .clip_from_world
            .unwrap_or_else(|| view.clip_from_view * view_from_world),
        view_depth_from_world: -view_from_world.row(2),
        ..default()
    }
}
