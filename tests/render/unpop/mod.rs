//! Levels of detail that fade: the states of Unpopping on pixels, its conditions, its order among other things.

use std::sync::Arc;

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::{
        core_3d::Transparent3d,
        tonemapping::{DebandDither, Tonemapping},
    },
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
    render::{RenderApp, render_phase::ViewSortedRenderPhases},
};
use umbrage::{
    lod::{
        LodCounts,
        chain::{LodChain, LodState},
        settings::{LodDriver, LodKind, LodSettings, LodTransition},
    },
    maths::lod::{
        blend::{BlendKind, Layer, Pixel, blended},
        crossing::Shown,
        energy::linear_light,
        selection::{LodBorders, LodMetric},
    },
    prelude::*,
    render::{capture, unpop::draw::DrawFading},
};

use crate::harness::{Harness, WARM_UP};

mod crowns;
mod kinds;
mod shadows;

const SIZE: UVec2 = UVec2::new(96, 54);
const BORDER: f64 = 10.0;
const BAND: f64 = 2.0;
const TIMES: [f64; 6] = [0.0, 0.25, 0.4995, 0.5, 0.75, 1.0];
const BACKGROUND: Color = Color::srgb(1.0, 1.0, 1.0);

/// A camera that looks along −z at the origin, before a white sky, with colours as they are.
fn stage() -> Harness {
    let eye = Transform::from_xyz(0.0, 0.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut harness = Harness::new(SIZE, eye);
    let world = harness.app.world_mut();
    world.insert_resource(ClearColor(BACKGROUND));
    world
        .entity_mut(harness.camera)
        .insert((Tonemapping::None, DebandDither::Disabled));
    world.resource_mut::<LodSettings>().transition = LodTransition {
        kind: LodKind::Unpopping,
        driver: LodDriver::Distance { metres: BAND as f32 },
    };
    harness
}

fn flat(harness: &mut Harness, color: Color) -> Handle<StandardMaterial> {
    harness.material(StandardMaterial {
        base_color: color,
        unlit: true,
        ..default()
    })
}

/// Puts the eye of the levels where a crossing is so far done; the picture's camera stays.
fn set_share(harness: &mut Harness, t: f64) {
    let distance = BORDER - BAND + BAND * t;
    harness.app.world_mut().entity_mut(harness.camera).insert(LodView {
        origin: Some(Vec3::Z * distance as f32),
        ..default()
    });
}

/// An object of levels at a place, each with one part.
fn chain(harness: &mut Harness, place: Transform, levels: &[(&Handle<Mesh>, &Handle<StandardMaterial>)]) -> Entity {
    let world = harness.app.world_mut();
    let part = |(mesh, material): &(&Handle<Mesh>, &Handle<StandardMaterial>)| {
        let (mesh, material) = (Mesh3d((*mesh).clone()), MeshMaterial3d((*material).clone()));
        vec![world.spawn((mesh, material, place)).id()]
    };
    let levels = levels.iter().map(part).collect();
    let chain = LodChain {
        levels,
        borders: Arc::new(LodBorders::new([BORDER])),
        metric: LodMetric::Distance,
    };
    // Distances are all taken from the middle.
    world.spawn((Transform::default(), chain)).id()
}

fn picture(harness: &Harness) -> Vec<u8> {
    let texels = capture::read_image(&harness.app, &harness.target).expect("the picture can be read");
    texels.bytes
}

fn picture_at(harness: &mut Harness, t: f64) -> Vec<u8> {
    set_share(harness, t);
    harness.frames(3);
    picture(harness)
}

/// The three colours of a pixel.
fn pixel(picture: &[u8], x: u32, y: u32) -> [u8; 3] {
    let offset = ((y * SIZE.x + x) * 4) as usize;
    [picture[offset], picture[offset + 1], picture[offset + 2]]
}

fn largest_difference(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Code of a share of light in 8-bit sRGB.
fn code(light: f64) -> u8 {
    (0..=255)
        .min_by(|a, b| {
            (linear_light(*a) - light)
                .abs()
                .total_cmp(&(linear_light(*b) - light).abs())
        })
        .unwrap_or(0)
}

/// Rectangles across the view, centred, as (half width, half height, z), in the order of their triangles.
fn cards(rectangles: &[(f32, f32, f32)]) -> Mesh {
    let corners = |(w, h, z): &(f32, f32, f32)| [[-w, -h, *z], [*w, -h, *z], [*w, *h, *z], [-w, *h, *z]];
    let positions: Vec<[f32; 3]> = rectangles.iter().flat_map(corners).collect();
    let count = positions.len();
    let indices = (0..rectangles.len() as u32).flat_map(|i| [0, 1, 2, 0, 2, 3].map(|corner| 4 * i + corner));
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; count])
        .with_inserted_indices(Indices::U32(indices.collect()))
}

