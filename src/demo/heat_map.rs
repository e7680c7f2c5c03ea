//! Overlays in color of the player's camera: texel ÷ pixel, texels per pixel and which map is read ([`TexelHeatMap`]), the
//! tiles of virtual maps ([`TileOverlay`]) and the needs of fitted ones ([`NeedOverlay`]).

use bevy::{core_pipeline::prepass::NormalPrepass, prelude::*};

use super::{overlay::Overlay, player::Player, screens::Screen};
use crate::{
    level::Sun,
    render::{
        heat_map::{HeatColors, TexelHeatMap},
        light_maps::LightMaps,
        virtual_map::{fitted::overlay::NeedOverlay, overlay::TileOverlay},
    },
    shadow::settings::{ShadowPath, SunShadows},
};

/// The picture stays recognizable below the colors.
const OPACITY: f32 = 0.7;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(Last, follow_overlay.run_if(in_state(Screen::Play)));
}

/// After everything that computes light views, once per frame.
fn follow_overlay(world: &mut World) {
    let camera = world.query_filtered::<Entity, With<Player>>().single(world);
    let sun = world.query_filtered::<Entity, With<Sun>>().iter(world).next();
    let (Ok(camera), Some(sun)) = (camera, sun) else {
        return;
    };
    let overlay = *world.resource::<Overlay>();
    if overlay == Overlay::Tiles {
        world.entity_mut(camera).insert(TileOverlay { opacity: OPACITY });
    } else if world.get::<TileOverlay>(camera).is_some() {
        world.entity_mut(camera).remove::<TileOverlay>();
    }
    if overlay == Overlay::Needs {
        world.entity_mut(camera).insert(NeedOverlay { opacity: OPACITY });
    } else if world.get::<NeedOverlay>(camera).is_some() {
        world.entity_mut(camera).remove::<NeedOverlay>();
    }
    if overlay.is_heat_map() {
        let heat_map = heat_map(world, sun, camera, overlay);
        world.entity_mut(camera).insert(heat_map);
    } else if world.get::<TexelHeatMap>(camera).is_some() {
        world.entity_mut(camera).remove::<TexelHeatMap>();
        let needs_normals = world
            .get::<SunShadows>(sun)
            .is_some_and(|settings| settings.path == ShadowPath::Full);
        if !needs_normals {
            world.entity_mut(camera).remove::<NormalPrepass>();
        }
    }
}

fn heat_map(world: &World, sun: Entity, camera: Entity, overlay: Overlay) -> TexelHeatMap {
    TexelHeatMap {
        light_maps: match overlay {
            Overlay::TexelRatioBefore => LightMaps::before_films(world, sun, camera),
            _ => LightMaps::of(world, sun, camera),
        },
        colors: match overlay {
            Overlay::SamplingRate(measure) => HeatColors::SamplingRate(measure),
            Overlay::Maps => HeatColors::Maps,
            _ => HeatColors::TexelRatio,
        },
        direction_to_light: world.get::<GlobalTransform>(sun).map_or(Vec3::Y, |place| *place.back()),
        opacity: OPACITY,
    }
}
