//! One camera before one scene: placing it, aiming the sun, and waiting until the picture stands still.

use std::collections::BTreeMap;

use bevy::{
    camera::RenderTarget,
    core_pipeline::{prepass::DepthPrepass, tonemapping::DebandDither},
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    prelude::*,
    render::render_resource::TextureFormat,
};

use super::stats::{self, PassTimes};
use crate::{
    cli::{
        Failure,
        headless::{self, Pipelines},
        pass::Pass,
    },
    level::{
        shot::Shot,
        sky::{UnderSky, sun_transform},
    },
    render::{
        capture::{self, Texels},
        mask::ShadowMask,
    },
    shadow::{
        settings::SunShadows,
        technique::{StockBias, Technique},
    },
};

/// Frames after which a picture that never stands still is taken all the same.
const MAX_FRAMES: usize = 60;
/// Frames that are drawn after everything is loaded before the picture can count as still: what changed in the main
/// world is extracted, batched and drawn in successive frames.
const WARM_UP: usize = 3;
/// Frames that are timed at least, for pictures.
pub(in crate::cli) const TIMED: usize = 5;
/// The same where only what is in the picture counts.
pub(in crate::cli) const NOT_TIMED: usize = 2;

/// A camera with the images that it draws into.
pub(in crate::cli) struct Stage {
    camera: Entity,
    sun: Entity,
    color: Handle<Image>,
    surfaces: Option<Surfaces>,
    far: f32,
}

/// What [`ShadowMask`] draws.
struct Surfaces {
    mask: Handle<Image>,
    depth: Handle<Image>,
    normal: Handle<Image>,
}

/// A picture that stands still.
pub(in crate::cli) struct Settled {
    /// One per image that was asked for.
    pub(in crate::cli) texels: Vec<Texels>,
    /// Seconds of each frame after the warm-up.
    pub(super) seconds: Vec<f64>,
    /// Times of passes in the same frames.
    pub(super) pass_ms: BTreeMap<String, PassTimes>,
    /// False: it never stood still.
    pub(super) is_still: bool,
}

impl Stage {
    /// Spawns the camera of a shot and turns the sun.
    pub(in crate::cli) fn new(app: &mut App, shot: &Shot, sun: Entity, passes: &[Pass]) -> Self {
        let world = app.world_mut();
        let mut images = world.resource_mut::<Assets<Image>>();
        let mut target = |format| images.add(capture::readable_target(shot.width, shot.height, format));
        let color = target(TextureFormat::Rgba8UnormSrgb);
        let surfaces = passes.iter().any(|pass| pass.is_of_surfaces()).then(|| Surfaces {
            mask: target(ShadowMask::MASK_FORMAT),
            depth: target(ShadowMask::DEPTH_FORMAT),
            normal: target(ShadowMask::NORMAL_FORMAT),
        });
        let mut camera = world.spawn((
            Camera3d::default(),
            RenderTarget::Image(color.clone().into()),
            UnderSky,
            DebandDither::Disabled,
            Msaa::Off,
            DepthPrepass,
        ));
        if let Some(surfaces) = &surfaces {
            camera.insert(ShadowMask {
                light: sun,
                mask: surfaces.mask.clone(),
                depth: surfaces.depth.clone(),
                normal: surfaces.normal.clone(),
            });
        }
        let camera = camera.id();
        let stage = Self {
            camera,
            sun,
            color,
            surfaces,
            far: shot.far,
        };
        stage.aim(app, shot);
        stage
    }

    /// Places camera and sun as a shot says: the one that the stage was made for, or another of the same size and far
    /// plane.
    pub(in crate::cli) fn aim(&self, app: &mut App, shot: &Shot) {
        let mut camera = app.world_mut().entity_mut(self.camera);
        camera.insert((projection(shot), shot.camera()));
        if let Some(mut transform) = app.world_mut().get_mut::<Transform>(self.sun) {
            *transform = sun_transform(shot.light_dir.into());
        }
    }

    /// Makes a technique the sun's. Stock cascades get the shot's far plane as their end, and keep their other defaults.
    pub(in crate::cli) fn apply(&self, app: &mut App, technique: &Technique) {
        let world = app.world_mut();
        if world.get::<SunShadows>(self.sun).is_none() {
            // What stock cascades with other biases have left would show in fallback maps.
            StockBias::default().write(&mut world.entity_mut(self.sun));
        }
        technique.apply(&mut world.commands().entity(self.sun));
        world.flush();
        if matches!(technique, Technique::Bevy(_)) {
            world.insert_resource(DirectionalLightShadowMap::default());
            world.entity_mut(self.sun).insert(stock_cascades(self.far));
        }
    }

