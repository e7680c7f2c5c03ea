//! The maps of a sun as the frame just drawn looked them up: [`LightMaps`].

use bevy::{
    light::{CascadeShadowConfig, Cascades, DirectionalLightShadowMap},
    math::{DMat4, DVec2, DVec3, Vec3Swizzles},
    prelude::*,
};

use super::virtual_map::report::VirtualMapReports;
use crate::{
    maths::{
        footprint::texel_footprint,
        virtual_map::tile::{Tile, TileWindow, map_uv},
    },
    shadow::{
        checked::checked,
        light_plane::LightPlaneStates,
        settings::{Faces, PartitionSelection, ShadowPath, SunShadows},
        views::{LightView, SunViews},
    },
};

/// One map that is drawn and looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightMap {
    /// World to light clip space.
    pub clip_from_world: DMat4,
    /// Texels across and along the map's axes; those of a tile without its margins.
    pub size: UVec2,
    /// View depth in metres from which the map is meant to be used.
    pub near_depth: f64,
    /// View depth up to which it is.
    pub far_depth: f64,
}

/// How a pixel finds its map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// The first map that ends behind the pixel and contains it, the last one in any case where it contains it
    /// (`apply_views.wgsl`).
    Depth,
    /// The first map that contains the pixel; maps are in the order of their resolution (`apply_views.wgsl`).
    BestResolution,
    /// Of the maps that contain the pixel the one with the most texels around it (`apply_views.wgsl`).
    Finest,
    /// Bevy's: the first map that ends behind the pixel, whether it contains it or not. Where two cascades are blended, the
    /// finer one counts.
    Cascades,
    /// The last tile of a virtual map that contains the pixel (`apply_tile.wgsl`).
    LastTile,
}

/// All maps of one sun and one camera, near to far.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMaps {
    /// Those that are looked up; fallback maps for transparent surfaces are not among them.
    pub maps: Vec<LightMap>,
    /// How they are looked up.
    pub selection: Selection,
    /// View depth in metres from which everything is lit.
    pub distance: f64,
    /// The virtual maps whose tiles the maps are.
    pub virtual_maps: Option<WholeMaps>,
}

/// A virtual map, or one per z-partition.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeMaps {
    /// The whole of each, at the resolution of the finest tile of all; nearest first.
    pub maps: Vec<LightMap>,
    /// What each of the light maps is: the index of the whole, and the tile.
    pub tiles: Vec<(usize, Tile)>,
    /// Texels drawn, margins included.
    pub texels: u64,
}

impl WholeMaps {
    /// The map that a view depth belongs to: the first that ends behind it, else the last.
    fn of_depth(&self, view_depth: f64) -> usize {
        let last = self.maps.len().saturating_sub(1);
        let found = self.maps.iter().position(|map| view_depth < map.far_depth);
        found.unwrap_or(last)
    }
}

impl LightMaps {
    /// The maps of the frame just drawn. Empty for a camera or a light that has none.
    pub fn of(world: &World, sun: Entity, camera: Entity) -> Self {
        match world.get::<SunShadows>(sun) {
            Some(settings) if settings.path == ShadowPath::Full => Self::of_full_path(world, sun, camera, settings),
            _ => Self::of_cascades(world, sun, camera),
        }
    }

    /// One uniform map of as many texels over what the light planes of the frame cover: what films are measured against.
    /// Empty without light planes.
    pub fn before_films(world: &World, sun: Entity, camera: Entity) -> Self {
        let settings = world.get::<SunShadows>(sun);
        let states = world.get::<LightPlaneStates>(sun);
        let state = states.and_then(|states| states.cameras.get(&camera));
        let unbent = state.and_then(|state| state.unbent.as_ref());
        let maps = settings.zip(unbent).map(|(settings, light_view)| LightMap {
            clip_from_world: light_view.clip_from_world.as_dmat4(),
            size: UVec2::splat(checked(settings).0.map_size),
            near_depth: f64::from(light_view.near_depth),
            far_depth: f64::from(light_view.far_depth),
        });
        Self {
            maps: maps.into_iter().collect(),
            selection: Selection::BestResolution,
            distance: f64::INFINITY,
            virtual_maps: None,
        }
    }

