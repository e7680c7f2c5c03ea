//! Panes of glass one behind the other: each has the shadow that an opaque board in its place has.

use bevy::{
    camera::{Hdr, Viewport},
    core_pipeline::tonemapping::DebandDither,
    light::NotShadowCaster,
    prelude::*,
    render::{RenderApp, sync_world::RenderEntity},
};
use umbrage::{prelude::*, render::transparent::TransparentSurfaces};

use crate::harness::{Harness, WARM_UP, eye};

const SIZE: UVec2 = UVec2::new(160, 90);
/// Onto the panes from the side of the camera, so that the slab over them shadows a part of each.
const LIGHT: Vec3 = Vec3::new(-0.5, -0.7, -0.5);
const ALPHA: f32 = 0.5;
/// From the farthest to the nearest: places and colours.
const PANES: [(Vec3, Color); 3] = [
    (Vec3::new(0.6, 1.5, -1.5), Color::srgb(0.9, 0.5, 0.4)),
    (Vec3::new(0.0, 1.5, -0.5), Color::srgb(0.4, 0.9, 0.5)),
    (Vec3::new(-0.6, 1.5, 0.5), Color::srgb(0.5, 0.4, 0.9)),
];

struct Panes {
    harness: Harness,
    sun: Entity,
    /// In the order of [`PANES`].
    panes: [Entity; 3],
}

impl Panes {
    /// Ground, a slab over the panes, and a post between the nearest two.
    fn new(technique: &str, is_unlit: bool) -> Self {
        let mut harness = Harness::new(SIZE, eye());
        let stone = harness.material(Color::srgb(0.6, 0.6, 0.6));
        let ground = harness.mesh(Plane3d::default().mesh().size(60.0, 60.0));
        let slab = harness.mesh(Cuboid::new(2.0, 0.2, 4.0));
        let post = harness.mesh(Cuboid::new(0.3, 2.5, 0.3));
        let pane = harness.mesh(Rectangle::new(6.0, 1.6));
        let panes = PANES.map(|(place, color)| {
            // Bevy sorts by it, too: only the nearest may have one.
            let depth_bias = if place.z > 0.0 { 16.0 } else { 0.0 };
            let material = harness.material(StandardMaterial {
                base_color: color.with_alpha(ALPHA),
                alpha_mode: AlphaMode::Blend,
                unlit: is_unlit,
                depth_bias,
                ..default()
            });
            let pane = (Mesh3d(pane.clone()), MeshMaterial3d(material), NotShadowCaster);
            let place = Transform::from_translation(place);
            harness.app.world_mut().spawn((pane, place)).id()
        });
        harness
            .app
            .world_mut()
            .entity_mut(harness.camera)
            .insert(DebandDither::Disabled);
        let world = harness.app.world_mut();
        for (mesh, place) in [
            (ground, Vec3::ZERO),
            (slab, Vec3::new(0.0, 3.0, 0.0)),
            (post, Vec3::new(1.5, 1.25, 0.0)),
        ] {
            let material = MeshMaterial3d(stone.clone());
            world.spawn((Mesh3d(mesh), material, Transform::from_translation(place)));
        }
        world.insert_resource(GlobalAmbientLight {
            brightness: 100.0,
            ..default()
        });
        let sun = harness.sun(LIGHT, settings(technique));
        harness.start();
        Self { harness, sun, panes }
    }

    fn use_technique(&mut self, technique: &str) {
        let settings = settings(technique);
        self.harness.app.world_mut().entity_mut(self.sun).insert(settings);
        self.harness.frames(WARM_UP);
    }

    fn show(&mut self, visible: [bool; 3]) {
        for (pane, is_visible) in self.panes.into_iter().zip(visible) {
            let visibility = if is_visible {
                Visibility::Visible
            } else {
                Visibility::Hidden
            };
            self.harness.app.world_mut().entity_mut(pane).insert(visibility);
        }
        self.harness.frames(WARM_UP);
    }

    /// Opaque boards instead of glass.
    fn become_boards(&mut self) {
        for (pane, (_, color)) in self.panes.into_iter().zip(PANES) {
            let board = self.harness.material(color);
            self.harness
                .app
                .world_mut()
                .entity_mut(pane)
                .insert(MeshMaterial3d(board));
        }
        self.harness.frames(WARM_UP);
    }

    /// Numbers of 0..=255 as the picture holds them.
    fn picture(&self) -> Vec<[u8; 3]> {
        let app = &self.harness.app;
        let picture = umbrage::render::capture::read_image(app, &self.harness.target).expect("the picture can be read");
        let (texels, _) = picture.bytes.as_chunks::<4>();
        texels
            .iter()
            .map(|[red, green, blue, _]| [*red, *green, *blue])
            .collect()
    }

    fn layers(&self) -> usize {
        let camera = self.harness.app.world().get::<RenderEntity>(self.harness.camera);
        let camera = camera.expect("it is drawn").id();
        let render_world = self.harness.app.sub_app(RenderApp).world();
        let surfaces = render_world.get::<TransparentSurfaces>(camera);
        surfaces.map_or(0, |surfaces| surfaces.layers.len())
    }
}

fn settings(technique: &str) -> SunShadows {
    match technique.parse() {
        Ok(Technique::Umbrage(settings)) => settings,
        other => panic!("{technique} is no technique of Umbrage: {other:?}"),
    }
}

