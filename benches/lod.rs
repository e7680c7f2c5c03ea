//! Times of the systems that choose levels of detail, without transforms, visibility and renderer: `cargo bench --bench lod`.
//!
//! Target: 1 ms per frame for 100 000 trees and an eye that walks, median, on two cores.

use std::{hint::black_box, sync::Arc, time::Duration};

use bevy::{camera::primitives::Aabb, math::Vec2, prelude::*, time::TimeUpdateStrategy};
use criterion::{Criterion, criterion_group, criterion_main};
use umbrage::{
    level::{
        grove::{
            Grove, blocks,
            field::{self, CellField, TreeLooks},
            side,
        },
        land::Land,
        simple_trees::{LEVEL_ENDS, LEVELS},
    },
    lod::{LodPlugin, chain::LodChain},
    maths::lod::selection::{LodBorders, LodMetric},
};

const TREES: u32 = 100_000;
/// Metres per frame: 6 m/s, a run.
const STEP: f32 = 0.1;

/// An app with nothing but levels of detail, and its camera.
fn app() -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), LodPlugin))
        .init_asset::<Mesh>()
        .init_asset::<StandardMaterial>()
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_nanos(16_666_667)));
    let camera = app.world_mut().spawn((Camera3d::default(), Transform::default())).id();
    (app, camera)
}

fn grove() -> Grove {
    let land = Land::new(Vec2::splat(side(TREES) as f32 * 5.0 + 20.0), None, 1);
    Grove::new(TREES, 5.0, 1, land)
}

/// One frame per iteration, to and fro over 400 m.
fn walk(criterion: &mut Criterion, name: &str, app: &mut App, camera: Entity) {
    let mut frame = 0_u32;
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            frame += 1;
            let way = (frame % 8000) as f32 * STEP;
            let x = if way < 400.0 { way } else { 800.0 - way } - 200.0;
            if let Some(mut place) = app.world_mut().get_mut::<Transform>(camera) {
                place.translation = Vec3::new(x, 1.7, 2.0);
            }
            app.update();
        });
    });
    black_box(app);
}

fn empty(criterion: &mut Criterion) {
    let (mut app, camera) = app();
    walk(criterion, "a frame without trees", &mut app, camera);
}

fn cells(criterion: &mut Criterion) {
    let (mut app, camera) = app();
    app.add_plugins(field::plugin);
    let mesh = (Handle::<Mesh>::default(), Aabb::default());
    let looks = TreeLooks {
        meshes: vec![vec![mesh; LEVELS]; blocks::models().count()],
        material: Handle::default(),
    };
    app.world_mut().spawn(CellField::new(grove(), looks));
    walk(criterion, "100 000 trees in cells, an eye that walks", &mut app, camera);
}

fn chains(criterion: &mut Criterion) {
    let (mut app, camera) = app();
    let borders = Arc::new(LodBorders::new(LEVEL_ENDS.map(f64::from)));
    let world = app.world_mut();
    for tree in grove().trees() {
        let part = |_| vec![world.spawn((Transform::default(), Visibility::default())).id()];
        let chain = LodChain {
            levels: (0..LEVELS).map(part).collect(),
            borders: borders.clone(),
            metric: LodMetric::Distance,
        };
        world.spawn((chain, Transform::from_translation(tree.position)));
    }
    walk(
        criterion,
        "100 000 trees, each an entity, an eye that walks",
        &mut app,
        camera,
    );
}

criterion_group!(benches, empty, cells, chains);
criterion_main!(benches);
