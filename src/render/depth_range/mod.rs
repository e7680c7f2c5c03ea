//! The range of view depths in a picture: the depth prepass reduced to its two ends on the GPU, and read back without
//! waiting (Stingl 2011, section 4.3 and appendix A.2).
//!
//! ```text
//! Core3d    depth prepass ─► reduce_depths ─► copy into a free read-back buffer            pass
//! Cleanup   the buffer is mapped; when the GPU is done, the range goes to ArrivedDepths    arrive
//! PreUpdate of a later frame: ArrivedDepths ─► VisibleDepthRange on the camera             arrive
//! ```
//!
//! It runs for cameras whose sun asks for [`MeasuredDepths`](crate::shadow::measured::MeasuredDepths).
//! [`maths::near_plane::DepthChain`](crate::maths::near_plane::DepthChain) is the CPU twin.
//!
//! # Limits
//! The range is one frame late, two with pipelined rendering, more where the GPU lags. While all read-back buffers are on
//! their way, a frame is not measured. Only what is in the depth prepass counts: transparent surfaces are not.

mod arrive;
mod pass;
mod prepare;

use bevy::{
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{Render, RenderApp, RenderStartup, RenderSystems},
};

pub use arrive::range_of;

use super::SunShadowPasses;
use crate::shadow::timing::SystemTimes;

/// The name of the pass and its span.
pub const REDUCE_DEPTHS: &str = "umbrage_reduce_depths";

/// Measures the depths that cameras see.
pub struct DepthRangePlugin;

impl Plugin for DepthRangePlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let arrived = arrive::ArrivedDepths::default();
        app.insert_resource(arrived.clone())
            .add_systems(PreUpdate, arrive::receive_depths);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(arrived)
            .add_systems(RenderStartup, pass::init_pipeline)
            .add_systems(
                Render,
                (
                    prepare::prepare_depth_ranges.in_set(RenderSystems::PrepareResources),
                    arrive::map_buffers.in_set(RenderSystems::Cleanup),
                ),
            )
            .add_systems(
                Core3d,
                times
                    .clock("reduce_depths", pass::reduce_depths)
                    .after(Core3dSystems::Prepass)
                    .before(SunShadowPasses::Plan),
            );
    }
}
