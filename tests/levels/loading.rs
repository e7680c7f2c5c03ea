//! Loading in an app without window and renderer.

use std::{
    collections::{HashMap, HashSet},
    fs,
    path::PathBuf,
    time::Instant,
};

use bevy::{
    animation::AnimationPlugin, app::PluginsState, camera::primitives::Aabb, gltf::GltfPlugin,
    mesh::skinning::SkinnedMeshInverseBindposes, prelude::*, world_serialization::WorldSerializationPlugin,
};
use umbrage::{
    level::{
        LevelEntity, LevelPlugin, LoadedScene, RequestedScene, SceneStatus, Sun, find, inhabitants::Inhabitant, loader,
        model::Model, scene::SceneSource,
    },
    lod::chain::LodChain,
};

use crate::sources::{glb, root};

pub(crate) fn app_with(root: &find::AssetRoot) -> App {
    let mut app = App::new();
    loader::register_sources(&mut app, root);
    app.add_plugins((
        MinimalPlugins,
        loader::asset_plugin(root),
        TransformPlugin,
        ImagePlugin::default(),
        WorldSerializationPlugin,
        GltfPlugin::default(),
        AnimationPlugin,
    ))
    .init_asset::<Mesh>()
    .init_asset::<SkinnedMeshInverseBindposes>()
    .init_asset::<StandardMaterial>()
    .add_plugins(LevelPlugin { assets: root.clone() });
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app
}

pub(crate) fn request(app: &mut App, source: SceneSource) {
    app.world_mut().resource_mut::<RequestedScene>().0 = Some(source);
}

/// Updates until the scene is ready or has failed; gives the sentence of a failure. Progress must not fall.
pub(crate) fn wait(app: &mut App) -> Result<(), String> {
    let start = Instant::now();
    let mut last = 0;
    loop {
        app.update();
        match app.world().resource::<SceneStatus>() {
            SceneStatus::Ready => return Ok(()),
            SceneStatus::Failed(sentence) => return Err(sentence.clone()),
            SceneStatus::Loading { done, total, what } => {
                assert!(
                    *done >= last && done <= total,
                    "progress fell from {last} to {done}: {what}"
                );
                last = *done;
            }
            SceneStatus::Idle => panic!("idle after a request"),
        }
        assert!(start.elapsed().as_secs() < 60, "still loading after a minute");
    }
}

pub(crate) fn count<T: Component>(app: &mut App) -> usize {
    app.world_mut().query::<&T>().iter(app.world()).count()
}

#[test]
fn a_room_becomes_ready_with_everything_in_it() {
    let mut app = app_with(&root());
    app.update();
    assert_eq!(*app.world().resource::<SceneStatus>(), SceneStatus::Idle);
    request(&mut app, SceneSource::level("room/plane_box"));
    wait(&mut app).unwrap();
    let scene = app.world().resource::<LoadedScene>();
    assert_eq!(scene.name, "room/plane_box");
    assert_eq!(scene.shots.len(), 3);
    assert_eq!(scene.ground.blockers().len(), 1);
    // Plane, cube, sun.
    assert_eq!(count::<LevelEntity>(&mut app), 3);
    assert_eq!(count::<Mesh3d>(&mut app), 2);
    let mut suns = app
        .world_mut()
        .query_filtered::<(&DirectionalLight, &Transform), With<Sun>>();
    let (light, transform) = suns.single(app.world()).unwrap();
    assert!(light.shadow_maps_enabled);
    let scene = app.world().resource::<LoadedScene>();
    assert!(transform.forward().dot(scene.sun.light_dir().normalize()) > 0.9999);
}

#[test]
fn another_request_replaces_the_scene_and_none_clears_it() {
    let mut app = app_with(&root());
    request(&mut app, SceneSource::level("room/fence"));
    wait(&mut app).unwrap();
    let fence = count::<LevelEntity>(&mut app);
    request(&mut app, SceneSource::level("room/plane_box"));
    wait(&mut app).unwrap();
    assert_eq!(count::<LevelEntity>(&mut app), 3);
    request(&mut app, SceneSource::level("room/fence"));
    wait(&mut app).unwrap();
    assert_eq!(count::<LevelEntity>(&mut app), fence);
    app.world_mut().resource_mut::<RequestedScene>().0 = None;
    app.update();
    assert_eq!(*app.world().resource::<SceneStatus>(), SceneStatus::Idle);
    assert_eq!(count::<LevelEntity>(&mut app), 0);
    assert!(!app.world().contains_resource::<LoadedScene>());
}