    fn of_full_path(world: &World, sun: Entity, camera: Entity, settings: &SunShadows) -> Self {
        let (settings, _) = checked(settings);
        let views = world.get::<SunViews>(sun).and_then(|views| views.cameras.get(&camera));
        if settings.maps.is_virtual() {
            let partitions = views.map_or(&[][..], |views| &views.partitions);
            let light_views: Vec<&LightView> = partitions.iter().map(|partition| &partition.light_view).collect();
            return Self::of_virtual_maps(world, camera, &light_views);
        }
        let maps = views
            .into_iter()
            .flat_map(|views| &views.partitions)
            .map(|partition| LightMap {
                clip_from_world: partition.light_view.clip_from_world.as_dmat4(),
                size: partition.light_view.atlas_rect.zw(),
                near_depth: f64::from(partition.light_view.near_depth),
                far_depth: f64::from(partition.light_view.far_depth),
            });
        Self {
            maps: maps.collect(),
            selection: match (settings.partitions.faces, settings.selection) {
                _ if settings.light_planes.is_some() => Selection::Finest,
                (Faces::Apart { .. }, _) => Selection::Finest,
                (Faces::Together, PartitionSelection::Depth) => Selection::Depth,
                (Faces::Together, PartitionSelection::BestResolution) => Selection::BestResolution,
                (Faces::Together, PartitionSelection::Finest) => Selection::Finest,
            },
            distance: views.map_or(0.0, |views| f64::from(views.far_depth)),
            virtual_maps: None,
        }
    }

    /// The tiles that the last frame drew.
    fn of_virtual_maps(world: &World, camera: Entity, light_views: &[&LightView]) -> Self {
        let report = world
            .get_resource::<VirtualMapReports>()
            .and_then(|reports| reports.get(camera))
            .unwrap_or_default();
        let size = UVec2::splat(u32::try_from(report.effective_resolution()).unwrap_or(u32::MAX));
        let whole = |light_view: &&LightView| LightMap {
            clip_from_world: light_view.clip_from_world.as_dmat4(),
            size,
            near_depth: f64::from(light_view.near_depth),
            far_depth: f64::from(light_view.far_depth),
        };
        let wholes: Vec<LightMap> = light_views.iter().map(whole).collect();
        // A frame without a light view draws no tile.
        let tiles = || {
            report.tiles.iter().filter_map(|drawn| {
                let index = drawn.draw.light_view as usize;
                Some((index, wholes.get(index)?, &drawn.draw))
            })
        };
        let maps = tiles().map(|(_, whole, draw)| {
            let core = TileWindow::of_size(draw.window.core(), 0);
            LightMap {
                clip_from_world: draw.tile.clip_from_world(&whole.clip_from_world, &core),
                size: core.size,
                ..*whole
            }
        });
        Self {
            maps: maps.collect(),
            selection: Selection::LastTile,
            distance: wholes.last().map_or(0.0, |whole| whole.far_depth),
            virtual_maps: (!wholes.is_empty()).then(|| WholeMaps {
                tiles: tiles().map(|(index, _, draw)| (index, draw.tile)).collect(),
                texels: report.texels(),
                maps: wholes.clone(),
            }),
        }
    }

    fn of_cascades(world: &World, sun: Entity, camera: Entity) -> Self {
        let cascades = world
            .get::<Cascades>(sun)
            .and_then(|cascades| cascades.cascades.get(&camera));
        let config = world.get::<CascadeShadowConfig>(sun);
        let size = world
            .get_resource::<DirectionalLightShadowMap>()
            .map_or(0, |map| u32::try_from(map.size).unwrap_or(u32::MAX));
        let ranges = config.into_iter().flat_map(|config| {
            let overlapped = config
                .bounds
                .iter()
                .map(|bound| bound * (1.0 - config.overlap_proportion));
            std::iter::once(config.minimum_distance)
                .chain(overlapped)
                .zip(&config.bounds)
        });
        let maps: Vec<LightMap> = cascades
            .into_iter()
            .flatten()
            .zip(ranges)
            .map(|(cascade, (near, far))| LightMap {
                clip_from_world: cascade.clip_from_world.as_dmat4(),
                size: UVec2::splat(size),
                near_depth: f64::from(near),
                far_depth: f64::from(*far),
            })
            .collect();
        Self {
            distance: maps.last().map_or(0.0, |map| map.far_depth),
            maps,
            selection: Selection::Cascades,
            virtual_maps: None,
        }
    }

