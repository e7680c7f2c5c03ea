//! Pictures that `shoot` takes, on whatever adapter there is.

use std::{collections::BTreeSet, fs, path::Path, thread, time::Duration};

use bevy::prelude::*;
use image::{GrayImage, RgbImage};
use serde_json::Value;
use umbrage::{
    cli::headless,
    level::{LevelPlugin, RequestedScene, SceneStatus, find::asset_root},
};

use crate::{glb, run_in, stderr};

const SHOTS: &str = r#"{"shots":[
    {"name":"front","position":[3.5,3.5,5],"target":[0,1,0],"light_dir":[1,-1,0.3],"far":60,"width":160,"height":90}
]}"#;

fn rgb(path: &Path) -> RgbImage {
    image::open(path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .into_rgb8()
}

fn gray(path: &Path) -> GrayImage {
    image::open(path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .into_luma8()
}

#[track_caller]
fn shoot(folder: &Path, arguments: &str) {
    let output = run_in(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

fn box_scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    fs::write(folder.path().join("shots.json"), SHOTS).expect("written");
    folder
}

#[test]
fn the_mask_explains_the_beauty() {
    let folder = box_scene();
    shoot(
        folder.path(),
        "shoot box.glb --shots shots.json --technique bevy --passes beauty,lit,mask,depth,normal --out a/b",
    );
    let out = folder.path().join("a/b");
    let file = |pass: &str| out.join(format!("box_front_bevy_{pass}.png"));
    let (beauty, lit, mask) = (rgb(&file("beauty")), rgb(&file("lit")), gray(&file("mask")));
    assert_eq!(beauty.dimensions(), (160, 90));
    let depth = image::open(file("depth")).expect("a picture").into_luma16();
    let normal = rgb(&file("normal"));

    let (mut lit_pixels, mut dark_pixels, mut wrong) = (0, 0, 0);
    for (x, y, value) in mask.enumerate_pixels() {
        let (with, without) = (beauty.get_pixel(x, y), lit.get_pixel(x, y));
        let is_sky = depth.get_pixel(x, y).0 == [u16::MAX];
        let faces_away = normal.get_pixel(x, y).0 == [255, 128, 128] || normal.get_pixel(x, y).0 == [128, 128, 255];
        match value.0 {
            [255] => {
                lit_pixels += usize::from(!is_sky);
                wrong += usize::from(with != without);
            }
            [0] if !faces_away => {
                dark_pixels += 1;
                wrong += usize::from(with.0[0] >= without.0[0]);
            }
            _ => assert!(!is_sky, "the sky is lit"),
        }
    }
    assert!(
        lit_pixels > 2000 && dark_pixels > 300,
        "{lit_pixels} lit, {dark_pixels} dark"
    );
    // Position and normal of the prepass are rounded, so that single pixels at the edge of the filter may differ.
    assert!(
        wrong * 1000 <= lit_pixels + dark_pixels,
        "{wrong} pixels contradict the mask"
    );

    let stats: Value = serde_json::from_slice(&fs::read(out.join("stats.json")).expect("there")).expect("JSON");
    let take = &stats["takes"][0];
    assert_eq!(
        (take["casters"].as_u64(), take["maps"]["count"].as_u64()),
        (Some(2), Some(4)),
        "{take}"
    );
    assert_eq!(take["maps"]["bytes"].as_u64(), Some(64 << 20));
    assert_eq!(take["light_views"].as_array().map(Vec::len), Some(4));
    assert_eq!(take["light_views"][3]["far_depth"].as_f64().map(f64::round), Some(60.0));
    assert_eq!(take["is_still"], Value::Bool(true));
    assert!(take["pass_ms"]["bevy_shadow_pass"]["cpu"].is_number(), "{take}");
    assert!(stats["adapter"]["name"].as_str().is_some_and(|name| !name.is_empty()));
    assert!(take["frame_ms"]["median"].as_f64().is_some_and(|time| time > 0.0));
}

#[test]
fn the_same_input_gives_the_same_pictures() {
    let folder = box_scene();
    for out in ["one", "two"] {
        shoot(
            folder.path(),
            &format!("shoot box.glb --shots shots.json --technique bevy --size 96x54 --out {out}"),
        );
    }
    let read = |out: &str| fs::read(folder.path().join(out).join("box_front_bevy_beauty.png")).expect("a picture");
    assert_eq!(read("one"), read("two"));
    assert_eq!(
        rgb(&folder.path().join("one/box_front_bevy_beauty.png")).dimensions(),
        (96, 54)
    );
}

#[test]
fn a_scene_without_shots_gets_one() {
    let folder = box_scene();
    let output = run_in(
        folder.path(),
        "shoot box.glb --technique bevy --size 64x36 --passes mask",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("box"), "a note says so: {}", stderr(&output));
    assert!(output.stdout.is_empty(), "silence in a pipe");
    let pictures: Vec<_> = fs::read_dir(folder.path().join("out"))
        .expect("a folder")
        .flatten()
        .collect();
    assert_eq!(pictures.len(), 2, "a picture and the statistics");
    let mask = pictures
        .iter()
        .map(fs::DirEntry::path)
        .find(|path| path.extension().is_some_and(|end| end == "png"));
    let mask = gray(&mask.expect("a picture"));
    assert!(mask.pixels().any(|pixel| pixel.0 == [0]) && mask.pixels().any(|pixel| pixel.0 == [255]));
}

#[test]
fn shards_share_the_shots() {
    let folder = box_scene();
    let shot = |name: &str| {
        format!(
            r#"{{"name":"{name}","position":[6,5,8],"target":[0,1,0],"light_dir":[1,-1,0.3],"width":32,"height":18}}"#
        )
    };
    let list = ["a", "b", "c"].map(shot).join(",");
    fs::write(folder.path().join("shots.json"), format!("{{\"shots\":[{list}]}}")).expect("written");
    shoot(
        folder.path(),
        "shoot box.glb --shots shots.json --technique bevy --shard 2/2",
    );
    let out = folder.path().join("out");
    let names: BTreeSet<_> = fs::read_dir(out)
        .expect("a folder")
        .flatten()
        .map(|entry| entry.file_name())
        .collect();
    assert_eq!(
        names,
        BTreeSet::from(["box_b_bevy_beauty.png".into(), "stats.2-of-2.json".into()])
    );
}

/// A ground and 300 cubes.
fn field() -> Vec<glb::Node> {
    let mut nodes = glb::box_on_plane();
    nodes.truncate(1);
    nodes[0].scale = [80.0, 1.0, 80.0];
    nodes.extend((0..300).map(|index| glb::Node {
        mesh: glb::Mesh::Cube,
        translation: [(index % 20) as f32 * 3.0 - 30.0, 0.5, (index / 20) as f32 * 3.0 - 22.0],
        scale: [1.0; 3],
    }));
    nodes
}

#[test]
fn nodes_that_share_a_mesh_stay_instances() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("field.glb");
    glb::write(&path, &field());
    let root = asset_root(None).expect("the crate has levels");
    let mut app = headless::app(&root).expect("a graphics adapter: install mesa-vulkan-drivers");
    app.add_plugins(LevelPlugin { assets: root });
    headless::finish(&mut app);
    let scene = path.to_str().expect("text").parse().expect("a scene");
    app.insert_resource(RequestedScene(Some(scene)));
    for _ in 0..10_000 {
        app.update();
        match app.world().resource::<SceneStatus>() {
            SceneStatus::Ready => break,
            SceneStatus::Failed(problem) => panic!("{problem}"),
            _ => thread::sleep(Duration::from_millis(1)),
        }
    }
    let world = app.world_mut();
    let mut meshes = world.query::<(&Mesh3d, &MeshMaterial3d<StandardMaterial>)>();
    let pairs: Vec<_> = meshes
        .iter(world)
        .map(|(mesh, material)| (mesh.id(), material.id()))
        .collect();
    assert_eq!(pairs.len(), 301);
    assert_eq!(BTreeSet::from_iter(&pairs).len(), 2, "one ground, one cube");
}

#[test]
fn hundreds_of_instances_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("field.glb"), &field());
    fs::write(
        folder.path().join("shots.json"),
        SHOTS.replace("[3.5,3.5,5]", "[0,20,40]"),
    )
    .expect("written");
    shoot(
        folder.path(),
        "shoot field.glb --shots shots.json --technique bevy --passes mask --size 160x90",
    );
    let stats = fs::read(folder.path().join("out/stats.json")).expect("there");
    let stats: Value = serde_json::from_slice(&stats).expect("JSON");
    assert_eq!(stats["takes"][0]["casters"].as_u64(), Some(301));
    let mask = gray(&folder.path().join("out/field_front_bevy_mask.png"));
    let dark = mask.pixels().filter(|pixel| pixel.0[0] < 128).count();
    assert!(dark > 500, "the cubes throw shadows: {dark} pixels");
}