/// Giegl, figure 7.2, on the GPU: a narrow level 0 and a wide level 1, either of them in front, against the CPU twin. In the
/// middle nothing of the white background shines through, beside the narrow one the wide one blends with it.
#[test]
fn the_table_of_states_on_pixels() {
    let (fine, coarse) = ([0.2, 0.05, 0.0], [0.0, 0.4, 0.7]);
    for (z_fine, z_coarse) in [(0.3, 0.0), (0.0, 0.3)] {
        let mut harness = stage();
        let [fine_color, coarse_color] = [fine, coarse].map(|c| Color::linear_rgb(c[0], c[1], c[2]));
        let (fine_material, coarse_material) = (flat(&mut harness, fine_color), flat(&mut harness, coarse_color));
        let narrow = harness.mesh(cards(&[(0.5, 1.0, z_fine)]));
        let wide = harness.mesh(cards(&[(1.5, 1.0, z_coarse)]));
        chain(
            &mut harness,
            Transform::default(),
            &[(&narrow, &fine_material), (&wide, &coarse_material)],
        );
        harness.start();
        for kind in [LodKind::Unpopping, LodKind::Plain] {
            harness.app.world_mut().resource_mut::<LodSettings>().transition.kind = kind;
            for t in TIMES {
                let shown = picture_at(&mut harness, t);
                for (x, is_rim) in [(48, false), (59, true)] {
                    for channel in 0..3 {
                        let layer = |z: f32, color: f32| {
                            [Layer {
                                depth: z.into(),
                                color: color.into(),
                            }]
                        };
                        let old = layer(z_fine, fine[channel]);
                        let new = layer(z_coarse, coarse[channel]);
                        let old: &[Layer] = if is_rim { &[] } else { &old };
                        let sky = Pixel {
                            color: 1.0,
                            depth: -1.0,
                        };
                        let blend = if kind == LodKind::Plain {
                            BlendKind::Plain
                        } else {
                            BlendKind::Unpopping
                        };
                        let expected = code(blended(sky, [old, &new], [0, 1], blend, t, true).color);
                        let got = pixel(&shown, x, 27)[channel];
                        // One step of rounding per blend, and one of alpha.
                        assert!(
                            got.abs_diff(expected) <= 3,
                            "{kind:?}, fine one at {z_fine}, t {t}, x {x}, channel {channel}: {got}, not {expected}"
                        );
                    }
                }
            }
        }
    }
}

/// What the fading level lacks of opaque just before the roles change, at t = 0.4995: its alpha 2 t has 1023 steps. No light
/// differs by more than this share of white then, in no channel. In codes that is up to 3, as those of dark light are close.
const LAST_STEP: f64 = 1.0 / 1023.0;

/// The largest change of light when the roles change, beyond what the rounding of either picture explains.
fn jump(harness: &mut Harness) -> f64 {
    let before = picture_at(harness, 0.4995);
    let after = picture_at(harness, 0.5);
    let border = |code: u8| 0.5 * (linear_light(code) + linear_light(code + 1));
    let changes = before.iter().zip(&after).enumerate().map(|(at, (a, b))| {
        let (dark, bright) = (*a.min(b), *a.max(b));
        let least = if dark == bright {
            0.0
        } else {
            border(bright - 1) - border(dark)
        };
        (least, at, *a, *b)
    });
    let (jump, at, a, b) = changes.max_by(|a, b| a.0.total_cmp(&b.0)).expect("pixels");
    let (pixel, channel) = (at as u32 / 4, at % 4);
    println!(
        "largest jump: {jump:.5} of light, channel {channel} of ({}, {}), {a} to {b}",
        pixel % SIZE.x,
        pixel / SIZE.x
    );
    jump
}

/// The same mesh in two materials (a shader level): every pixel has equal depths.
#[test]
fn shared_surfaces_do_not_jump() {
    let mut harness = stage();
    let (red, blue) = (
        flat(&mut harness, Color::srgb(0.8, 0.1, 0.1)),
        flat(&mut harness, Color::srgb(0.1, 0.1, 0.9)),
    );
    let ball = harness.mesh(Sphere::new(1.0).mesh().uv(24, 12));
    chain(&mut harness, Transform::default(), &[(&ball, &red), (&ball, &blue)]);
    harness.start();
    let (start, end) = (picture_at(&mut harness, 0.0), picture_at(&mut harness, 1.0));
    assert!(largest_difference(&start, &end) > 150, "both levels are seen");
    assert!(jump(&mut harness) <= LAST_STEP);
}

