//! The analytic rooms in an app that draws masks.

use bevy::{
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    prelude::*,
};
use umbrage::{
    cli::headless::{self, Pipelines},
    level::{
        LevelPlugin, LoadedScene, RequestedScene, SceneStatus, Sun, find::asset_root, scene::SceneSource, shot::Shot,
        sky::sun_transform,
    },
    render::{
        capture,
        mask::{MaskPlugin, ShadowMask},
        reference::{
            extract::truth_scene,
            pixels::{self, PixelRays, Traced},
            scene::TruthScene,
        },
    },
    shadow::technique::Technique,
};

use crate::harness::{Harness, eye};

pub(crate) const SIZE: UVec2 = UVec2::new(240, 135);

/// The side of each of the four maps that `bevy` has.
const BEVY_SIZE: usize = 512;

/// A room in an app that draws masks.
pub(crate) struct Room {
    pub(crate) name: &'static str,
    pub(crate) harness: Harness,
    pub(crate) sun: Entity,
    pub(crate) shots: Vec<Shot>,
    truth: TruthScene,
}

impl Room {
    pub(crate) fn load(name: &'static str) -> Self {
        let root = asset_root(Some(env!("CARGO_MANIFEST_DIR").as_ref())).unwrap_or_else(|error| panic!("{error}"));
        let mut harness = Harness::new(SIZE, eye());
        harness
            .app
            .add_plugins((LevelPlugin { assets: root }, MaskPlugin))
            .insert_resource(RequestedScene(Some(SceneSource::level(&format!("room/{name}")))));
        headless::finish(&mut harness.app);
        loop {
            harness.app.update();
            match harness.app.world().resource::<SceneStatus>() {
                SceneStatus::Ready => break,
                SceneStatus::Failed(problem) => panic!("{problem}"),
                SceneStatus::Idle | SceneStatus::Loading { .. } => {}
            }
        }
        let world = harness.app.world_mut();
        let sun = world
            .query_filtered::<Entity, With<Sun>>()
            .single(world)
            .expect("one sun");
        let shots = world.resource::<LoadedScene>().shots.clone();
        let truth = truth_scene(world, None).expect("all meshes are in main memory");
        harness.add_mask(sun, SIZE);
        Self {
            name,
            harness,
            sun,
            shots,
            truth,
        }
    }

    /// Places camera and sun.
    pub(crate) fn aim(&mut self, shot: &Shot) {
        let projection = Projection::Perspective(PerspectiveProjection {
            fov: shot.fov_y_deg.to_radians(),
            near: shot.near,
            far: shot.far,
            ..default()
        });
        let camera = self.harness.camera;
        let world = self.harness.app.world_mut();
        world.entity_mut(camera).insert((projection, shot.camera()));
        world.entity_mut(self.sun).insert(sun_transform(shot.light_dir.into()));
    }

    pub(crate) fn apply(&mut self, technique: &str, far: f32) {
        let technique: Technique = technique.parse().unwrap_or_else(|error| panic!("{technique}: {error}"));
        let world = self.harness.app.world_mut();
        technique.apply(&mut world.commands().entity(self.sun));
        world.flush();
        if matches!(technique, Technique::Bevy(_)) {
            world.insert_resource(DirectionalLightShadowMap { size: BEVY_SIZE });
            let cascades = CascadeShadowConfigBuilder {
                maximum_distance: far,
                ..default()
            };
            world.entity_mut(self.sun).insert(cascades.build());
        }
    }

    /// Mask and depths, once they are the same twice in a row.
    pub(crate) fn draw(&mut self) -> (Vec<u8>, Vec<f32>) {
        let app = &mut self.harness.app;
        let images = app
            .world()
            .get::<ShadowMask>(self.harness.camera)
            .expect("a mask")
            .clone();
        let (mut before, mut ready_frames) = (Vec::new(), 0);
        for _ in 0..60 {
            headless::frame(app);
            match headless::pipelines(app) {
                Pipelines::Ready => ready_frames += 1,
                Pipelines::Waiting => ready_frames = 0,
                Pipelines::Failed(error) => panic!("{error}"),
            }
            if ready_frames < 2 {
                continue;
            }
            let mask = capture::read_image(app, &images.mask)
                .expect("the mask can be read")
                .bytes;
            if mask == before {
                let depths = capture::read_image(app, &images.depth).expect("depths can be read");
                return (mask, depths.to_f32());
            }
            before = mask;
        }
        panic!("{}: the mask does not stand still", self.name);
    }

    /// What rays from the eye and to the sun meet, from the depths of a frame.
    pub(crate) fn trace(&self, shot: &Shot, depths: &[f32]) -> (PixelRays, Traced) {
        let rays = PixelRays::of_camera(SIZE, &shot.camera(), f64::from(shot.fov_y_deg).to_radians());
        let to_light = -Vec3::from(shot.light_dir).as_dvec3();
        let traced = pixels::trace(&self.truth, &rays, depths, f64::from(shot.far), to_light, |_| {});
        (rays, traced)
    }
}
