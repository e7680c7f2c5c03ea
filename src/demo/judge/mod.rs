//! Judging the frozen frame: the technique's shadow mask, ray-traced truth and their difference, side by side.
//!
//! The key stops time and lets the player's camera draw a [`ShadowMask`]. When mask and depth stand still, rays are
//! traced on the cores of the task pool while the window goes on drawing; then the pictures are shown with the counts of
//! [`accuracy`](crate::render::reference::accuracy) until the key is pressed again.

mod frame;

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::prepass::NormalPrepass,
    math::DVec3,
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{Extent3d, TextureDimension, TextureFormat},
    },
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};

use super::{
    DemoSystems, Notice,
    input::{Action, Intent},
    player::Player,
    screens::{Activity, Compiling, Screen},
    technique::Chosen,
};
use crate::{
    level::Sun,
    render::{
        capture::readable_target,
        mask::ShadowMask,
        reference::{
            accuracy::{self, Accuracy, Counts},
            extract::truth_scene,
            pictures::{difference_picture, truth_picture},
            pixels::{self, PixelRays, PixelTruth},
        },
    },
    ui::judge::{Panel, panels},
};
use frame::{Frame, Stillness, without_padding};

/// What is judged, from the key until it is pressed again.
#[derive(Resource)]
struct Judging {
    camera: Entity,
    /// Whether the camera drew normals before.
    had_normals: bool,
    rays: PixelRays,
    far: f64,
    direction_to_light: DVec3,
    frame: Frame,
    rows_done: Arc<AtomicUsize>,
    truth: Option<Task<Vec<PixelTruth>>>,
    /// What was found, once it is shown.
    accuracy: Option<Accuracy>,
}

/// On an entity whose image is read back.
#[derive(Component, Clone, Copy)]
enum Read {
    Mask,
    Depth,
}

pub(super) fn plugin(app: &mut App) {
    app.add_systems(OnEnter(Activity::Judging), freeze)
        .add_systems(OnExit(Activity::Judging), thaw)
        .add_systems(
            Update,
            (
                begin.run_if(in_state(Activity::Running)),
                (
                    end,
                    (wait_for_frame, wait_for_truth)
                        .chain()
                        .run_if(resource_exists::<Judging>),
                )
                    .run_if(in_state(Activity::Judging)),
            )
                .in_set(DemoSystems::Act),
        )
        .add_observer(receive);
}

fn begin(intent: Res<Intent>, mut next: ResMut<NextState<Activity>>) {
    if intent.started(Action::Judge) {
        next.set(Activity::Judging);
    }
}

fn end(intent: Res<Intent>, mut next: ResMut<NextState<Activity>>) {
    if intent.started(Action::Judge) || intent.started(Action::TogglePause) {
        next.set(Activity::Running);
    }
}

/// Stops time and asks for mask and depth.
fn freeze(
    mut commands: Commands,
    images: Option<ResMut<Assets<Image>>>,
    players: Query<(Entity, &Camera, &Projection, &Transform, Has<NormalPrepass>), With<Player>>,
    suns: Query<(Entity, &GlobalTransform), With<Sun>>,
    mut time: ResMut<Time<Virtual>>,
    mut notice: ResMut<Notice>,
) {
    time.pause();
    let sun = suns.iter().next();
    let (
        Some(mut images),
        Ok((camera, settings, Projection::Perspective(projection), eye, had_normals)),
        Some((sun, sun_place)),
    ) = (images, players.single(), sun)
    else {
        notice.show("there is nothing to judge: no picture, or no sun");
        return;
    };
    let Some(size) = settings.physical_target_size().filter(|size| size.min_element() > 0) else {
        notice.show("there is nothing to judge: the window has no area");
        return;
    };
    let mut target = |format| images.add(readable_target(size.x, size.y, format));
    let mask = ShadowMask {
        light: sun,
        mask: target(ShadowMask::MASK_FORMAT),
        depth: target(ShadowMask::DEPTH_FORMAT),
        normal: target(ShadowMask::NORMAL_FORMAT),
    };
    for (read, image) in [(Read::Mask, &mask.mask), (Read::Depth, &mask.depth)] {
        commands.spawn((
            read,
            Readback::texture(image.clone()),
            DespawnOnExit(Activity::Judging),
            DespawnOnExit(Screen::Play),
        ));
    }
    commands.entity(camera).insert(mask);
    commands.insert_resource(Judging {
        camera,
        had_normals,
        rays: PixelRays::of_camera(size, eye, f64::from(projection.fov)),
        far: f64::from(projection.far),
        direction_to_light: sun_place.back().as_dvec3(),
        frame: Frame::default(),
        rows_done: Arc::default(),
        truth: None,
        accuracy: None,
    });
}

fn receive(read_back: On<ReadbackComplete>, reads: Query<&Read>, judging: Option<ResMut<Judging>>) {
    let (Ok(read), Some(mut judging)) = (reads.get(read_back.entity), judging) else {
        return;
    };
    let size = judging.rays.size;
    match read {
        Read::Mask => judging.frame.mask = without_padding(&read_back.data, size, 1),
        Read::Depth => judging.frame.depth = without_padding(&read_back.data, size, 4),
    }
}