/// Three layers in a mesh, drawn from near to far and from far to near: only the nearest, the blue one, is blended.
#[test]
fn layers_behind_the_nearest_are_not_blended() {
    let mut harness = stage();
    let (red, white) = (
        flat(&mut harness, Color::srgb(0.8, 0.1, 0.1)),
        flat(&mut harness, Color::WHITE),
    );
    let plain = harness.mesh(cards(&[(0.6, 0.6, 0.0)]));
    let (blue, green) = ([0.1, 0.1, 0.9, 1.0], [0.1, 0.8, 0.1, 1.0]);
    for (y, layers, colors) in [
        (
            0.8,
            [(0.6, 0.6, 0.6), (0.6, 0.6, 0.4), (0.6, 0.6, 0.2)],
            [blue, green, green],
        ),
        (
            -0.8,
            [(0.6, 0.6, 0.2), (0.6, 0.6, 0.4), (0.6, 0.6, 0.6)],
            [green, green, blue],
        ),
    ] {
        let colors: Vec<[f32; 4]> = colors.into_iter().flat_map(|color| [color; 4]).collect();
        let layered = cards(&layers).with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors);
        let layered = harness.mesh(layered);
        let place = Transform::from_xyz(0.0, y, 0.0);
        chain(&mut harness, place, &[(&plain, &red), (&layered, &white)]);
    }
    harness.start();
    assert!(jump(&mut harness) <= LAST_STEP);
    // Half faded, the middle is half red and half blue; with all layers it would be an eighth red, and partly green.
    let half = picture_at(&mut harness, 0.25);
    let expected = [(204, 0.1), (26, 0.1), (26, 0.9)].map(|(old, new)| code(0.5 * (linear_light(old) + new)));
    for y in [16, 38] {
        let got = pixel(&half, 48, y);
        let is_near = got
            .iter()
            .zip(expected)
            .all(|(got, expected)| got.abs_diff(expected) <= 3);
        assert!(is_near, "{got:?} at {y}, not {expected:?}");
    }
}

/// Panes of glass before and behind a fading level that nothing opaque of its object covers.
#[test]
fn fading_levels_have_their_place_among_transparent_things() {
    let mut harness = stage();
    let dark = flat(&mut harness, Color::linear_rgb(0.0, 0.0, 0.0));
    let blue = flat(&mut harness, Color::linear_rgb(0.0, 0.0, 1.0));
    let glass = harness.material(StandardMaterial {
        base_color: Color::linear_rgba(1.0, 0.0, 0.0, 0.5),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..default()
    });
    let narrow = harness.mesh(cards(&[(0.2, 1.0, 0.0)]));
    let wide = harness.mesh(cards(&[(1.5, 1.0, 0.0)]));
    chain(&mut harness, Transform::default(), &[(&narrow, &dark), (&wide, &blue)]);
    let pane = harness.mesh(cards(&[(3.0, 0.4, 0.0)]));
    for (y, z) in [(0.5, 1.0), (-0.5, -1.0)] {
        let place = Transform::from_xyz(0.0, y, z);
        harness
            .app
            .world_mut()
            .spawn((Mesh3d(pane.clone()), MeshMaterial3d(glass.clone()), place));
    }
    harness.start();
    assert!(jump(&mut harness) <= LAST_STEP);
    let half = picture_at(&mut harness, 0.25);
    // Beside the narrow level. Before: half red over half blue over white. Behind: half blue over half red over white.
    let [before, behind] = [20, 33].map(|y| pixel(&half, 59, y).map(|channel| linear_light(channel)));
    for (got, expected, what) in [
        (before, [0.75, 0.25, 0.5], "before"),
        (behind, [0.5, 0.25, 0.75], "behind"),
    ] {
        for channel in 0..3 {
            let difference = (got[channel] - expected[channel]).abs();
            assert!(difference < 0.02, "glass {what}: {got:?}, not {expected:?}");
        }
    }
}

