//! Generators: the same for the same seed, inside their terrain, to their rules.

use std::collections::HashSet;

use bevy::math::{Vec2, Vec3};
use umbrage::level::{
    format::*,
    made::Made,
    model::{Model, Placement},
    scatter,
    scenery::{Scenery, generate},
    terrain::Terrain,
};

use crate::files::{level, names};

fn plan(placement: &Placement) -> Vec2 {
    Vec2::new(placement.position.x, placement.position.z)
}

fn trees(scenery: &Scenery) -> Vec<&Placement> {
    scenery
        .placements
        .iter()
        .filter(|placement| matches!(placement.model, Model::Plant(species, _) if species.is_tree()))
        .collect()
}

#[test]
fn the_same_seed_gives_the_same_level_and_another_one_another() {
    for name in ["forest", "city", "stress_trees"] {
        let mut level = level(name);
        if name == "stress_trees" {
            level.set("count", "500").unwrap();
            level.set("cells", "off").unwrap();
        }
        let first = generate(&level);
        assert!(first == generate(&level), "{name} differs between runs");
        level.seed += 1;
        assert!(
            first.placements != generate(&level).placements,
            "{name} does not depend on its seed"
        );
    }
}

#[test]
fn everything_is_finite_and_on_its_terrain() {
    for name in names() {
        let mut level = level(&name);
        if name == "stress_trees" {
            level.set("cells", "off").unwrap();
        }
        let scenery = generate(&level);
        // The instancing test's ground grows with its number of trees.
        let size = if name == "stress_trees" {
            Vec2::splat(520.0)
        } else {
            level.terrain.size
        };
        for placement in &scenery.placements {
            let half = size * 0.5;
            assert!(plan(placement).abs().cmple(half).all(), "{name}: {placement:?}");
            let up = placement.position.y - scenery.ground.height(placement.position.x, placement.position.z);
            assert!(up.abs() < 0.7, "{name}: {up} m above the ground: {placement:?}");
            assert!(
                placement.scale.is_finite() && placement.scale.min_element() > 0.0,
                "{name}: {placement:?}"
            );
            assert!(placement.rotation.is_normalized(), "{name}: {placement:?}");
        }
        for part in &scenery.statics {
            let (min, max) = part.mesh.bounds().unwrap();
            assert!(min.is_finite() && max.is_finite(), "{name}: {}", part.name);
        }
    }
}

#[test]
fn the_forest_has_its_trees_in_all_kinds() {
    let scenery = generate(&level("forest"));
    let trees = trees(&scenery);
    assert!(trees.len() >= 2000, "{} trees", trees.len());
    for species in [
        Species::Spruce,
        Species::Pine,
        Species::Oak,
        Species::Beech,
        Species::Birch,
        Species::DeadTree,
    ] {
        let of_kind = trees
            .iter()
            .filter(|tree| matches!(tree.model, Model::Plant(own, _) if own == species))
            .count();
        assert!(of_kind >= 100, "{of_kind} of {species:?}");
    }
    let posts = scenery
        .placements
        .iter()
        .filter(|p| p.model == Model::Made(Made::SplitPost))
        .count();
    let rails = scenery
        .placements
        .iter()
        .filter(|p| p.model == Model::Made(Made::SplitRails))
        .count();
    assert!(posts >= 100 && rails >= posts * 9 / 10, "{posts} posts, {rails} rails");
    assert!(scenery.placements.iter().any(|p| p.model == Model::Made(Made::Hut)));
}

