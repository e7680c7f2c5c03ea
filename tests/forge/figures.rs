//! The committed figures: skins, clips, and feet on the ground, worked out from the files alone.

use std::{collections::BTreeMap, fs, path::PathBuf};

use bevy_math::{Mat4, Quat, Vec3};
use gltf::{
    Gltf,
    animation::{Interpolation, util::ReadOutputs},
};

const FIGURES: [&str; 2] = ["deer", "walker"];

/// Bytes of both files.
const BUDGET: u64 = 1_300_000;

struct Figure {
    file: Gltf,
    binary: Vec<u8>,
}

/// Rotation keys of one joint.
type Turns = (usize, Vec<Quat>);

/// An animation's keys.
struct Clip {
    times: Vec<f32>,
    /// Node and places of the first joint.
    root: (usize, Vec<Vec3>),
    turns: Vec<Turns>,
}

fn path(name: &str) -> PathBuf {
    let models = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/models");
    models.join(format!("{name}.glb"))
}

impl Figure {
    fn read(name: &str) -> Self {
        let bytes = fs::read(path(name)).unwrap_or_else(|error| panic!("{name}: {error}; run `umbrage forge`"));
        let mut file = Gltf::from_slice(&bytes).expect("a valid file");
        let binary = file.blob.take().expect("a binary chunk");
        Self { file, binary }
    }

    fn clip(&self, name: &str) -> Clip {
        let mut animations = self.file.animations();
        let animation = animations
            .find(|animation| animation.name() == Some(name))
            .expect("the clip");
        let (mut times, mut root, mut turns) = (Vec::new(), None, Vec::new());
        for channel in animation.channels() {
            assert_eq!(channel.sampler().interpolation(), Interpolation::Linear);
            let reader = channel.reader(|_| Some(&self.binary));
            times = reader.read_inputs().expect("times").collect();
            let node = channel.target().node().index();
            match reader.read_outputs().expect("values") {
                ReadOutputs::Translations(places) => root = Some((node, places.map(Vec3::from).collect())),
                ReadOutputs::Rotations(all) => turns.push((node, all.into_f32().map(Quat::from_array).collect())),
                _ => panic!("figures are moved by turns"),
            }
        }
        Clip {
            times,
            root: root.expect("the first joint moves"),
            turns,
        }
    }

    fn metres(&self, clip: &str) -> f32 {
        let rig = self
            .file
            .nodes()
            .find(|node| node.name() == Some("rig"))
            .expect("a rig");
        let extras = rig.extras().as_ref().expect("extras").get();
        let extras: serde_json::Value = serde_json::from_str(extras).expect("JSON");
        extras["umbrage_metres"][clip].as_f64().expect("a number") as f32
    }

    /// Matrices of all nodes by name, `key` keys after the start of a clip (fractions between keys); the bind pose
    /// without a clip.
    fn matrices(&self, clip: Option<(&Clip, f32)>) -> BTreeMap<String, Mat4> {
        let mut locals: Vec<Mat4> = self
            .file
            .nodes()
            .map(|node| Mat4::from_cols_array_2d(&node.transform().matrix()))
            .collect();
        if let Some((clip, key)) = clip {
            let (first, t) = (key.floor() as usize, key.fract());
            for (node, turns) in &clip.turns {
                let next = (first + 1).min(turns.len() - 1);
                let place = locals[*node].w_axis.truncate();
                locals[*node] = Mat4::from_rotation_translation(turns[first].slerp(turns[next], t), place);
            }
            let (node, places) = &clip.root;
            let next = (first + 1).min(places.len() - 1);
            locals[*node].w_axis = places[first].lerp(places[next], t).extend(1.0);
        }
        let mut matrices = BTreeMap::new();
        let mut open: Vec<(gltf::Node, Mat4)> = Vec::new();
        let rig = self
            .file
            .nodes()
            .find(|node| node.name() == Some("rig"))
            .expect("a rig");
        open.push((rig, Mat4::IDENTITY));
        while let Some((node, above)) = open.pop() {
            let own = above * locals[node.index()];
            matrices.insert(node.name().expect("a name").to_owned(), own);
            open.extend(node.children().map(|child| (child, own)));
        }
        matrices
    }

    /// A point that goes with a joint, given in the bind pose, at `steps` even times of a loop.
    fn trace(&self, clip: &Clip, joint: &str, bind: Vec3, steps: usize) -> Vec<Vec3> {
        let own = self.matrices(None)[joint].inverse().transform_point3(bind);
        let last = (clip.times.len() - 1) as f32;
        let key = |step: usize| last * step as f32 / steps as f32;
        (0..steps)
            .map(|step| self.matrices(Some((clip, key(step))))[joint].transform_point3(own))
            .collect()
    }
}