#[test]
fn crossings_turn_back_and_end() {
    let mut harness = stage();
    let (red, blue) = (
        flat(&mut harness, Color::srgb(0.8, 0.1, 0.1)),
        flat(&mut harness, Color::srgb(0.1, 0.1, 0.9)),
    );
    let card = harness.mesh(cards(&[(1.0, 1.0, 0.0)]));
    let chain = chain(&mut harness, Transform::default(), &[(&card, &red), (&card, &blue)]);
    let world = harness.app.world_mut();
    world.resource_mut::<LodSettings>().transition.driver = LodDriver::Time { seconds: 0.4 };
    set_share(&mut harness, -1.0);
    harness.start();
    let near = picture(&harness);
    let shown = |harness: &Harness| harness.app.world().get::<LodState>(chain).and_then(LodState::shown);
    assert_eq!(shown(&harness), Some(Shown::Level(0)));
    set_share(&mut harness, 1.5);
    let mut last = pixel(&near, 48, 27)[0];
    for _ in 0..7 {
        harness.frames(1);
        let red = pixel(&picture(&harness), 48, 27)[0];
        assert!(red <= last, "red fades: {last}, then {red}");
        last = red;
    }
    let Some(Shown::Crossing(crossing)) = shown(&harness) else {
        panic!("7 frames of 24 are a crossing: {:?}", shown(&harness));
    };
    assert!((crossing.t - 7.0 / 24.0).abs() < 0.05, "{crossing:?}");
    assert_eq!(harness.app.world().resource::<LodCounts>().fading_parts, 1);
    set_share(&mut harness, -1.0);
    harness.frames(1);
    let turned = pixel(&picture(&harness), 48, 27)[0];
    assert!(turned >= last, "red comes back: {last}, then {turned}");
    harness.frames(8);
    assert_eq!(shown(&harness), Some(Shown::Level(0)));
    harness.frames(1);
    assert_eq!(picture(&harness), near, "nothing is left of the crossing");
    assert_eq!(harness.app.world().resource::<LodCounts>().crossings, 0);
}

/// Objects of one mesh and material that fade at once, each with an alpha of its own, are one draw; others cost nothing.
#[test]
fn fading_objects_share_their_draw() {
    let mut harness = stage();
    let (red, blue) = (
        flat(&mut harness, Color::srgb(0.8, 0.1, 0.1)),
        flat(&mut harness, Color::srgb(0.1, 0.1, 0.9)),
    );
    let card = harness.mesh(cards(&[(0.1, 0.1, 0.0)]));
    for i in 0..20 {
        let place = Transform::from_xyz(-2.0 + 0.2 * i as f32, 0.0, 0.0);
        chain(&mut harness, place, &[(&card, &red), (&card, &blue)]);
    }
    harness.start();
    let draws = |harness: &Harness| {
        let world = harness.app.sub_app(RenderApp).world();
        let fading = world.resource::<bevy::render::render_phase::DrawFunctions<Transparent3d>>();
        let fading = fading.read().get_id::<DrawFading>();
        let phases = world.resource::<ViewSortedRenderPhases<Transparent3d>>();
        let phase = phases.values().next().expect("a camera");
        // An item stands for as many as its range holds.
        let mut lengths = Vec::new();
        let mut index = 0;
        while let Some((_, item)) = phase.items.get_index(index) {
            let length = item.batch_range.len();
            if Some(item.draw_function) == fading && length > 0 {
                lengths.push(length);
            }
            index += length.max(1);
        }
        lengths
    };
    picture_at(&mut harness, 0.0);
    assert_eq!(draws(&harness), Vec::<usize>::new(), "nothing fades at rest");
    picture_at(&mut harness, 0.3);
    assert_eq!(draws(&harness), [20]);
    assert_eq!(harness.app.world().resource::<LodCounts>().fading_parts, 20);
}

/// What stands beside a crossing keeps its shadows, bit by bit.
#[test]
fn other_shadows_stay_as_they_are() {
    let mut harness = stage();
    let material = harness.material(Color::srgb(0.5, 0.5, 0.5));
    let (small, large) = (
        harness.mesh(Cuboid::new(0.5, 0.5, 0.5)),
        harness.mesh(Cuboid::new(0.6, 0.6, 0.6)),
    );
    let place = Transform::from_xyz(1.5, 0.0, 0.0);
    chain(&mut harness, place, &[(&small, &material), (&large, &material)]);
    let wall = harness.mesh(cards(&[(2.5, 1.5, -0.5)]));
    let post = harness.mesh(Cuboid::new(0.2, 2.0, 0.2));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(wall), MeshMaterial3d(material.clone())));
    world.spawn((
        Mesh3d(post),
        MeshMaterial3d(material),
        Transform::from_xyz(-1.5, 0.0, 0.0),
    ));
    harness.sun(Vec3::new(0.3, -0.2, -1.0), SunShadows::LOW);
    harness.start();
    let left = |harness: &Harness| {
        let result = harness.shadow_result(harness.camera);
        let rows = result.chunks(SIZE.x as usize);
        rows.flat_map(|row| row[..40].to_vec()).collect::<Vec<f32>>()
    };
    set_share(&mut harness, 0.0);
    harness.frames(WARM_UP);
    let rest = left(&harness);
    assert!(rest.contains(&0.0) && rest.contains(&1.0), "the post casts a shadow");
    for t in [0.3, 0.5, 0.8, 1.0] {
        set_share(&mut harness, t);
        harness.frames(2);
        assert_eq!(left(&harness), rest, "t {t}");
    }
}
