//! The history of the shadow result: every frame is blended with the one before, carried along with the surfaces.
//!
//! For suns with [`Stability::Sharp`](crate::shadow::stable::Stability). What crawls is the change from frame to frame, and a change Δ that is spread over n frames costs Δ²/n instead of Δ²
//! (after Scherzer et al. 2007, who blend by the confidence of every texel; here the share is fixed, and the new result
//! limits the old one where it has no edge nearby, so that moving shadows leave no trail). Fresh fits put their texels
//! elsewhere in every frame, so the blend also averages them: edges become smoother than texels.
//!
//! Two full-screen draws: the blend into one of two textures with visibility and view depth, and its visibility back into
//! the result.
//!
//! # Limits
//! Surfaces that move by themselves are looked up where they would have been had they stood still: they keep the new
//! result where their depth disagrees, which is everywhere but on planes that move along themselves.

mod pass;
mod prepare;

use bevy::{
    core_pipeline::schedule::Core3d,
    prelude::*,
    render::{Render, RenderApp, RenderStartup, RenderSystems},
};

pub use prepare::HistoryTargets;

use super::SunShadowPasses;
use crate::shadow::timing::SystemTimes;

/// The name of the span of both draws.
pub const BLEND_HISTORY: &str = "umbrage_blend_history";

/// The history.
pub struct HistoryPlugin;

impl Plugin for HistoryPlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_systems(RenderStartup, pass::init_pipelines)
            .add_systems(
                Render,
                prepare::prepare_histories.in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                times
                    .clock("blend_history", pass::blend_history)
                    .in_set(SunShadowPasses::History),
            );
    }
}
