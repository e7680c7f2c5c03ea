//! The guard: every technique in every analytic room against ray-traced truth, with bounds.
//!
//! A change that makes a technique worse anywhere fails here, and one that breaks a matrix fails by far:
//! [`a_shift_by_two_texels_is_found`].

use bevy::{
    math::Mat4,
    pbr::LightEntity,
    prelude::*,
    render::{Render, RenderApp, RenderSystems, view::ExtractedView},
};
use umbrage::render::{
    extract::ExtractedSun,
    reference::{accuracy, pixels::PixelTruth},
};

use crate::room::{Room, SIZE};

/// A sixteenth of the default budget, as suits a small picture: 1024² texels in all.
const TECHNIQUES: [&str; 6] = [
    "bevy",
    "uniform:size=1024",
    "lispsm:size=1024",
    "zp4+lispsm:size=512",
    "lispsm:path=dropin,size=1024",
    "zp4+lispsm:path=dropin,size=512",
];

/// What was measured on llvmpipe: valid pixels, those of them in shadow, and the percentage that each of [`TECHNIQUES`]
/// has wrong.
struct Measured {
    room: &'static str,
    shot: &'static str,
    valid: u32,
    in_shadow: u32,
    wrong_percent: [f64; TECHNIQUES.len()],
}

impl Measured {
    /// The last column was taken again with the slices of `maths::drop_in`: 8 shots are better, 5 worse, most of all the fence
    /// from near (0.95 before), whose nearest metre has fewer texels now.
    /// The fourth was taken again with measured near planes: 10 shots are better, three as they were, and from the far end a shadow
    /// of one row of pixels, in texels of 15, is lost (0.12 before).
    ///
    /// The same machine measures the same; other drivers rasterize edges of casters otherwise, which flips pixels along
    /// shadow edges. A quarter more covers that where many pixels are wrong, 0.05 % (8 to 16 pixels) where few are.
    fn bound_percent(&self, technique: usize) -> f64 {
        1.25 * self.wrong_percent[technique] + 0.05
    }
}

const fn measured(
    room: &'static str,
    shot: &'static str,
    valid: u32,
    in_shadow: u32,
    wrong_percent: [f64; TECHNIQUES.len()],
) -> Measured {
    Measured {
        room,
        shot,
        valid,
        in_shadow,
        wrong_percent,
    }
}

#[rustfmt::skip]
const MEASURED: [Measured; 14] = [
    //       room             shot          valid  dark   bevy   uniform lispsm zp4+lis …dropin …dropin
    measured("plane_box",     "corner",     24572,  420, [0.212, 0.024, 0.012, 0.004, 0.012, 0.020]),
    measured("plane_box",     "low-sun",    16553,  421, [0.284, 0.036, 0.036, 0.006, 0.024, 0.036]),
    measured("plane_box",     "above",      32013,  251, [0.084, 0.009, 0.009, 0.009, 0.006, 0.009]),
    measured("long_plane",    "along",      15519,  289, [0.058, 2.313, 0.006, 0.000, 0.316, 0.006]),
    measured("long_plane",    "across",     20610,   77, [0.335, 0.432, 0.184, 0.068, 0.340, 0.184]),
    measured("long_plane",    "far-end",    14326,  184, [0.740, 1.284, 0.140, 0.607, 0.984, 0.447]),
    measured("dueling_light", "against",    18473,  920, [0.476, 0.996, 0.428, 0.352, 0.374, 0.384]),
    measured("dueling_light", "with",       21779, 1125, [0.257, 0.923, 0.652, 0.243, 0.661, 0.142]),
    measured("dueling_light", "into-light", 19850,  185, [0.161, 0.151, 0.161, 0.181, 0.202, 0.282]),
    measured("fence",         "along",      14886, 1381, [14.154, 2.230, 0.484, 0.443, 1.129, 1.028]),
    measured("fence",         "near",       18379, 3512, [24.582, 3.656, 0.669, 0.658, 1.088, 1.415]),
    measured("fence",         "far",        17588,  435, [2.473, 0.574, 0.216, 0.262, 0.807, 0.893]),
    measured("wires",         "under",      17277,  710, [0.996, 3.282, 0.365, 0.457, 0.399, 0.585]),
    measured("wires",         "beside",     16427,   90, [0.481, 0.511, 0.298, 0.317, 0.402, 0.408]),
];

impl Room {
    /// All techniques on all shots of the room.
    fn measure(&mut self) -> Vec<Found> {
        let mut all_found = Vec::new();
        for shot in self.shots.clone() {
            self.aim(&shot);
            let mut truth = Vec::new();
            let mut found = Found::new(&shot.name);
            for (technique, wrong_percent) in TECHNIQUES.iter().zip(&mut found.wrong_percent) {
                self.apply(technique, shot.far);
                let (mask, depths) = self.draw();
                if truth.is_empty() {
                    truth = self.trace(&shot, &depths).1.truth;
                }
                *wrong_percent = 100.0 * accuracy::compare(SIZE, &mask, &truth).overall.wrong_share();
            }
            let count = |wanted| truth.iter().filter(|pixel| **pixel == wanted).count() as u32;
            found.in_shadow = count(PixelTruth::Shadow);
            found.valid = found.in_shadow + count(PixelTruth::Lit);
            println!("{}: {found:.3?}", self.name);
            all_found.push(found);
        }
        all_found
    }
}

