//! Analytic rooms, a plain ground with few simple things on it, and the instancing test, land with very many.

use bevy_math::{Vec2, Vec3};

use super::{
    format::{Level, Room, StressTrees},
    ground::{Blocker, BlockerShape, Ground, Surface},
    grove::{self, Grove},
    land::Land,
    meshes::{MeshData, Rgb},
    model::{Model, PRIMITIVE_PAINTS, Placement},
    props,
    scenery::{Finish, Scenery, Static},
};

/// Generates a room.
pub fn generate(level: &Level, room: Room) -> Scenery {
    let size = level.terrain.size;
    let mut statics = vec![plane(size)];
    let mut placements = Vec::new();
    let mut blockers = Vec::new();
    match room {
        Room::PlaneBox { side } => placements.push(Placement {
            scale: Vec3::splat(side),
            ..Placement::upright(Model::Cube(0), Vec3::ZERO, 0.0)
        }),
        Room::Poles {
            spacing,
            height,
            radius,
            gap,
        } => {
            for z in stations(size.y, spacing) {
                for (x, paint) in [(-0.5 * gap, 0), (0.5 * gap, 1)] {
                    placements.push(Placement {
                        scale: Vec3::new(2.0 * radius, height, 2.0 * radius),
                        ..Placement::upright(Model::Pole(paint), Vec3::new(x, 0.0, z), 0.0)
                    });
                }
            }
        }
        Room::Fence { post_spacing, height } => {
            let stations: Vec<f32> = stations(size.y, post_spacing).collect();
            for (i, z) in stations.iter().enumerate() {
                let foot = Vec3::new(0.0, 0.0, *z);
                placements.push(Placement {
                    scale: Vec3::new(1.0, height, 1.0),
                    ..Placement::upright(Model::FencePost, foot, 0.0)
                });
                if i + 1 < stations.len() {
                    placements.push(Placement {
                        scale: Vec3::new(post_spacing, height, 1.0),
                        ..Placement::upright(Model::FenceRails, foot, -std::f32::consts::FRAC_PI_2)
                    });
                }
            }
        }
        Room::Wires {
            spacing,
            height,
            diameter,
            sag,
        } => {
            let stations: Vec<f32> = stations(size.y, spacing).collect();
            for (i, z) in stations.iter().enumerate() {
                for x in [-1.0, 1.0] {
                    placements.push(Placement {
                        scale: Vec3::new(0.2, height, 0.2),
                        ..Placement::upright(Model::Pole(2), Vec3::new(x, 0.0, *z), 0.0)
                    });
                }
                let Some(next) = stations.get(i + 1) else {
                    continue;
                };
                for (x, y) in [(-1.0, 0.99), (1.0, 0.99), (-1.0, 0.9), (1.0, 0.9)] {
                    let end = |z: f32| Vec3::new(x, y * height, z);
                    statics.push(Static::colored("wire", props::wire(end(*z), end(*next), sag, diameter)));
                }
            }
        }
        Room::Glass { panes, spacing, height } => {
            let places: Vec<f32> = stations(spacing * panes as f32, spacing).collect();
            let (width, depth) = (1.5 * height, spacing * panes as f32);
            for (number, z) in places.iter().enumerate() {
                // Each a bit beside the next, so that as many overlap as the eye meets.
                let x = 0.2 * width * (number as f32 - 0.5 * (panes - 1) as f32);
                let [left, right] = [x - 0.5 * width, x + 0.5 * width];
                let corner = |x: f32, y: f32| Vec3::new(x, y, *z);
                let mut mesh = MeshData::default();
                mesh.push_quad(
                    [
                        corner(left, 0.0),
                        corner(right, 0.0),
                        corner(right, height),
                        corner(left, height),
                    ],
                    GLASS[number % GLASS.len()],
                );
                statics.push(Static {
                    name: "pane",
                    mesh,
                    finish: Finish::Glass,
                });
                blockers.push(Blocker {
                    center: Vec2::new(x, *z),
                    shape: BlockerShape::Box {
                        half: Vec2::new(0.5 * width, 0.02),
                        yaw: 0.0,
                    },
                    bottom: -1.0,
                    top: height,
                });
            }
            let overhang = depth + height;
            let mut beams = MeshData::default();
            for x in stations(2.0 * width, 0.4 * height) {
                let middle = Vec3::new(x, 1.34 * height, 0.0);
                let size = Vec3::new(0.08 * height, 0.08 * height, overhang);
                beams.push_box(middle, size, PRIMITIVE_PAINTS[2]);
            }
            statics.push(Static::colored("beams", beams));
            for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                let foot = Vec3::new(x * width, 0.0, 0.45 * z * overhang);
                placements.push(Placement {
                    scale: Vec3::new(0.1 * height, 1.4 * height, 0.1 * height),
                    ..Placement::upright(Model::Pole(2), foot, 0.0)
                });
            }
        }
        Room::Wall {
            place,
            height,
            spacing,
            card,
        } => {
            let slab = |scale: Vec3, z: f32| Placement {
                scale,
                ..Placement::upright(Model::Cube(0), Vec3::new(0.0, 0.0, z), 0.0)
            };
            placements.push(slab(Vec3::new(size.x, height, WALL), place - 0.5 * WALL));
            if card > 0.0 {
                placements.push(slab(Vec3::new(card, card, CARD), place + 6.0));
            }
            for x in stations(size.x, spacing) {
                placements.push(Placement {
                    scale: Vec3::new(0.15, 0.5 * height, 0.15),
                    ..Placement::upright(Model::Pole(1), Vec3::new(x, 0.0, place + 3.0), 0.0)
                });
            }
        }
    }
    blockers.extend(placements.iter().filter_map(Placement::blocker));
    Scenery {
        statics,
        placements,
        ground: Ground::new(Surface::Flat(0.0), Vec::new(), blockers).within(size),
        ..Scenery::default()
    }
}