    /// Texels of all maps, margins of tiles included.
    pub fn texels(&self) -> u64 {
        match &self.virtual_maps {
            Some(wholes) => wholes.texels,
            None => self
                .maps
                .iter()
                .map(|map| map.size.as_u64vec2().element_product())
                .sum(),
        }
    }

    /// The map in which the shadow of a world-space point at a view depth is looked up; `None`: it is lit without a look.
    pub fn select(&self, point_world: DVec3, view_depth: f64) -> Option<usize> {
        if view_depth >= self.distance {
            return None;
        }
        let last = self.maps.len().checked_sub(1)?;
        let mut maps = self.maps.iter().enumerate();
        let found = match self.selection {
            Selection::Depth => maps
                .find(|(index, map)| (view_depth < map.far_depth || *index == last) && map.contains(point_world, 1.0)),
            Selection::BestResolution => maps.find(|(_, map)| map.contains(point_world, 1.0)),
            Selection::Finest => maps
                .filter(|(_, map)| map.contains(point_world, 1.0))
                .max_by(|(_, a), (_, b)| a.density(point_world).total_cmp(&b.density(point_world))),
            Selection::Cascades => maps
                .find(|(_, map)| view_depth < map.far_depth)
                .filter(|(_, map)| map.contains(point_world, 0.0)),
            Selection::LastTile => return self.last_tile(point_world, view_depth),
        };
        found.map(|(index, _)| index)
    }

    fn last_tile(&self, point_world: DVec3, view_depth: f64) -> Option<usize> {
        let wholes = self.virtual_maps.as_ref()?;
        let index = wholes.of_depth(view_depth);
        let uv = map_uv(&wholes.maps.get(index)?.clip_from_world, point_world)?;
        let mut tiles = wholes.tiles.iter();
        tiles.rposition(|(whole, tile)| *whole == index && tile.contains(uv))
    }
}

impl LightMap {
    /// Whether the map holds a point, and `margin` texels around it.
    fn contains(&self, point_world: DVec3, margin: f64) -> bool {
        let clip = self.clip_from_world * point_world.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        let limit = 1.0 - 2.0 * margin / self.size.as_dvec2();
        clip.w > 0.0 && ndc.xy().abs().cmple(limit).all() && (0.0..=1.0).contains(&ndc.z)
    }

    /// Texel coordinates of a world-space point, from the map's lower left corner (y upwards, as in clip space).
    pub fn texel(&self, point_world: DVec3) -> DVec2 {
        let ndc = self.clip_from_world.project_point3(point_world);
        (ndc.xy() * 0.5 + 0.5) * self.size.as_dvec2()
    }