#[test]
fn trees_keep_their_spacing_and_keep_off_paths_clearings_and_steep_ground() {
    let level = level("forest");
    let terrain = Terrain::new(&level.terrain, level.seed);
    let thrown = scatter::scatter(&terrain, &level.scatter, |_| true, level.seed);
    let rule = |species: Species| level.scatter.iter().find(|rule| rule.species == species).unwrap();
    for (i, a) in thrown.iter().enumerate() {
        for b in &thrown[i + 1..] {
            let free = 0.5 * (a.spacing + b.spacing);
            assert!(a.position.distance(b.position) >= free - 1e-3, "{a:?} {b:?}");
        }
        let slope = terrain.normal(a.position).y.acos().to_degrees();
        assert!(
            slope <= rule(a.species).slope_deg.1 + 1e-3,
            "{a:?} on a slope of {slope}"
        );
        for track in terrain.tracks() {
            let distance = track.distance(a.position);
            assert!(
                distance > scatter::track_distance(a.species, track) - 1e-3,
                "{a:?} on a track"
            );
            assert!(distance > 0.5 * track.width + 0.8, "{a:?} on a track");
        }
        if a.species.is_tree() {
            assert!(
                terrain
                    .clearings()
                    .iter()
                    .all(|c| a.position.distance(c.center) >= c.radius),
                "{a:?}"
            );
        }
    }
}

#[test]
fn rails_connect_their_posts() {
    let scenery = generate(&level("forest"));
    let of = |model: Model| scenery.placements.iter().filter(move |p| p.model == model);
    let posts: Vec<Vec3> = of(Model::Made(Made::SplitPost)).map(|p| p.position).collect();
    for rails in of(Model::Made(Made::SplitRails)) {
        let end = rails.position + rails.rotation * (Vec3::X * rails.scale.x);
        for tip in [rails.position, end] {
            let nearest = posts.iter().map(|post| post.distance(tip)).fold(f32::MAX, f32::min);
            assert!(nearest < 0.01, "a rail ends {nearest} m from the next post");
        }
    }
}

#[test]
fn the_city_has_its_buildings_in_districts_and_a_tower() {
    let level = level("city");
    let scenery = generate(&level);
    let buildings: Vec<_> = scenery
        .placements
        .iter()
        .filter_map(|p| match p.model {
            Model::Building(building) => Some((plan(p), building)),
            _ => None,
        })
        .collect();
    assert!(buildings.len() >= 150, "{} buildings", buildings.len());
    let mean = |near: f32, far: f32| {
        let floors: Vec<f32> = buildings
            .iter()
            .filter(|(p, _)| (near..far).contains(&p.abs().max_element()))
            .map(|(_, building)| f32::from(building.floors))
            .collect();
        floors.iter().sum::<f32>() / floors.len() as f32
    };
    let (centre, edge) = (mean(0.0, 80.0), mean(170.0, 400.0));
    assert!(
        centre > 2.5 * edge && edge >= 2.0,
        "{centre} floors in the middle, {edge} at the edge"
    );
    let models: HashSet<_> = buildings.iter().map(|(_, building)| building).collect();
    assert!(models.len() > 100, "only {} different buildings", models.len());
    let made = |made: Made| scenery.placements.iter().filter(move |p| p.model == Model::Made(made));
    let tower = made(Made::Tower).next().expect("a tower");
    assert_eq!(tower.scale.y * Made::Tower.height(), 118.0);
    assert_eq!((made(Made::Tram).count(), made(Made::Kiosk).count()), (2, 1));
    assert!(made(Made::Fountain).count() > 0 && made(Made::Cafe).count() > 3);
    for (what, least) in [("lamp", 200), ("bench", 20), ("car", 200), ("tree", 300)] {
        let count = scenery
            .placements
            .iter()
            .filter(|p| match p.model {
                Model::Made(Made::Lamp | Made::OldLamp) => what == "lamp",
                Model::Made(Made::Bench) => what == "bench",
                Model::Made(Made::Hatchback | Made::Estate | Made::Lorry) => what == "car",
                Model::Plant(species, _) => what == "tree" && species.is_tree(),
                _ => false,
            })
            .count();
        assert!(count >= least, "{count} of {what}");
    }
}

