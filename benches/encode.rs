//! CPU time that recording the commands of 256 tiles takes, everything that the render world does per tile included; not
//! the GPU's time, and not that of the driver's threads: `cargo bench --bench encode`.
//!
//! Target: 2 ms, median. The times are those of the system that records virtual maps, taken from whole frames.

use std::{path::Path, time::Duration};

use bevy::{
    camera::RenderTarget, core_pipeline::prepass::DepthPrepass, prelude::*, render::render_resource::TextureFormat,
};
use criterion::{Criterion, criterion_group, criterion_main};
use umbrage::{
    cli::headless,
    level::find::asset_root,
    prelude::*,
    render::{capture::readable_target, virtual_map::report::VirtualMapReports},
    shadow::timing::SystemTimes,
};

/// The system that records the tiles of all cameras.
const SYSTEM: &str = "draw_virtual_maps";

/// A row of posts on a plane: two meshes, two bins of casters, drawn into all tiles that they lie in.
fn app(maps: ShadowMaps) -> App {
    let root = asset_root(Some(Path::new(env!("CARGO_MANIFEST_DIR")))).unwrap_or_else(|error| panic!("{error}"));
    let mut app = headless::app(&root).unwrap_or_else(|error| panic!("{error}"));
    app.add_plugins(UmbragePlugins);
    let world = app.world_mut();
    let picture = readable_target(32, 18, TextureFormat::Rgba8UnormSrgb);
    let picture = world.resource_mut::<Assets<Image>>().add(picture);
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let [plane, post] = [
        meshes.add(Plane3d::default().mesh().size(80.0, 80.0)),
        meshes.add(Cuboid::new(0.3, 3.0, 0.3)),
    ];
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial::default());
    world.spawn((
        Camera3d::default(),
        RenderTarget::Image(picture.into()),
        Msaa::Off,
        DepthPrepass,
        Transform::from_xyz(0.0, 3.0, 14.0).looking_at(Vec3::Y, Vec3::Y),
    ));
    let mut settings = SunShadows {
        maps,
        ..SunShadows::LOW
    };
    settings.partitions.count = 1;
    world.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::default().looking_to(Vec3::new(-0.6, -0.5, -0.4), Vec3::Y),
        settings,
    ));
    world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    for x in -10..10 {
        let place = Transform::from_xyz(x as f32 * 2.0, 1.5, 0.0);
        world.spawn((Mesh3d(post.clone()), MeshMaterial3d(material.clone()), place));
    }
    headless::finish(&mut app);
    for _ in 0..20 {
        headless::frame(&mut app);
    }
    app
}

/// Tiles that a pass draws together, and settings in which as many fit the memory.
const CASES: [(u32, TiledMaps); 2] = [
    (
        16,
        TiledMaps {
            tiles_per_axis: 16,
            tile_size: 16,
            skip_empty: false,
            progressive: false,
            memory: 64,
        },
    ),
    // As tiles of 2048² in 64 MiB.
    (
        4,
        TiledMaps {
            tiles_per_axis: 16,
            tile_size: 256,
            skip_empty: false,
            progressive: false,
            memory: 1,
        },
    ),
];

fn tiles(criterion: &mut Criterion) {
    for (together, maps) in CASES {
        let mut app = app(ShadowMaps::Tiled(maps));
        let cameras: Vec<Entity> = app
            .world_mut()
            .query_filtered::<Entity, With<Camera3d>>()
            .iter(app.world())
            .collect();
        let reports = app.world().resource::<VirtualMapReports>();
        let drawn = cameras.iter().filter_map(|camera| reports.get(*camera));
        let drawn: Vec<usize> = drawn.map(|report| report.tiles.len()).collect();
        assert_eq!(drawn, [256], "tiles of the camera");
        let times = SystemTimes::of(&mut app);
        times.switch(true);
        criterion.bench_function(&format!("recording of 256 tiles, {together} per pass"), |bencher| {
            bencher.iter_custom(|frames| {
                let _ = times.take();
                for _ in 0..frames {
                    headless::frame(&mut app);
                }
                let taken = times.take().get(SYSTEM).copied();
                taken.unwrap_or_else(|| panic!("no system {SYSTEM} was timed"))
            });
        });
    }
}

criterion_group! {
    name = benches;
    // Frames take longer than what is measured of them.
    config = Criterion::default().sample_size(20).measurement_time(Duration::from_secs(1));
    targets = tiles
}
criterion_main!(benches);
