//! The whole game on a GPU without a window: loading, then play with the head-up display, as pictures.

use bevy::{camera::RenderTarget, prelude::*, render::render_resource::TextureFormat, ui::IsDefaultUiCamera};
use umbrage::{
    cli::headless,
    demo::{DemoPlugin, player::Player, screens::Activity, technique::Chosen},
    level::{LevelPlugin, find::asset_root, scene::SceneSource},
    render::{UmbragePlugins, capture},
    shadow::technique::{StockBias, Technique},
    ui::hud::HudRoot,
};

const SIZE: UVec2 = UVec2::new(320, 180);

/// The picture's pixels, each red, green and blue.
fn picture(app: &mut App, target: &Handle<Image>) -> Vec<[u8; 3]> {
    for _ in 0..3 {
        headless::frame(app);
    }
    let texels = capture::read_image(app, target).unwrap_or_else(|error| panic!("{error}"));
    texels
        .bytes
        .chunks(4)
        .map(|texel| [texel[0], texel[1], texel[2]])
        .collect()
}

fn differing(a: &[[u8; 3]], b: &[[u8; 3]]) -> f32 {
    let different = |(a, b): &(&[u8; 3], &[u8; 3])| (0..3).any(|i| a[i].abs_diff(b[i]) > 8);
    a.iter().zip(b).filter(different).count() as f32 / a.len() as f32
}

#[test]
fn a_room_is_loaded_played_and_seen() {
    let assets = asset_root(None).unwrap_or_else(|error| panic!("{error}"));
    let mut app = headless::app(&assets).unwrap_or_else(|error| panic!("{error}"));
    app.add_plugins((
        LevelPlugin { assets },
        UmbragePlugins,
        DemoPlugin {
            scene: SceneSource::level("room/plane_box"),
            scenes: vec![],
            technique: "lispsm:size=1024".parse().unwrap_or_else(|error| panic!("{error}")),
        },
    ));
    headless::finish(&mut app);
    let frames = (0..600).take_while(|_| {
        headless::frame(&mut app);
        let activity = app.world().get_resource::<State<Activity>>();
        activity.is_none_or(|activity| *activity.get() == Activity::Starting)
    });
    assert!(frames.count() < 600, "still loading");

    let target = capture::readable_target(SIZE.x, SIZE.y, TextureFormat::Rgba8UnormSrgb);
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(target);
    let world = app.world_mut();
    let player = world
        .query_filtered::<Entity, With<Player>>()
        .single(world)
        .expect("one player");
    world
        .entity_mut(player)
        .insert((RenderTarget::Image(target.clone().into()), IsDefaultUiCamera));
    for _ in 0..3 {
        headless::frame(&mut app);
    }
    let with_hud = picture(&mut app, &target);

    let world = app.world_mut();
    let hud = world
        .query_filtered::<Entity, With<HudRoot>>()
        .single(world)
        .expect("one head-up display");
    world.entity_mut(hud).insert(Visibility::Hidden);
    let without = picture(&mut app, &target);
    let corner = |picture: &[[u8; 3]]| picture[30 * SIZE.x as usize + 20];
    assert!(
        corner(&with_hud).iter().all(|channel| *channel < 120),
        "a dark panel: {:?}",
        corner(&with_hud)
    );
    let share = differing(&with_hud, &without);
    assert!(
        (0.05..0.95).contains(&share),
        "the display covers {share} of the picture"
    );
    let first = without[0];
    assert!(
        differing(&without, &vec![first; without.len()]) > 0.1,
        "the room is one color"
    );

    app.world_mut().resource_mut::<Chosen>().0 = Technique::Bevy(StockBias::default());
    let stock = picture(&mut app, &target);
    let share = differing(&stock, &without);
    assert!(share < 0.2, "the techniques differ by more than their edges: {share}");
}