    /// Switches the sun's shadows on or off.
    pub(super) fn set_shadows(&self, app: &mut App, on: bool) {
        if let Some(mut light) = app.world_mut().get_mut::<DirectionalLight>(self.sun) {
            light.shadow_maps_enabled = on;
        }
    }

    /// The image that holds a pass, as far as this stage draws it.
    pub(in crate::cli) fn image(&self, pass: Pass) -> Option<&Handle<Image>> {
        let surfaces = self.surfaces.as_ref();
        match pass {
            Pass::Beauty | Pass::Lit => Some(&self.color),
            Pass::Mask => surfaces.map(|surfaces| &surfaces.mask),
            Pass::Depth => surfaces.map(|surfaces| &surfaces.depth),
            Pass::Normal => surfaces.map(|surfaces| &surfaces.normal),
        }
    }

    /// Draws frames until the images of the passes are the same twice in a row, bit for bit, and `timed` frames are timed.
    pub(in crate::cli) fn settle(&self, app: &mut App, passes: &[Pass], timed: usize) -> Result<Settled, Failure> {
        let images: Vec<_> = passes.iter().filter_map(|pass| self.image(*pass)).collect();
        let mut seconds = Vec::new();
        let mut before = Vec::new();
        let mut warm_frames = 0;
        for _ in 0..MAX_FRAMES {
            let time = headless::frame(app);
            match headless::pipelines(app) {
                Pipelines::Failed(error) => {
                    return Err(Failure::Failed(format!(
                        "a shader cannot be used on this adapter: {error}"
                    )));
                }
                Pipelines::Waiting => {
                    warm_frames = 0;
                    continue;
                }
                Pipelines::Ready => warm_frames += 1,
            }
            if warm_frames < WARM_UP {
                stats::forget_pass_times(app);
                continue;
            }
            seconds.push(time.as_secs_f64());
            let texels: Vec<Texels> = images
                .iter()
                .map(|image| capture::read_image(app, image))
                .collect::<Result<_, _>>()
                .map_err(|error| Failure::Failed(format!("the picture cannot be read back: {error}")))?;
            if texels == before && seconds.len() >= timed {
                return Ok(Settled {
                    texels,
                    seconds,
                    pass_ms: stats::pass_times(app),
                    is_still: true,
                });
            }
            before = texels;
        }
        Ok(Settled {
            texels: before,
            seconds,
            pass_ms: stats::pass_times(app),
            is_still: false,
        })
    }

    /// The camera's entity.
    pub(in crate::cli) fn camera(&self) -> Entity {
        self.camera
    }

    /// Removes the camera and its images.
    pub(in crate::cli) fn strike(self, app: &mut App) {
        app.world_mut().despawn(self.camera);
    }
}

fn projection(shot: &Shot) -> Projection {
    Projection::Perspective(PerspectiveProjection {
        fov: shot.fov_y_deg.to_radians(),
        near: shot.near,
        far: shot.far,
        ..default()
    })
}

/// Bevy's default cascades, stretched to `far`; the first one shrinks where `far` is nearer than its default end.
fn stock_cascades(far: f32) -> CascadeShadowConfig {
    let default = CascadeShadowConfigBuilder::default();
    CascadeShadowConfigBuilder {
        maximum_distance: far,
        first_cascade_far_bound: default.first_cascade_far_bound.min(far * 0.5),
        minimum_distance: default.minimum_distance.min(far * 0.1),
        ..default
    }
    .build()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stock_cascades_ascend_to_any_far_plane() {
        let default_bounds = CascadeShadowConfig::default().bounds;
        for far in [0.02, 5.0, 10.0, 150.0, 1e6] {
            let config = stock_cascades(far);
            assert_eq!(config.bounds.len(), default_bounds.len());
            assert!(config.bounds.is_sorted_by(|a, b| a < b), "{:?}", config.bounds);
            assert!(
                (config.bounds[3] / far - 1.0).abs() < 1e-5,
                "{far}: {:?}",
                config.bounds
            );
            assert!(config.minimum_distance < config.bounds[0], "{far}");
        }
        assert_eq!(stock_cascades(150.0).bounds, default_bounds);
    }
}
