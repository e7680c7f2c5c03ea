//! The whole game on a GPU without a window: loading, then play with the head-up display, as pictures.

use bevy::{
    camera::RenderTarget,
    input::{
        ButtonState,
        keyboard::{Key, KeyboardInput, NativeKey},
    },
    prelude::*,
    render::render_resource::TextureFormat,
    ui::IsDefaultUiCamera,
};
use umbrage::{
    cli::headless,
    demo::{DemoPlugin, overlay::Overlay, player::Player, screens::Activity, technique::Chosen},
    level::{LevelPlugin, find::asset_root, scene::SceneSource},
    render::{
        UmbragePlugins, capture,
        heat_map::TexelHeatMap,
        mask::{MaskPlugin, ShadowMask},
    },
    shadow::technique::{StockBias, Technique},
    ui::{hud::HudRoot, judge::JudgeRoot},
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

/// Presses and releases a key.
fn press(app: &mut App, key_code: KeyCode) {
    for state in [ButtonState::Pressed, ButtonState::Released] {
        app.world_mut().write_message(KeyboardInput {
            key_code,
            logical_key: Key::Unidentified(NativeKey::Unidentified),
            state,
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        });
        headless::frame(app);
    }
}

fn count<C: Component>(app: &mut App) -> usize {
    let world = app.world_mut();
    world.query::<&C>().iter(world).count()
}

#[test]
fn a_room_is_loaded_played_and_seen() {
    let assets = asset_root(None).unwrap_or_else(|error| panic!("{error}"));
    let mut app = headless::app(&assets).unwrap_or_else(|error| panic!("{error}"));
    app.add_plugins((
        LevelPlugin { assets },
        UmbragePlugins,
        MaskPlugin,
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
    // Not by visibility: that comes back with every frame.
    let mut node = world.get_mut::<Node>(hud).expect("a node");
    node.display = Display::None;
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

    *app.world_mut().resource_mut::<Overlay>() = Overlay::TexelRatio;
    let colored = picture(&mut app, &target);
    assert_eq!(count::<TexelHeatMap>(&mut app), 1);
    assert!(differing(&colored, &stock) > 0.2, "colors over the room");
    *app.world_mut().resource_mut::<Overlay>() = Overlay::Off;
    assert!(
        differing(&picture(&mut app, &target), &stock) < 0.01,
        "no colors are left"
    );
    assert_eq!(count::<TexelHeatMap>(&mut app), 0);

    app.world_mut().resource_mut::<Chosen>().0 = Technique::default();
    press(&mut app, KeyCode::KeyJ);
    let frames = (0..200).take_while(|_| {
        headless::frame(&mut app);
        count::<JudgeRoot>(&mut app) == 0
    });
    assert!(frames.count() < 200, "still judging");
    assert!(app.world().resource::<Time<Virtual>>().is_paused(), "time goes on");
    let panels: Vec<Handle<Image>> = {
        let world = app.world_mut();
        let mut images = world.query::<&ImageNode>();
        images.iter(world).map(|node| node.image.clone()).collect()
    };
    assert_eq!(panels.len(), 3, "technique, truth and difference");
    let judged = picture(&mut app, &target);
    assert!(differing(&judged, &stock) > 0.5, "the pictures cover the window");
    // Truth is white, black and blue; the room has a lit plane and a shadow.
    let column = |range: std::ops::Range<u32>| {
        let x = range.start * SIZE.x / 6..range.end * SIZE.x / 6;
        judged
            .iter()
            .zip(0..)
            .filter(move |(_, index)| x.contains(&(index % SIZE.x)))
            .map(|(pixel, _)| *pixel)
    };
    for (columns, name) in [(0..2, "technique"), (2..4, "truth")] {
        let lit = column(columns.clone())
            .filter(|pixel| pixel.iter().all(|channel| *channel > 240))
            .count();
        assert!(lit > 300, "{name}: {lit} lit pixels");
    }
    press(&mut app, KeyCode::KeyJ);
    for _ in 0..3 {
        headless::frame(&mut app);
    }
    assert_eq!((count::<JudgeRoot>(&mut app), count::<ShadowMask>(&mut app)), (0, 0));
    assert!(
        !app.world().resource::<Time<Virtual>>().is_paused(),
        "time stands still"
    );
}