#[test]
fn figures_stay_in_their_budget() {
    let total: u64 = FIGURES
        .iter()
        .map(|name| fs::metadata(path(name)).expect("the file").len())
        .sum();
    assert!(total < BUDGET, "{total} bytes");
}

#[test]
fn every_vertex_hangs_on_joints_with_weights_that_sum_to_one() {
    for name in FIGURES {
        let figure = Figure::read(name);
        assert_eq!(figure.file.skins().count(), 1, "{name}: all levels share one skin");
        let joint_count = figure.file.skins().next().expect("a skin").joints().count();
        for node in figure.file.nodes().filter(|node| node.mesh().is_some()) {
            assert_eq!(node.skin().map(|skin| skin.index()), Some(0), "{:?}", node.name());
            for primitive in node.mesh().expect("checked").primitives() {
                let reader = primitive.reader(|_| Some(&figure.binary));
                let joints: Vec<[u16; 4]> = reader.read_joints(0).expect("joints").into_u16().collect();
                let weights: Vec<[u8; 4]> = reader.read_weights(0).expect("weights").into_u8().collect();
                assert_eq!(joints.len(), reader.read_positions().expect("positions").count());
                for (joints, weights) in joints.iter().zip(&weights) {
                    assert_eq!(weights.iter().map(|weight| u32::from(*weight)).sum::<u32>(), 255);
                    assert!(joints.iter().all(|joint| usize::from(*joint) < joint_count));
                }
            }
        }
    }
}

#[test]
fn inverse_bind_matrices_undo_the_bind_pose() {
    for name in FIGURES {
        let figure = Figure::read(name);
        let bind = figure.matrices(None);
        let skin = figure.file.skins().next().expect("a skin");
        let reader = skin.reader(|_| Some(&figure.binary));
        let inverse: Vec<[[f32; 4]; 4]> = reader.read_inverse_bind_matrices().expect("matrices").collect();
        assert_eq!(inverse.len(), skin.joints().count());
        for (joint, inverse) in skin.joints().zip(inverse) {
            let product = bind[joint.name().expect("a name")] * Mat4::from_cols_array_2d(&inverse);
            assert!(product.abs_diff_eq(Mat4::IDENTITY, 1e-6), "{name} {:?}", joint.name());
        }
        for scene in figure.file.scenes() {
            assert_eq!(
                scene.nodes().next().and_then(|node| node.name()),
                Some("rig"),
                "joints are in every scene"
            );
        }
    }
}

#[test]
fn clips_are_closed_loops_of_unit_quaternions() {
    for (name, clips) in [("deer", ["walk", "graze"]), ("walker", ["walk", "stand"])] {
        let figure = Figure::read(name);
        for clip in clips {
            let clip = figure.clip(clip);
            assert!(clip.times.windows(2).all(|pair| pair[0] < pair[1]) && clip.times[0] == 0.0);
            assert!(clip.times.len() > 24);
            assert_eq!(clip.root.1.first(), clip.root.1.last());
            for (node, turns) in &clip.turns {
                assert_eq!(turns.len(), clip.times.len());
                assert_eq!(turns.first(), turns.last(), "{name}: node {node}");
                assert!(turns.iter().all(|turn| (turn.length() - 1.0).abs() < 1e-5));
                assert!(
                    turns.windows(2).all(|pair| pair[0].dot(pair[1]) > 0.8),
                    "{name}: node {node} jumps"
                );
            }
        }
    }
}

/// Points of the soles in the bind pose.
fn soles(name: &str) -> Vec<(&'static str, Vec3)> {
    let at = Vec3::new;
    match name {
        "deer" => vec![
            ("hind_hoof_l", at(0.11, 0.0, -0.49)),
            ("hoof_l", at(0.10, 0.0, 0.36)),
            ("hind_hoof_r", at(-0.11, 0.0, -0.49)),
            ("hoof_r", at(-0.10, 0.0, 0.36)),
        ],
        _ => vec![
            ("foot_l", at(0.095, 0.0, -0.075)),
            ("foot_l", at(0.095, 0.0, 0.10)),
            ("foot_r", at(-0.095, 0.0, -0.075)),
            ("foot_r", at(-0.095, 0.0, 0.10)),
        ],
    }
}