/// Colours of panes, from the farthest on.
const GLASS: [Rgb; 3] = [[0.8, 0.35, 0.25], [0.3, 0.75, 0.4], [0.3, 0.45, 0.85]];

/// Thickness of a wall, metres.
const WALL: f32 = 0.3;

/// Thickness of a card, metres.
const CARD: f32 = 0.02;

/// Generates the instancing test: conifers, birches and dead trees on a square lattice over rolling land.
pub fn stress_trees(level: &Level, trees: StressTrees) -> Scenery {
    let extent = grove::side(trees.count) as f32 * trees.spacing;
    let size = level.terrain.size.max(Vec2::splat(extent + 20.0));
    let land = Land::new(size, level.terrain.hills, level.seed);
    let grove = Grove::new(trees.count, trees.spacing, level.seed, land).in_wind(trees.wind);
    let patches = land.patches();
    let ground = Ground::new(Surface::Land(land), Vec::new(), Vec::new()).with_grove(grove);
    if trees.cells {
        return Scenery {
            patches,
            grove: Some(grove),
            ground,
            ..Scenery::default()
        };
    }
    Scenery {
        patches,
        placements: grove.trees().collect(),
        ground,
        ..Scenery::default()
    }
}

/// Places along an extent, centred, at whole spacings.
fn stations(extent: f32, spacing: f32) -> impl Iterator<Item = f32> {
    let count = (extent / spacing).floor().max(1.0) as u32;
    (0..count).map(move |i| (i as f32 - 0.5 * (count - 1) as f32) * spacing)
}

/// A chequered plane at y = 0; squares of 5 m, larger where there would be more than 160 000 of them.
fn plane(size: Vec2) -> Static {
    let cell = (size / 400.0).max_element().max(5.0);
    let count = [size.x, size.y].map(|side| (side / cell).ceil() as u32);
    let mut mesh = MeshData::default();
    for j in 0..count[1] {
        for i in 0..count[0] {
            let at = |i: u32, j: u32| {
                let p = Vec2::new(i as f32 / count[0] as f32, j as f32 / count[1] as f32) * size - size * 0.5;
                Vec3::new(p.x, 0.0, p.y)
            };
            let light = if (i + j).is_multiple_of(2) { 0.27 } else { 0.23 };
            mesh.push_quad(
                [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)],
                [light, light, light * 0.95],
            );
        }
    }
    Static::colored("plane", mesh)
}