#[test]
fn a_request_may_interrupt_another() {
    let mut app = app_with(&root());
    for updates in 0..6 {
        request(&mut app, SceneSource::level("forest"));
        for _ in 0..updates {
            app.update();
        }
        request(&mut app, SceneSource::level("room/plane_box"));
        wait(&mut app).unwrap();
        assert_eq!(count::<LevelEntity>(&mut app), 3, "after {updates} updates");
    }
}

/// Entities with a mesh, and their different pairs of mesh and material: what one draw call can hold.
fn meshes_and_batches(app: &mut App) -> (usize, usize) {
    let pairs: Vec<_> = app
        .world_mut()
        .query::<(&Mesh3d, &MeshMaterial3d<StandardMaterial>)>()
        .iter(app.world())
        .map(|(mesh, material)| (mesh.id(), material.id()))
        .collect();
    (pairs.len(), pairs.iter().collect::<HashSet<_>>().len())
}

#[test]
fn more_trees_are_no_more_batches_and_settings_reach_the_forest() {
    let mut app = app_with(&root());
    request(&mut app, "forest:count=300".parse().unwrap());
    wait(&mut app).unwrap();
    let (few, batches_of_few) = meshes_and_batches(&mut app);
    let with_meshes = count::<Mesh3d>(&mut app);
    assert_eq!(count::<Aabb>(&mut app), with_meshes);
    let notes = &app.world().resource::<LoadedScene>().notes;
    assert!(notes.is_empty(), "{notes:?}");
    request(&mut app, "forest:count=1200".parse().unwrap());
    wait(&mut app).unwrap();
    let (many, batches_of_many) = meshes_and_batches(&mut app);
    assert!(many > few + 900 * 4, "{few} entities, then {many}");
    // Nothing but variants that were not among the first.
    assert!(
        batches_of_many <= batches_of_few + batches_of_few / 20,
        "{batches_of_few} batches of {few} entities, then {batches_of_many} of {many}"
    );
}

/// Levels of one thing follow each other without gap or overlap, and own their parts.
#[test]
fn a_tree_is_drawn_in_one_level_at_any_distance() {
    let mut app = app_with(&root());
    request(&mut app, "forest:count=40".parse().unwrap());
    wait(&mut app).unwrap();
    let world = app.world_mut();
    let mut chains = world.query::<(Entity, &LodChain)>();
    let mut owners: HashMap<Entity, Entity> = HashMap::new();
    let mut count = 0;
    for (owner, chain) in chains.iter(world) {
        count += 1;
        let borders = chain.borders.as_slice();
        assert!(
            [borders.len(), borders.len() + 1].contains(&chain.levels.len()),
            "{} levels between {borders:?}",
            chain.levels.len()
        );
        assert!(
            borders[0] > 0.0 && borders.windows(2).all(|pair| pair[0] < pair[1]),
            "{borders:?}"
        );
        for part in chain.levels.iter().flatten() {
            assert!(world.get::<Mesh3d>(*part).is_some(), "a part is drawn");
            assert_eq!(owners.insert(*part, owner), None, "a part is of one chain and level");
        }
        assert!(chain.levels.iter().all(|parts| !parts.is_empty()), "no level is empty");
    }
    assert!(count > 40, "{count} things with levels");
}