fn with(technique: &str, keys: &str) -> String {
    let separator = if technique.contains(':') { "," } else { ":" };
    format!("{technique}{separator}{keys}")
}

/// The largest difference of a channel.
fn difference(a: [u8; 3], b: [u8; 3]) -> u8 {
    let channels = a.into_iter().zip(b);
    channels.map(|(a, b)| a.abs_diff(b)).max().unwrap_or_default()
}

/// A pane over what is behind it: Bevy blends what it has tone mapped.
fn blended(behind: [u8; 3], pane: [u8; 3]) -> [u8; 3] {
    let linear = |channel: u8| Srgba::gamma_function(f32::from(channel) / 255.0);
    std::array::from_fn(|channel| {
        let light = linear(pane[channel]) * ALPHA + linear(behind[channel]) * (1.0 - ALPHA);
        (Srgba::gamma_function_inverse(light) * 255.0).round() as u8
    })
}

#[test]
fn every_pane_has_the_shadow_of_a_board() {
    for technique in [
        "zp4+lispsm:size=512",
        "fitted:n=8,tile_max=256",
        "queried:min=0,max=16,tile=64,tile_max=256",
    ] {
        let mut panes = Panes::new(&with(technique, "fallback=off"), false);
        let through_lit = {
            panes.use_technique(&with(technique, "transparent_layer=nearest,fallback=off"));
            panes.picture()
        };
        panes.use_technique(&with(technique, "transparent_layer=all,fallback=off"));
        assert_eq!(panes.layers(), 4, "{technique}");
        let found = panes.picture();
        if technique.starts_with("fitted") {
            // A mapping map has the needs of one picture: all pixels are collected in its place.
            let keys = "map=64,transparent_layer=all,fallback=off";
            panes.use_technique(&with(technique, keys));
            assert!(panes.picture() == found, "{keys}: another picture");
            panes.use_technique(&with(technique, "transparent_layer=all,fallback=off"));
        }

        panes.become_boards();
        assert_eq!(panes.layers(), 0, "{technique}: nothing is transparent");
        panes.show([false; 3]);
        let empty = panes.picture();
        let mut expected = empty.clone();
        let mut covered = vec![0; expected.len()];
        for pane in 0..3 {
            panes.show([0, 1, 2].map(|other| other == pane));
            for (pixel, board) in panes.picture().into_iter().enumerate() {
                if difference(board, empty[pixel]) > 0 {
                    expected[pixel] = blended(expected[pixel], board);
                    covered[pixel] += 1;
                }
            }
        }
        let count = |found: &[[u8; 3]], behind: usize| {
            let pixels = (0..found.len()).filter(|pixel| covered[*pixel] >= behind);
            let off = pixels
                .clone()
                .filter(|pixel| difference(found[*pixel], expected[*pixel]) > 5);
            (off.count(), pixels.count())
        };
        let (off, pixels) = count(&found, 1);
        let (off_nearest, behind) = count(&through_lit, 2);
        println!("{technique}: {off} of {pixels} pixels of glass are off; nearest: {off_nearest} of {behind}");
        assert!(behind > 400, "{technique}: {behind} pixels of two panes or more");
        // Planes come from depths alone, those of a board from its normals too, and fitted maps are as fine as the picture
        // needs: pixels at edges.
        assert!(off * 25 <= pixels, "{technique}: {off} of {pixels} pixels are off");
        assert!(
            off_nearest * 10 > behind,
            "{technique}: panes behind others have another shadow with the nearest layer alone"
        );
    }
}

/// Unlit glass knows no shadow: drawn layer by layer it looks as Bevy draws it, in every kind of picture.
#[test]
fn layers_are_blended_as_bevy_blends_them() {
    let plain = "zp2+lispsm:size=256,fallback=off";
    for picture in ["whole", "hdr", "viewport"] {
        let mut panes = Panes::new(plain, true);
        let mut camera = panes.harness.app.world_mut().entity_mut(panes.harness.camera);
        match picture {
            "hdr" => {
                camera.insert(Hdr);
            }
            "viewport" => {
                let mut settings = camera.get_mut::<Camera>().expect("a camera");
                settings.viewport = Some(Viewport {
                    physical_position: UVec2::new(30, 10),
                    physical_size: UVec2::new(100, 70),
                    ..default()
                });
            }
            _ => {}
        }
        panes.harness.frames(WARM_UP);
        let expected = panes.picture();
        panes.show([false; 3]);
        let empty = panes.picture();
        panes.show([true; 3]);
        let glass = expected
            .iter()
            .zip(&empty)
            .filter(|(a, b)| difference(**a, **b) > 0)
            .count();
        assert!(glass > 300, "{picture}: {glass} pixels of glass");

        let off = |panes: &mut Panes, layers: u32| {
            panes.use_technique(&with(
                plain,
                &format!("transparent_layer=all,transparent_layers={layers}"),
            ));
            let pixels = panes.picture().into_iter().zip(&expected);
            pixels
                .filter(|(found, expected)| difference(*found, **expected) > 1)
                .count()
        };
        let missed = off(&mut panes, 3);
        assert_eq!(missed, 0, "{picture}: pixels that are not as Bevy draws them");
        if picture == "whole" {
            assert_eq!(off(&mut panes, 8), 0, "more layers than panes");
            let missed = off(&mut panes, 2);
            assert!(
                missed > 50,
                "what is behind the last layer is not drawn: {missed} pixels"
            );
        }
    }
}