#[test]
fn buildings_do_not_stand_in_each_other() {
    let scenery = generate(&level("city"));
    let boxes: Vec<(Vec2, Vec2)> = scenery
        .placements
        .iter()
        .filter_map(|p| match p.model {
            Model::Building(building) => {
                let (width, depth) = building.plan();
                let turned = p.rotation * Vec3::new(0.5 * width, 0.0, 0.5 * depth);
                Some((plan(p), Vec2::new(turned.x, turned.z).abs()))
            }
            _ => None,
        })
        .collect();
    for (i, a) in boxes.iter().enumerate() {
        for b in &boxes[i + 1..] {
            let gap = (a.0 - b.0).abs() - (a.1 + b.1);
            assert!(gap.max_element() > 0.0, "{a:?} {b:?}");
        }
    }
}

#[test]
fn fronts_look_to_streets_and_blind_walls_to_close_neighbours() {
    let scenery = generate(&level("city"));
    let buildings: Vec<_> = scenery
        .placements
        .iter()
        .filter_map(|p| match p.model {
            Model::Building(building) => {
                let (width, depth) = building.plan();
                let half = p.rotation * Vec3::new(0.5 * width, 0.0, 0.5 * depth);
                Some((p, building, Vec2::new(half.x, half.z).abs()))
            }
            _ => None,
        })
        .collect();
    let mut blind = 0;
    for (own, building, half) in &buildings {
        // Metres of air in a direction, up to the next building.
        let air = |direction: Vec3| {
            let d = Vec2::new(direction.x, direction.z);
            let gaps = buildings.iter().filter_map(|(other, _, other_half)| {
                let (offset, reach) = (plan(other) - plan(own), *half + *other_half);
                let (ahead, aside) = (offset.dot(d), offset.dot(d.perp()).abs());
                let is_ahead = ahead > 1.0 && aside < reach.dot(d.perp().abs()) - 0.5;
                is_ahead.then(|| ahead - reach.dot(d.abs()))
            });
            gaps.fold(f32::MAX, f32::min)
        };
        let (front, right) = (own.rotation * Vec3::Z, own.rotation * Vec3::X);
        assert!(air(front) > 12.0, "{:?} has {} m before it", own.position, air(front));
        for (is_blind, side) in [(building.blind.0, right), (building.blind.1, -right)] {
            if is_blind {
                blind += 1;
                assert!(
                    air(side) < 2.0,
                    "{:?}: a blind wall with {} m of air",
                    own.position,
                    air(side)
                );
            }
        }
    }
    assert!(blind > 100, "{blind} blind walls");
}

#[test]
fn a_walker_is_stopped_by_trunks_walls_and_fences() {
    for (name, least) in [
        ("forest", 2000),
        ("city", 150),
        ("room/fence", 70),
        ("room/glass", 7),
        ("room/plane_box", 1),
    ] {
        let scenery = generate(&level(name));
        assert!(
            scenery.ground.blockers().len() >= least,
            "{name}: {}",
            scenery.ground.blockers().len()
        );
    }
    let way_out = |name: &str, p: Vec2| {
        let ground = generate(&level(name)).ground;
        let near = ground
            .blockers_near(p, 0.3)
            .into_iter()
            .map(|blocker| blocker.outwards(p));
        let (_, way_out) = near
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("something is in the way");
        way_out
    };
    assert!((way_out("room/plane_box", Vec2::new(0.9, 0.2)) - Vec2::X).length() < 1e-4);
    assert!((way_out("room/fence", Vec2::new(0.1, 0.7)) - Vec2::X).length() < 1e-4);
}

#[test]
fn the_instancing_test_gives_as_many_trees_as_asked_from_few_meshes() {
    let mut level = level("stress_trees");
    for count in [1, 999, 100_000] {
        level.set("count", &count.to_string()).unwrap();
        level.set("cells", "off").unwrap();
        let scenery = generate(&level);
        assert_eq!(scenery.placements.len(), count);
        level.set("cells", "on").unwrap();
        let in_cells = generate(&level);
        assert!(in_cells.placements.is_empty(), "cells keep nothing");
        let trees: Vec<Placement> = in_cells.grove.expect("a grove").trees().collect();
        assert!(trees == scenery.placements, "{count} trees differ in cells");
        let models: HashSet<_> = scenery.placements.iter().map(|p| p.model).collect();
        assert!(models.len() <= 16, "{} meshes", models.len());
    }
}
