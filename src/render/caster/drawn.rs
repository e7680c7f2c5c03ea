//! How many casters the GPU drew: read back, for statistics and tests.

use bevy::prelude::*;

use super::plan::CasterPlan;
use crate::render::capture::{self, CaptureError};

/// Casters that the last frame drew into each light view of a camera, in the order of the atlas; without culling all of
/// the phase's. Empty for cameras without full-path shadows. Waits for the GPU.
///
/// # Errors
/// The counts cannot be read back.
pub fn casters_drawn(render_world: &World, camera_render_entity: Entity) -> Result<Vec<u32>, CaptureError> {
    let Some((plan, views)) = render_world.get_entity(camera_render_entity).ok().and_then(|entity| {
        Some((
            entity.get::<CasterPlan>()?,
            entity.get::<super::prepare::CasterViews>()?,
        ))
    }) else {
        return Ok(Vec::new());
    };
    let light_views = views.light_views.len();
    let Some((_, counts)) = &plan.indirect else {
        let all = plan.bins.iter().map(|bin| bin.instance_count).sum();
        return Ok(vec![all; light_views]);
    };
    let bytes = capture::read_buffer(render_world, counts)?;
    Ok(sums_per_view(&bytes, plan.instance_total as usize, light_views))
}

/// The buffer holds one count per (light view, instance), of which those at the first instance of a bin are used.
fn sums_per_view(bytes: &[u8], instance_total: usize, light_views: usize) -> Vec<u32> {
    let (counts, _) = bytes.as_chunks();
    let counts: Vec<u32> = counts.iter().copied().map(u32::from_le_bytes).collect();
    counts
        .chunks(instance_total.max(1))
        .take(light_views)
        .map(|counts| counts.iter().sum())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_to_grow_is_not_counted() {
        let counts: Vec<u8> = [1, 0, 2, 5, 0, 0, 77, 77_u32]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        assert_eq!(sums_per_view(&counts, 3, 2), [3, 5]);
        assert!(sums_per_view(&counts, 0, 0).is_empty());
    }
}