    /// Texels per square metre across the light at a world-space point.
    fn density(&self, point_world: DVec3) -> f64 {
        texel_footprint(&self.clip_from_world, self.size, point_world).map_or(0.0, |footprint| 1.0 / footprint.area())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of 10, 30 and 100 m around the origin, seen from above.
    fn maps(selection: Selection) -> LightMaps {
        let map = |half: f64, far_depth: f64| LightMap {
            clip_from_world: DMat4::from_cols_array_2d(&[
                [1.0 / half, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.005, 0.0],
                [0.0, -1.0 / half, 0.0, 0.0],
                [0.0, 0.0, 0.5, 1.0],
            ]),
            size: UVec2::splat(100),
            near_depth: 0.1,
            far_depth,
        };
        LightMaps {
            maps: vec![map(10.0, 8.0), map(30.0, 25.0), map(100.0, 90.0)],
            selection,
            distance: 90.0,
            virtual_maps: None,
        }
    }

    #[test]
    fn depth_takes_the_first_map_that_reaches_and_contains() {
        let maps = maps(Selection::Depth);
        let at = |x: f64| DVec3::new(x, 3.0, 0.0);
        assert_eq!(maps.select(at(5.0), 7.9), Some(0));
        assert_eq!(maps.select(at(5.0), 8.0), Some(1), "the end is not part of the range");
        assert_eq!(maps.select(at(20.0), 7.9), Some(1), "not in the first");
        // 2 % of the half width is one texel of a hundred.
        assert_eq!(maps.select(at(9.79), 1.0), Some(0));
        assert_eq!(maps.select(at(9.81), 1.0), Some(1), "within a texel of the border");
        assert_eq!(maps.select(at(5.0), 90.0), None, "beyond the distance");
        assert_eq!(maps.select(DVec3::Y * 101.0, 1.0), None, "above the depth range");
    }

    #[test]
    fn best_resolution_ignores_depth() {
        let maps = maps(Selection::BestResolution);
        assert_eq!(maps.select(DVec3::X * 5.0, 80.0), Some(0));
        assert_eq!(maps.select(DVec3::X * 50.0, 1.0), Some(2));
        assert_eq!(maps.select(DVec3::X * 99.0, 1.0), None);
    }

    #[test]
    fn the_finest_map_is_taken_wherever_it_stands_in_the_list() {
        let mut maps = maps(Selection::Finest);
        maps.maps.reverse();
        assert_eq!(maps.select(DVec3::X * 5.0, 80.0), Some(2));
        assert_eq!(maps.select(DVec3::X * 20.0, 80.0), Some(1));
        // Ten times the texels make the largest map the finest.
        maps.maps[0].size = UVec2::new(4000, 1000);
        assert_eq!(maps.select(DVec3::X * 5.0, 80.0), Some(0));
    }

    #[test]
    fn cascades_look_nowhere_else() {
        let maps = maps(Selection::Cascades);
        assert_eq!(maps.select(DVec3::X * 9.9, 7.0), Some(0), "up to the border");
        assert_eq!(
            maps.select(DVec3::X * 20.0, 7.0),
            None,
            "the chosen cascade does not hold it"
        );
        assert_eq!(maps.select(DVec3::X * 5.0, 40.0), Some(2));
    }

    /// The map of 100 m in one coarse tile, of which a quarter was refined.
    #[test]
    fn virtual_maps_take_the_last_tile() {
        let whole = maps(Selection::Depth).maps[2];
        let counts = UVec2::splat(2);
        let fine = Tile {
            place: UVec2::new(1, 0),
            counts,
        };
        // A second map, from 40 m on.
        let tiles = vec![(0, Tile::WHOLE), (0, fine), (1, Tile::WHOLE)];
        let window = TileWindow::of_size(UVec2::splat(64), 0);
        let found = LightMaps {
            maps: tiles
                .iter()
                .map(|(_, tile)| LightMap {
                    clip_from_world: tile.clip_from_world(&whole.clip_from_world, &window),
                    size: window.size,
                    ..whole
                })
                .collect(),
            selection: Selection::LastTile,
            distance: 90.0,
            virtual_maps: Some(WholeMaps {
                maps: vec![
                    LightMap {
                        far_depth: 40.0,
                        ..whole
                    },
                    whole,
                ],
                tiles,
                texels: 9000,
            }),
        };
        // Right is +x, the upper rows are those of smaller z: clip y goes up as z falls.
        assert_eq!(found.select(DVec3::new(50.0, 0.0, -50.0), 1.0), Some(1));
        assert_eq!(found.select(DVec3::new(-50.0, 0.0, -50.0), 1.0), Some(0));
        assert_eq!(found.select(DVec3::new(50.0, 0.0, 50.0), 1.0), Some(0));
        assert_eq!(found.select(DVec3::X * 101.0, 1.0), None);
        assert_eq!(found.select(DVec3::new(50.0, 0.0, -50.0), 39.9), Some(1));
        assert_eq!(
            found.select(DVec3::new(50.0, 0.0, -50.0), 40.0),
            Some(2),
            "the end is not part of the range"
        );
        assert_eq!(found.texels(), 9000);
        let texel = found.maps[1].texel(DVec3::new(50.0, 0.0, -50.0));
        assert!(
            (texel - 32.0).abs().max_element() < 1e-9,
            "the middle of the fine tile: {texel}"
        );
    }

    #[test]
    fn a_light_without_maps_selects_none() {
        let mut world = World::new();
        let entity = world.spawn_empty().id();
        let maps = LightMaps::of(&world, entity, entity);
        assert_eq!((maps.texels(), maps.select(DVec3::ZERO, 1.0)), (0, None));
    }
}