#[test]
fn feet_stay_above_the_ground_and_do_not_slide() {
    let steps = 240;
    for name in FIGURES {
        let figure = Figure::read(name);
        let walk = figure.clip("walk");
        let ahead = figure.metres("walk") / steps as f32;
        for (joint, point) in soles(name) {
            let trace = figure.trace(&walk, joint, point, steps);
            let (mut on_ground, mut slid, mut landed) = (0, 0.0_f32, None);
            for step in 0..steps {
                let here = trace[step];
                assert!(here.y > -0.006, "{name} {joint}: {here} at {step}");
                if here.y < 0.0015 {
                    on_ground += 1;
                    // Where the body goes, a foot on the ground stays behind.
                    let in_world = (here + Vec3::Z * (ahead * step as f32)).with_y(0.0);
                    slid = slid.max(in_world.distance(*landed.get_or_insert(in_world)));
                } else {
                    landed = None;
                }
            }
            let lands = |step: &usize| {
                let before = trace[(step + steps - 1) % steps];
                before.y >= 0.0015 && trace[*step].y < 0.0015
            };
            let landings = (0..steps).filter(lands).count();
            assert_eq!(landings, 1, "{name} {joint}: touches the ground once in a cycle");
            // Heel and ball touch the ground in turn; hooves all the time that the leg stands.
            assert!(on_ground > steps / 4, "{name} {joint}: {on_ground} of {steps}");
            assert!(slid < 0.01, "{name} {joint}: slides {slid} m while on the ground");
        }
        for rest in ["graze", "stand"] {
            if figure.file.animations().any(|animation| animation.name() == Some(rest)) {
                assert_eq!(figure.metres(rest), 0.0);
                let clip = figure.clip(rest);
                for (joint, point) in soles(name) {
                    let trace = figure.trace(&clip, joint, point, 60);
                    let far = trace.iter().map(|p| (*p - trace[0]).length()).fold(0.0, f32::max);
                    assert!(
                        far < 0.006 && trace[0].y.abs() < 0.003,
                        "{name} {joint} moves {far} m in {rest}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_deer_walks_in_the_lateral_sequence() {
    let figure = Figure::read("deer");
    let walk = figure.clip("walk");
    let steps = 120;
    let touch_down = |(joint, point): (&str, Vec3)| {
        let trace = figure.trace(&walk, joint, point, steps);
        let lands = |step: &usize| trace[(*step + steps - 1) % steps].y >= 0.003 && trace[*step].y < 0.003;
        (0..steps).find(lands).expect("it is lifted") as f32 / steps as f32
    };
    let beats: Vec<f32> = soles("deer").into_iter().map(touch_down).collect();
    for (beat, expected) in beats.iter().zip([0.0, 0.25, 0.5, 0.75]) {
        let apart = (beat - beats[0] - expected).rem_euclid(1.0);
        assert!(
            apart < 0.04 || apart > 0.96,
            "{beats:?}: left hind, left fore, right hind, right fore"
        );
    }
}

#[test]
fn a_grazing_deer_reaches_the_grass_and_looks_up() {
    let figure = Figure::read("deer");
    let muzzle = figure.trace(&figure.clip("graze"), "head", Vec3::new(0.0, 1.38, 1.06), 60);
    let low = muzzle.iter().map(|p| p.y).fold(f32::MAX, f32::min);
    let high = muzzle.iter().map(|p| p.y).fold(0.0, f32::max);
    assert!((0.03..0.16).contains(&low) && high > 1.2, "{low} to {high} m");
}

#[test]
fn left_and_right_are_alike() {
    for name in FIGURES {
        let figure = Figure::read(name);
        for node in figure.file.nodes().filter(|node| node.mesh().is_some()) {
            for primitive in node.mesh().expect("checked").primitives() {
                let bagged = node.name().is_some_and(|name| name.starts_with("walker_coat"));
                if bagged && primitive.material().name() == Some("walker") {
                    continue;
                }
                let reader = primitive.reader(|_| Some(&figure.binary));
                let key = |[x, y, z]: [f32; 3]| [x, y, z].map(|c| (c * 1e5).round() as i64);
                let points: std::collections::BTreeSet<_> =
                    reader.read_positions().expect("positions").map(key).collect();
                for [x, y, z] in &points {
                    assert!(points.contains(&[-x, *y, *z]), "{:?}: {x} {y} {z}", node.name());
                }
            }
        }
    }
}

#[test]
fn figures_are_as_large_as_their_kind() {
    for (name, low, high) in [
        ("stag_LOD0", 2.1, 2.4),
        ("hind_LOD0", 1.5, 1.8),
        ("walker_jacket_LOD0", 1.70, 1.80),
        ("walker_coat_LOD0", 1.70, 1.80),
        ("walker_hat_LOD0", 1.75, 1.88),
    ] {
        let figure = Figure::read(if name.starts_with("walker") { "walker" } else { "deer" });
        let node = figure
            .file
            .nodes()
            .find(|node| node.name() == Some(name))
            .expect("the node");
        let boxes: Vec<_> = node
            .mesh()
            .expect("a mesh")
            .primitives()
            .map(|p| p.bounding_box())
            .collect();
        let top = boxes.iter().map(|b| b.max[1]).fold(0.0, f32::max);
        let foot = boxes.iter().map(|b| b.min[1]).fold(1.0, f32::min);
        assert!((low..high).contains(&top), "{name} is {top} m high");
        assert!(foot.abs() < 0.012, "{name} stands at {foot} m");
    }
}