#[test]
fn without_its_model_files_a_level_has_striped_boxes_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("levels")).unwrap();
    fs::create_dir_all(folder.path().join("assets/models")).unwrap();
    let forest = root().levels().join("forest.level.ron");
    fs::copy(forest, folder.path().join("levels/forest.level.ron")).unwrap();
    // One file is broken, all others are missing.
    fs::write(folder.path().join("assets/models/oak.glb"), b"glTF nonsense").unwrap();
    let mut app = app_with(&find::asset_root(Some(folder.path())).unwrap());
    request(&mut app, "forest:count=60".parse().unwrap());
    wait(&mut app).unwrap();
    let notes = app.world().resource::<LoadedScene>().notes.clone();
    for file in ["oak.glb", "spruce.glb", "grass.glb", "surfaces.glb"] {
        assert_eq!(
            notes.iter().filter(|note| note.contains(file)).count(),
            1,
            "{file} in {notes:#?}"
        );
    }
    assert!(notes.iter().all(|note| note.lines().count() == 1), "{notes:#?}");
    let trees = generated_trees(60);
    assert!(count::<Mesh3d>(&mut app) > trees, "boxes stand where trees were");
    assert_eq!(count::<LodChain>(&mut app), 0);
    let world = app.world_mut();
    let mut deer = world.query_filtered::<&Children, With<Inhabitant>>();
    let boxes: Vec<Entity> = deer.iter(world).flatten().copied().collect();
    assert!(boxes.len() > 2, "boxes go where deer went");
    assert!(
        boxes.iter().all(|entity| world.get::<Mesh3d>(*entity).is_some()),
        "boxes of deer are seen"
    );
}

fn generated_trees(count: u32) -> usize {
    let mut level = crate::files::level("forest");
    level.set("count", &count.to_string()).unwrap();
    let scenery = umbrage::level::scenery::generate(&level);
    let is_tree = |model: Model| matches!(model, Model::Plant(species, _) if species.is_tree());
    scenery
        .placements
        .iter()
        .filter(|placement| is_tree(placement.model))
        .count()
}

#[test]
fn what_cannot_be_loaded_fails_with_a_sentence() {
    let mut app = app_with(&root());
    for (source, part) in [
        ("nowhere", "there is no level `nowhere`; there are: city, forest"),
        ("room/fence:count=3", "no setting `count`"),
        ("forest:count=-3", "`count` is -3"),
        ("none.glb", "none.glb: there is no such file"),
    ] {
        request(&mut app, source.parse().unwrap());
        let sentence = wait(&mut app).unwrap_err();
        assert!(sentence.contains(part), "{sentence}");
        assert_eq!(sentence.lines().count(), 1, "{sentence}");
        assert_eq!(count::<LevelEntity>(&mut app), 0);
    }
    // And it recovers.
    request(&mut app, SceneSource::level("room/plane_box"));
    wait(&mut app).unwrap();
}

#[test]
fn a_broken_level_file_fails_with_file_line_and_field() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("levels")).unwrap();
    let good = fs::read_to_string(root().levels().join("room/plane_box.level.ron")).unwrap();
    let write =
        |name: &str, text: String| fs::write(folder.path().join(format!("levels/{name}.level.ron")), text).unwrap();
    write("typo", good.replace("light_dir:", "light_dirr:"));
    write(
        "nan",
        good.replace("seed: 1", "seed: 1").replace("near: 0.5", "near: NaN"),
    );
    write("renamed", good);
    let root = find::asset_root(Some(folder.path())).unwrap();
    let mut app = app_with(&root);
    for (name, parts) in [
        ("typo", ["levels/typo.level.ron", "line 8", "light_dirr"]),
        ("nan", ["levels/nan.level.ron", "`shots[0].near`", "NaN"]),
        (
            "renamed",
            ["levels/renamed.level.ron", "room/plane_box", "must be its path"],
        ),
    ] {
        request(&mut app, SceneSource::level(name));
        let sentence = wait(&mut app).unwrap_err();
        for part in parts {
            assert!(sentence.contains(part), "{sentence}");
        }
    }
}

/// What a file watcher (feature `dev`) triggers: the asset server reads the file again, and the level follows it. An edit
/// with a mistake leaves the scene as it is.
#[test]
fn a_changed_file_changes_the_level_and_a_broken_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("levels/room")).unwrap();
    let file = folder.path().join("levels/room/plane_box.level.ron");
    let good = fs::read_to_string(root().levels().join("room/plane_box.level.ron")).unwrap();
    fs::write(&file, &good).unwrap();
    let mut app = app_with(&find::asset_root(Some(folder.path())).unwrap());
    request(&mut app, SceneSource::level("room/plane_box"));
    wait(&mut app).unwrap();
    let entities = count::<LevelEntity>(&mut app);
    let first_shot = |app: &App| {
        let scene = app.world().get_resource::<LoadedScene>();
        scene.map(|scene| scene.shots[0].name.clone())
    };
    let mut reload_until = |text: String, is_done: &dyn Fn(Option<String>) -> bool| {
        fs::write(&file, text).unwrap();
        app.world()
            .resource::<AssetServer>()
            .reload("levels://room/plane_box.level.ron");
        let start = Instant::now();
        while !is_done(first_shot(&app)) && start.elapsed().as_secs() < 20 {
            app.update();
        }
        wait(&mut app).unwrap();
        assert_eq!(count::<LevelEntity>(&mut app), entities, "the old scene is gone");
        first_shot(&app)
    };
    let renamed = good.replace("\"corner\"", "\"edited\"");
    let shot = reload_until(renamed, &|name| name.as_deref() == Some("edited"));
    assert_eq!(shot.as_deref(), Some("edited"), "the level follows its file");
    // Nothing to wait for: give the server a second to read the broken file.
    let start = Instant::now();
    let broken = good.replace("near: 0.5", "near: NaN");
    let shot = reload_until(broken, &|_| start.elapsed().as_secs_f32() > 1.0);
    assert_eq!(shot.as_deref(), Some("edited"), "a broken file changes nothing");
}

