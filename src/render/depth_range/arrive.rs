//! From the GPU back to the cameras of the main world.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::prelude::*;

use super::prepare::DepthRangeBuffers;
use crate::{
    maths::split::VisibleDepths,
    render::gpu_types::GpuDepthRange,
    shadow::{
        measured::{MeasuredView, VisibleDepthRange},
        settings::SunShadows,
    },
};

/// Ranges that have come back from the GPU, with their cameras in the main world; shared by both worlds.
#[derive(Resource, Clone, Default)]
pub(super) struct ArrivedDepths(Arc<Mutex<Vec<(Entity, VisibleDepthRange)>>>);

impl ArrivedDepths {
    fn push(&self, camera: Entity, range: VisibleDepthRange) {
        // A list of values is whole whatever its last writer did.
        let mut list = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        list.push((camera, range));
    }

    fn take(&self) -> Vec<(Entity, VisibleDepthRange)> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The view depths of a reduced picture that was seen through a projection.
pub fn range_of(reduced: &GpuDepthRange, view: MeasuredView) -> VisibleDepthRange {
    let view_from_clip = view.clip_from_view.as_dmat4().inverse();
    let view_depth = |bits: u32| {
        -view_from_clip
            .project_point3(Vec3::Z.as_dvec3() * f64::from(f32::from_bits(bits)))
            .z
    };
    let depths = (reduced.pixel_count > 0).then(|| VisibleDepths {
        nearest: view_depth(reduced.nearest),
        farthest: view_depth(u32::MAX - reduced.farthest),
    });
    VisibleDepthRange {
        // Projections with a skewed depth have no range that a number could tell.
        depths: depths.filter(|depths| depths.nearest <= depths.farthest && depths.farthest.is_finite()),
        pixel_count: reduced.pixel_count,
        view,
    }
}

/// Maps the copies of the frame just submitted; their ranges arrive when the GPU has made them.
pub(super) fn map_buffers(mut cameras: Query<&mut DepthRangeBuffers>, arrived: Res<ArrivedDepths>) {
    for mut buffers in &mut cameras {
        let (arrived, camera, view) = (arrived.clone(), buffers.camera, buffers.view);
        buffers.read_backs.map(move |bytes| {
            let (words, _) = bytes.as_chunks();
            let words: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
            if let [nearest, farthest, pixel_count, padding] = words[..] {
                let reduced = GpuDepthRange {
                    nearest,
                    farthest,
                    pixel_count,
                    padding,
                };
                arrived.push(camera, range_of(&reduced, view));
            }
        });
    }
}

/// Gives cameras what has arrived, the latest last, and takes it from them when no sun asks for it any more.
pub(super) fn receive_depths(
    mut commands: Commands,
    arrived: Res<ArrivedDepths>,
    suns: Query<&SunShadows>,
    known: Query<Entity, With<VisibleDepthRange>>,
) {
    let ranges = arrived.take();
    if suns.iter().any(|settings| settings.measures().is_on()) {
        for (camera, range) in ranges {
            if let Ok(mut camera) = commands.get_entity(camera) {
                camera.insert(range);
            }
        }
    } else {
        for camera in &known {
            commands.entity(camera).remove::<VisibleDepthRange>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reduced(depths_ndc: &[f32]) -> GpuDepthRange {
        let bits = depths_ndc.iter().map(|depth| depth.to_bits());
        GpuDepthRange {
            nearest: bits.clone().max().unwrap_or(0),
            farthest: bits.map(|bits| u32::MAX - bits).max().unwrap_or(0),
            pixel_count: depths_ndc.len() as u32,
            padding: 0,
        }
    }

    fn range(clip_from_view: Mat4, depths_ndc: &[f32]) -> Option<(f64, f64)> {
        let view = MeasuredView {
            clip_from_view,
            ..default()
        };
        range_of(&reduced(depths_ndc), view)
            .depths
            .map(|depths| (depths.nearest, depths.farthest))
    }

    #[test]
    fn bits_become_metres() {
        let perspective = Mat4::perspective_infinite_reverse_rh(1.0, 1.5, 0.5);
        // NDC depth is near ÷ view depth.
        assert_eq!(range(perspective, &[0.125, 0.25, 0.0078125]), Some((2.0, 64.0)));
        assert_eq!(range(perspective, &[]), None, "only sky");
        // 1 at −2 m, 0 at 14 m.
        let orthographic = Mat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 14.0, -2.0);
        let (nearest, farthest) = range(orthographic, &[0.75, 0.25]).expect("two pixels");
        assert!(
            (nearest - 2.0).abs() < 1e-5 && (farthest - 10.0).abs() < 1e-5,
            "{nearest} {farthest}"
        );
        assert_eq!(range(Mat4::ZERO, &[0.5]), None, "no projection");
    }
}
