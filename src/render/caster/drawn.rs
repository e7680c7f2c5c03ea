//! How many casters the GPU drew: read back, for statistics and tests.

use bevy::prelude::*;

use super::{CasterStatistics, plan::CasterPlan};
use crate::render::capture::{self, CaptureError};

/// Casters that the last frame drew into each light view of a camera, in the order of the atlas, or into each tile of its
/// virtual map, in the order of drawing; without culling all of the phase's. Empty for cameras without full-path shadows.
/// Waits for the GPU.
///
/// # Errors
/// The counts cannot be read back.
pub fn casters_drawn(render_world: &World, camera_render_entity: Entity) -> Result<Vec<u32>, CaptureError> {
    let plan = render_world.get_entity(camera_render_entity).ok();
    let plan = plan.and_then(|camera| camera.get::<CasterPlan>());
    let statistics = render_world.get_resource::<CasterStatistics>();
    let counts = statistics.and_then(|statistics| statistics.0.get(&camera_render_entity));
    let (Some(plan), Some(counts)) = (plan, counts) else {
        return Ok(Vec::new());
    };
    let light_views = counts.light_views as usize;
    match &plan.drawn {
        Some(drawn) => Ok(first_counters(&capture::read_buffer(render_world, drawn)?, light_views)),
        None => Ok(vec![counts.casters; light_views]),
    }
}

fn first_counters(bytes: &[u8], count: usize) -> Vec<u32> {
    let (counters, _) = bytes.as_chunks();
    counters.iter().copied().map(u32::from_le_bytes).take(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_counters_in_use_are_read() {
        let bytes: Vec<u8> = [3, 0, 77_u32].into_iter().flat_map(u32::to_le_bytes).collect();
        assert_eq!(first_counters(&bytes, 2), [3, 0]);
        assert_eq!(first_counters(&bytes, 5), [3, 0, 77]);
    }
}