/// When the picture stands still, the rays start.
fn wait_for_frame(world: &mut World) {
    let is_compiling = world.get_resource::<Compiling>().is_some_and(Compiling::is_compiling);
    let mut judging = world.resource_mut::<Judging>();
    if judging.truth.is_some() || judging.accuracy.is_some() {
        return;
    }
    let camera = Some(judging.camera);
    match judging.frame.next(is_compiling) {
        Stillness::Waiting => world.resource_mut::<Notice>().show("judging: drawing the mask"),
        Stillness::Restless => give_up(world, "this picture does not stand still, so it cannot be judged"),
        Stillness::Still => match truth_scene(world, camera) {
            Err(error) => give_up(world, error.to_string()),
            Ok(scene) => {
                let mut judging = world.resource_mut::<Judging>();
                let (rays, far, to_light) = (judging.rays, judging.far, judging.direction_to_light);
                let (depths, rows_done) = (judging.frame.depths(), Arc::clone(&judging.rows_done));
                judging.truth = Some(AsyncComputeTaskPool::get().spawn(async move {
                    let progress = |rows| rows_done.store(rows, Ordering::Relaxed);
                    pixels::trace(&scene, &rays, &depths, far, to_light, progress).truth
                }));
            }
        },
    }
    let reads: Vec<Entity> = world.query_filtered::<Entity, With<Read>>().iter(world).collect();
    if world.resource::<Judging>().truth.is_some() {
        reads.into_iter().for_each(|read| {
            world.despawn(read);
        });
    }
}

fn give_up(world: &mut World, sentence: impl Into<String>) {
    world.resource_mut::<Notice>().show(sentence);
    world.resource_mut::<NextState<Activity>>().set(Activity::Running);
}

/// When the rays are back, pictures and counts are shown.
fn wait_for_truth(
    mut commands: Commands,
    mut judging: ResMut<Judging>,
    chosen: Res<Chosen>,
    mut images: ResMut<Assets<Image>>,
    mut notice: ResMut<Notice>,
) {
    let Some(task) = &mut judging.truth else {
        return;
    };
    let Some(truth) = block_on(poll_once(task)) else {
        let (done, all) = (judging.rows_done.load(Ordering::Relaxed), judging.rays.size.y);
        notice.show(format!("judging: row {done} of {all} traced"));
        return;
    };
    judging.truth = None;
    let (size, mask) = (judging.rays.size, &judging.frame.mask);
    let accuracy = accuracy::compare(size, mask, &truth);
    let pictures = [
        mask.iter().map(|value| [*value; 3]).collect(),
        truth_picture(&truth),
        difference_picture(mask, &truth),
    ];
    let titles = [
        chosen.0.to_string(),
        "ray-traced truth (blue: does not count)".to_owned(),
        "difference (red: false shadow, orange: false lit)".to_owned(),
    ];
    let panel = |(pixels, title): (Vec<[u8; 3]>, String)| Panel {
        image: images.add(image_of(size, &pixels)),
        title,
    };
    let shown: Vec<Panel> = pictures.into_iter().zip(titles).map(panel).collect();
    commands.spawn((
        panels(shown, format!("{}\nJ or Esc: go on", sentence(&accuracy))),
        DespawnOnExit(Activity::Judging),
        DespawnOnExit(Screen::Play),
    ));
    judging.accuracy = Some(accuracy);
}

/// Time goes on, and the camera draws no mask any more.
fn thaw(mut commands: Commands, judging: Option<Res<Judging>>, mut time: ResMut<Time<Virtual>>) {
    time.unpause();
    if let Some(judging) = judging {
        if let Ok(mut camera) = commands.get_entity(judging.camera) {
            camera.remove::<ShadowMask>();
            if !judging.had_normals {
                camera.remove::<NormalPrepass>();
            }
        }
        commands.remove_resource::<Judging>();
    }
}

fn image_of(size: UVec2, pixels: &[[u8; 3]]) -> Image {
    let extent = Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    };
    let data = pixels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
    Image::new(
        extent,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    )
}

/// The counts in words.
fn sentence(accuracy: &Accuracy) -> String {
    let percent = |counts: &Counts, count| 100.0 * counts.share(count);
    let Accuracy { pixels, overall, band } = accuracy;
    if overall.valid == 0 {
        return "no pixel of this picture can be judged: sky, edges and surfaces that face away from the sun"
            .to_owned();
    }
    format!(
        "{:.3} % of {} valid pixels are wrong: {:.3} % false shadow, {:.3} % false lit\nwithin 3 pixels of true shadow \
         edges {:.2} % of {}; {:.1} % of the picture is valid",
        percent(overall, overall.false_shadow + overall.false_lit),
        overall.valid,
        percent(overall, overall.false_shadow),
        percent(overall, overall.false_lit),
        percent(band, band.false_shadow + band.false_lit),
        band.valid,
        100.0 * f64::from(overall.valid) / f64::from((*pixels).max(1)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_become_a_sentence() {
        let accuracy = Accuracy {
            pixels: 1000,
            overall: Counts {
                valid: 500,
                false_shadow: 2,
                false_lit: 3,
            },
            band: Counts {
                valid: 50,
                false_shadow: 1,
                false_lit: 3,
            },
        };
        let text = sentence(&accuracy);
        assert!(
            text.starts_with("1.000 % of 500 valid pixels are wrong: 0.400 % false shadow, 0.600 % false lit"),
            "{text}"
        );
        assert!(
            text.ends_with("edges 8.00 % of 50; 50.0 % of the picture is valid"),
            "{text}"
        );
        assert!(sentence(&Accuracy::default()).starts_with("no pixel"));
    }
}