/// Scherzer 2005, figure 6: the command of the README, small. Without a bias surfaces shade themselves.
#[test]
fn the_three_by_three_comparison_shows_what_biases_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let techniques = [
        "bias=none",
        "bias=slope,bias_scale=0,bias_units=30000",
        "bias=slope",
        "bias_m=0",
        "bias_m=0.1",
        "bias=world-slope",
        "store=back,bias=none",
        "store=back,bias_m=0.1",
        "store=back,bias=slope",
    ];
    let techniques: String = (techniques.iter())
        .map(|keys| format!(" --technique lispsm:size=256,{keys}"))
        .collect();
    let scene = "shoot room/plane_box --shot corner --size 96x54 --passes mask --sheet 3";
    shoot(folder.path(), &format!("{scene}{techniques}"));
    let out = folder.path().join("out");
    let sheet = rgb(&out.join("room-plane-box_corner_sheet_mask.png"));
    assert!(
        sheet.width() > 3 * 96 && sheet.height() > 3 * 54,
        "{:?}",
        sheet.dimensions()
    );

    let stats: Value = serde_json::from_slice(&fs::read(out.join("stats.json")).expect("there")).expect("JSON");
    let takes = stats["takes"].as_array().expect("takes");
    let dark: Vec<usize> = (takes.iter())
        .map(|take| {
            let file = take["files"]["mask"].as_str().expect("a file");
            gray(&out.join(file)).pixels().filter(|pixel| pixel.0[0] < 128).count()
        })
        .collect();
    assert_eq!(dark.len(), 9);
    // Columns: none, a constant, by slope. Rows: in depth, in metres.
    for row in [0, 3] {
        let [none, constant, slope] = [dark[row], dark[row + 1], dark[row + 2]];
        assert!(none > slope + 100 && none > constant + 100, "{dark:?}: row {row}");
    }
    // Maps of back faces shade no lit surface, with any bias.
    assert!(dark[6] < dark[0] && dark[3] < 2 * dark[0], "{dark:?}");
}

/// What light planes gain, and what damping costs, is in the numbers of a take.
#[test]
fn films_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "shoot room/two_planes --size 64x36 --passes mask";
    shoot(
        folder.path(),
        &format!("{scene} --technique optimal:size=256,frusta=2 --technique lispsm:size=256"),
    );
    let stats = fs::read(folder.path().join("out/stats.json")).expect("there");
    let stats: Value = serde_json::from_slice(&stats).expect("JSON");
    let films = &stats["takes"][0]["films"];
    assert_eq!(films["count"].as_u64(), Some(2), "{films}");
    let number = |name: &str| films[name].as_f64().expect("a number");
    assert!(number("gain") > 1.0 && number("mean_error") > 0.0, "{films}");
    assert!((0.0..=5.0).contains(&number("damping_cost_percent")), "{films}");
    let lispsm = stats["takes"].as_array().expect("takes").last().expect("a take");
    assert!(lispsm["films"].is_null(), "{lispsm}");
    // All films lie in one square.
    let maps = &stats["takes"][0]["maps"];
    let side = |name: &str| maps[name].as_u64().expect("texels");
    assert_eq!(side("texels"), 256 * 256 + side("fallback_size").pow(2), "{maps}");
}