/// The measurement of one shot.
#[derive(Debug)]
struct Found {
    shot: String,
    valid: u32,
    in_shadow: u32,
    wrong_percent: [f64; TECHNIQUES.len()],
}

impl Found {
    fn new(shot: &str) -> Self {
        Self {
            shot: shot.to_owned(),
            valid: 0,
            in_shadow: 0,
            wrong_percent: [0.0; TECHNIQUES.len()],
        }
    }

    /// What was measured of it before.
    fn measured(&self, room: &str) -> &'static Measured {
        let same = |measured: &&Measured| measured.room == room && measured.shot == self.shot;
        MEASURED
            .iter()
            .find(same)
            .unwrap_or_else(|| panic!("{room}, shot {} has no bounds; it has {self:.3?}", self.shot))
    }
}

/// Every shot of a room within its bounds.
#[track_caller]
fn guard(room: &'static str) {
    let all_found = Room::load(room).measure();
    let known = MEASURED.iter().filter(|measured| measured.room == room).count();
    assert_eq!(all_found.len(), known, "shots of {room}");
    for found in all_found {
        let measured = found.measured(room);
        // An empty picture, or one without shadows, would pass all bounds.
        assert!(
            found.valid * 10 > measured.valid * 9 && found.in_shadow * 10 > measured.in_shadow * 9,
            "{room}, {}: {} valid pixels, {} in shadow; there were {} and {}",
            found.shot,
            found.valid,
            found.in_shadow,
            measured.valid,
            measured.in_shadow
        );
        for (index, technique) in TECHNIQUES.iter().enumerate() {
            let (wrong, bound) = (found.wrong_percent[index], measured.bound_percent(index));
            assert!(
                wrong <= bound,
                "{room}, {}, {technique}: {wrong:.3} % wrong, bound {bound:.3}",
                found.shot
            );
        }
    }
}

#[test]
fn a_cube_on_a_plane_is_within_bounds() {
    guard("plane_box");
}

#[test]
fn poles_to_the_horizon_are_within_bounds() {
    guard("long_plane");
}

#[test]
fn light_along_the_view_is_within_bounds() {
    guard("dueling_light");
}

#[test]
fn a_fence_is_within_bounds() {
    guard("fence");
}

#[test]
fn wires_are_within_bounds() {
    guard("wires");
}

/// Texels by which maps are read beside where they were drawn.
#[derive(Resource)]
struct Fault {
    texels: f32,
}

impl Fault {
    /// Beside `clip_from_world`, in a map of this many texels across.
    fn beside(&self, clip_from_world: Mat4, map_size: u32) -> Mat4 {
        Mat4::from_translation(Vec3::X * (2.0 * self.texels / map_size as f32)) * clip_from_world
    }
}

/// After casters have their views, and before matrices go to the GPU.
fn break_matrices(
    fault: Res<Fault>,
    mut suns: Query<&mut ExtractedSun>,
    mut cascades: Query<(&mut ExtractedView, &LightEntity)>,
) {
    // The full path reads what it has extracted, and its casters have views of their own by now.
    for mut sun in &mut suns {
        let size = sun.settings.map_size;
        for light_view in &mut sun.light_views {
            light_view.clip_from_world = fault.beside(light_view.clip_from_world, size);
        }
    }
    // Bevy's lookup has its matrices by now; its casters are drawn with those of the views.
    for (mut view, _) in &mut cascades {
        let size = view.viewport.z;
        view.clip_from_world = view.clip_from_world.map(|matrix| fault.beside(matrix, size));
    }
}

/// The guard can fail: where maps are read two texels beside where they were drawn, every technique leaves its bounds
/// in one of two shots. (A fence has most of the pixels at the edges of shadows; stock cascades are so wrong there that
/// a box shows it better.)
#[test]
fn a_shift_by_two_texels_is_found() {
    let mut is_found = [false; TECHNIQUES.len()];
    for name in ["fence", "plane_box"] {
        let mut room = Room::load(name);
        room.shots.truncate(1);
        let render_app = room.harness.app.sub_app_mut(RenderApp);
        render_app
            .insert_resource(Fault { texels: 2.0 })
            .add_systems(Render, break_matrices.in_set(RenderSystems::Queue));
        for found in room.measure() {
            for (index, is_found) in is_found.iter_mut().enumerate() {
                *is_found |= found.wrong_percent[index] > found.measured(name).bound_percent(index);
            }
        }
    }
    for (technique, is_found) in TECHNIQUES.iter().zip(is_found) {
        assert!(is_found, "{technique} stays within its bounds although it is broken");
    }
}