/// A triangle of 2 m as a glTF document; `uri` is where its 36 bytes of positions are.
fn triangle(uri: Option<&str>) -> String {
    let uri = uri.map(|uri| format!(r#""uri":"{uri}","#)).unwrap_or_default();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],
        "nodes":[{{"mesh":0,"translation":[10,0,0]}},{{"camera":0}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[2,2,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{{uri}"byteLength":36}}]}}"#
    )
}

pub(crate) fn positions() -> Vec<u8> {
    [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect()
}

fn check_triangle(app: &mut App, path: PathBuf) {
    request(app, SceneSource::Gltf(path));
    wait(app).unwrap();
    let scene = app.world().resource::<LoadedScene>();
    assert_eq!(scene.name, "model");
    assert_eq!(scene.shots.len(), 1);
    assert_eq!(scene.notes.len(), 1, "{:?}", scene.notes);
    let target = Vec3::from(scene.shots[0].target);
    assert!((target - Vec3::new(11.0, 1.0, 0.0)).length() < 1e-4, "{target}");
    assert_eq!(count::<Sun>(app), 1);
    assert_eq!(count::<Camera3d>(app), 0, "the file's own cameras must not draw");
}

#[test]
fn a_glb_outside_the_assets_becomes_ready_with_a_shot_that_frames_it() {
    let folder = tempfile::tempdir().unwrap();
    // A folder name that Bevy's own path syntax would split at.
    let odd = folder.path().join("odd #1");
    fs::create_dir(&odd).unwrap();
    fs::write(odd.join("model.glb"), glb(&triangle(None), &positions(), 0)).unwrap();
    let mut app = app_with(&root());
    check_triangle(&mut app, odd.join("model.glb"));
    // Again, and away.
    check_triangle(&mut app, odd.join("model.glb"));
    request(&mut app, SceneSource::level("room/plane_box"));
    wait(&mut app).unwrap();
    assert_eq!(count::<Mesh3d>(&mut app), 2);
}

#[test]
fn a_gltf_finds_the_files_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.gltf"), triangle(Some("model.bin"))).unwrap();
    fs::write(folder.path().join("model.bin"), positions()).unwrap();
    check_triangle(&mut app_with(&root()), folder.path().join("model.gltf"));
}

#[test]
fn gltf_files_that_bevy_refuses_fail_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: Vec<u8>| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let empty = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{}]}"#;
    let cases = [
        (
            write("no-scene.glb", glb(r#"{"asset":{"version":"2.0"}}"#, &[], 0)),
            "holds no scene",
        ),
        (write("no-mesh.glb", glb(empty, &[], 0)), "holds no triangles"),
        (write("garbage.glb", glb(r#"{"asset": 7}"#, &[], 0)), "garbage.glb"),
        (
            write("no-buffer.gltf", triangle(Some("gone.bin")).into_bytes()),
            "gone.bin",
        ),
        (
            write("short-buffer.glb", glb(&triangle(None), &positions()[..12], 0)),
            "short-buffer.glb",
        ),
    ];
    let mut app = app_with(&root());
    for (path, part) in cases {
        request(&mut app, SceneSource::Gltf(path));
        let sentence = wait(&mut app).unwrap_err();
        assert!(sentence.contains(part), "{sentence}");
        assert_eq!(sentence.lines().count(), 1, "{sentence}");
    }
}
