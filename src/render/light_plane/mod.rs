//! What cameras see, for the light planes of their suns: the depth and normal prepass reduced to one sample and two depths
//! per block of pixels, and read back without waiting (Chong 2003, sections 3 and 4.1.1: a low-resolution pass).
//!
//! ```text
//! extract   SurfaceSampling on a camera ─► BlockBuffers                                     prepare
//! Core3d    prepasses ─► see_blocks ─► copy into a free read-back buffer                    pass
//! Cleanup   the buffer is mapped; when the GPU is done, the blocks go to ArrivedPictures    arrive
//! PreUpdate of a later frame: ArrivedPictures ─► SeenSurfaces on the camera                 arrive
//! ```
//!
//! **Why samples come back, and not sums.** The sums that films need ([`FilmMoments`](crate::maths::light_plane::space))
//! depend on the base film, so on the sun and the view of the frame that uses them, which is not the frame that was
//! reduced; tiles, slices and hulls would need sums of their own each, and their division is decided with them in hand. A
//! grid of 48 × 27 samples is 61 KiB, a copy that no frame notices, and the sums over it take the CPU a millisecond.
//!
//! # Limits
//! Pictures are one frame late, two with pipelined rendering, more where the GPU lags. Only what is in the depth prepass
//! counts: transparent surfaces are not.

mod arrive;
mod pass;
mod prepare;

use bevy::{
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems},
};

pub use prepare::SampledCamera;

use super::SunShadowPasses;
use crate::shadow::timing::SystemTimes;

/// The name of the pass and its span.
pub const SEE_BLOCKS: &str = "umbrage_see_blocks";

/// Samples what cameras with [`SurfaceSampling`](crate::shadow::light_plane::SurfaceSampling) see.
pub struct LightPlanePlugin;

impl Plugin for LightPlanePlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let arrived = arrive::ArrivedPictures::default();
        app.insert_resource(arrived.clone())
            .add_systems(PreUpdate, arrive::receive_pictures);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(arrived)
            .add_systems(ExtractSchedule, prepare::extract_sampled_cameras)
            .add_systems(RenderStartup, pass::init_pipeline)
            .add_systems(
                Render,
                (
                    prepare::prepare_blocks.in_set(RenderSystems::PrepareResources),
                    arrive::map_blocks.in_set(RenderSystems::Cleanup),
                ),
            )
            .add_systems(
                Core3d,
                times
                    .clock("see_blocks", pass::see_blocks)
                    .after(Core3dSystems::Prepass)
                    .before(SunShadowPasses::Plan),
            );
    }
}
