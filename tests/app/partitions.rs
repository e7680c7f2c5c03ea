//! Face partitions, balanced maps, seams and the variants of the fit.

use bevy::prelude::*;
use umbrage::{
    maths::{split::SplitScheme, warp::Warp},
    shadow::{
        settings::{Faces, PartitionSelection, SeamWidth, ShadowPath, SunShadows},
        technique::Technique,
        views::CameraSunViews,
    },
};

use crate::support::{app, spawn_camera, spawn_sun, spawn_town, views};

fn settings(text: &str) -> SunShadows {
    match text.parse() {
        Ok(Technique::Umbrage(settings)) => settings,
        other => panic!("{text}: {other:?}"),
    }
}

/// A town, a camera and a sun.
struct Town {
    app: App,
    camera: Entity,
    sun: Entity,
}

impl Town {
    fn new(settings: SunShadows) -> Self {
        let mut app = app();
        spawn_town(&mut app);
        let camera = spawn_camera(&mut app);
        let sun = spawn_sun(&mut app, settings);
        Self { app, camera, sun }
    }

    fn views(&mut self, light_travel: Vec3) -> CameraSunViews {
        let up = if light_travel.x.abs() < 0.5 { Vec3::X } else { Vec3::Y };
        let sun = Transform::default().looking_to(light_travel, up);
        self.app.world_mut().entity_mut(self.sun).insert(sun);
        self.app.update();
        views(&self.app, self.sun, self.camera).expect("the camera sees the town")
    }

    fn eye(&self) -> GlobalTransform {
        *self.app.world().get::<GlobalTransform>(self.camera).expect("placed")
    }
}

/// Suns from all sides, one along the view.
fn suns() -> Vec<Vec3> {
    let mut suns = vec![Vec3::new(0.0, -0.02, -1.0), Vec3::new(0.0, -0.02, 1.0), Vec3::NEG_Y];
    for step in 0..12 {
        let angle = step as f32 / 12.0 * std::f32::consts::TAU;
        for height in [0.2, 1.0] {
            suns.push(Vec3::new(angle.cos(), -height, angle.sin()));
        }
    }
    suns
}

/// Points of the ground in view, with a spread across the picture.
fn seen_ground(eye: &GlobalTransform) -> Vec<Vec3> {
    let (eye, forward, right, up) = (eye.translation(), *eye.forward(), *eye.right(), *eye.up());
    let mut points = Vec::new();
    for depth in 1..40 {
        for across in -2..=2 {
            let depth = 2.5 + depth as f32;
            let point = (eye + forward * depth + right * (across as f32 * 0.2 * depth)).with_y(0.0);
            // Half the opening of Bevy's camera is 22.5 degrees.
            if (eye - point).dot(up) < 0.41 * (point - eye).dot(forward) {
                points.push(point);
            }
        }
    }
    points
}

fn is_in(clip_from_world: Mat4, point: Vec3) -> bool {
    let clip = clip_from_world * point.extend(1.0);
    let ndc = clip.truncate() / clip.w;
    clip.w > 0.0 && ndc.truncate().abs().max_element() < 1.0 && (0.0..=1.0).contains(&ndc.z)
}

#[test]
fn faces_hold_everything_that_is_seen() {
    for text in ["fp+lispsm", "fp2+lispsm", "fp", "fp4+lispsm", "fp2+lispsm:near_map=off"] {
        let settings = settings(text);
        let (most, slices) = (settings.partitions.maps() as usize, settings.partitions.count as usize);
        let mut town = Town::new(settings);
        for sun in suns() {
            let views = town.views(sun);
            let count = views.partitions.len();
            assert!(count >= slices && count <= most, "{text}, sun {sun}: {count} maps");
            let eye = town.eye();
            for point in seen_ground(&eye) {
                let depth = (point - eye.translation()).dot(*eye.forward());
                if depth < views.near_depth || depth > views.far_depth {
                    continue;
                }
                let holders = views
                    .partitions
                    .iter()
                    .map(|partition| partition.light_view.clip_from_world);
                assert!(
                    holders.into_iter().any(|matrix| is_in(matrix, point)),
                    "{text}, sun {sun}: {point} is in no map"
                );
            }
        }
    }
}

/// Lloyd, section 4.4 and oracle 17: with the light along the view one warped map is as bad as an unwarped one, faces are not.
#[test]
fn faces_warp_where_one_map_cannot() {
    let along_the_view = Vec3::new(0.0, -0.02, -1.0);
    let is_warped = |views: &CameraSunViews| -> Vec<bool> {
        let bends = views.partitions.iter().map(|partition| {
            let rows = partition.light_view.clip_from_light.transpose();
            rows.w_axis.y.abs() > 1.0e-6
        });
        bends.collect()
    };
    let one = Town::new(settings("lispsm")).views(along_the_view);
    assert_eq!(is_warped(&one), [false], "the guard takes the warp away");
    let faces = Town::new(settings("fp+lispsm")).views(along_the_view);
    let warped = is_warped(&faces).iter().filter(|warped| **warped).count();
    assert!(warped >= 2, "{:?}", is_warped(&faces));
    let unwarped = Town::new(settings("fp")).views(along_the_view);
    assert!(
        is_warped(&unwarped).iter().all(|warped| !warped),
        "fp without a warp has none"
    );
}

/// Near the plane across the view both sets of faces are as good: the one in use stays.
#[test]
fn the_faces_do_not_flicker() {
    let mut town = Town::new(settings("fp+lispsm"));
    let sun = |share: f32| {
        let (forward, up) = (Vec3::NEG_Z, Vec3::Y);
        -up + forward * share + Vec3::X * 0.3
    };
    let sets: Vec<_> = [0.5, 0.03, 0.025, 0.02, 0.02, 0.025]
        .map(|share| town.views(sun(share)).face_set.expect("faces have a set"))
        .to_vec();
    assert!(sets.windows(2).all(|pair| pair[0] == pair[1]), "{sets:?}");
    let other = town.views(sun(-0.5)).face_set;
    assert_ne!(other, Some(sets[0]), "far on the other side it changes");
}

#[test]
fn balanced_maps_share_the_atlas() {
    for text in [
        "fp+lispsm:size=256",
        "fp3+lispsm:size=128",
        "zp4+lispsm:resolution=balanced,size=256",
    ] {
        let mut town = Town::new(settings(text));
        for sun in suns() {
            let views = town.views(sun);
            let layout = &views.layout;
            let rects: Vec<UVec4> = views
                .partitions
                .iter()
                .map(|partition| partition.light_view.atlas_rect)
                .collect();
            assert_eq!(rects, layout.rects);
            for (index, a) in rects.iter().enumerate() {
                assert!(
                    a.min_element() < layout.side && a.z >= 16 && a.w >= 16,
                    "{text}, sun {sun}: {a}"
                );
                assert!(
                    a.x + a.z <= layout.side && a.y + a.w <= layout.side,
                    "{text}, sun {sun}: {a} sticks out"
                );
                for b in &rects[..index] {
                    let is_apart = a.x + a.z <= b.x || b.x + b.z <= a.x || a.y + a.w <= b.y || b.y + b.w <= a.y;
                    assert!(is_apart, "{text}, sun {sun}: {a} overlaps {b}");
                }
            }
        }
    }
}

/// A still scene keeps its layout from frame to frame.
#[test]
fn balanced_maps_stay_in_their_place() {
    let mut town = Town::new(settings("fp2+lispsm"));
    let first = town.views(Vec3::new(0.3, -1.0, -0.4)).layout;
    let second = town.views(Vec3::new(0.302, -1.0, -0.401)).layout;
    assert_eq!(first, second);
}

#[test]
fn the_drop_in_path_has_no_faces() {
    let mut faces = settings("fp2+lispsm");
    faces.path = ShadowPath::DropIn;
    let views = Town::new(faces).views(Vec3::new(0.4, -1.0, -0.3));
    assert_eq!(views.partitions.len(), 2);
    assert_eq!(views.face_set, None);
}

/// Where maps are blended by depth, the next map holds the whole seam in front of it.
#[test]
fn maps_reach_into_the_seam_before_them() {
    let mut settings = settings("zp4+lispsm:select=depth,seam=0.2,split=uniform");
    assert_eq!(settings.selection, PartitionSelection::Depth);
    let sun = Vec3::new(0.4, -1.0, -0.3);
    let mut town = Town::new(settings.clone());
    let blended = town.views(sun);
    settings.seams.width = SeamWidth::None;
    let plain = Town::new(settings).views(sun);
    let eye = town.eye();
    for (index, pair) in blended.partitions.windows(2).enumerate() {
        let [view, next] = [&pair[0].light_view, &pair[1].light_view];
        let length = view.far_depth - view.near_depth;
        assert!(
            (view.seam_depth - 0.2 * length).abs() < 1.0e-4 * length,
            "{}",
            view.seam_depth
        );
        assert_eq!(view.far_depth, next.near_depth, "intervals do not overlap");
        let depth = view.far_depth - 0.95 * view.seam_depth;
        // On the rays through the lower corners of the picture: the border of what is focused on.
        let slope = pair[0].split_frustum[0] - eye.translation();
        let point = eye.translation() + slope * (depth / slope.dot(*eye.forward()));
        if point.y < 0.0 {
            continue;
        }
        assert!(is_in(next.clip_from_world, point), "seam {index}");
        assert!(
            !is_in(plain.partitions[index + 1].light_view.clip_from_world, point),
            "seam {index} without"
        );
    }
    assert!(
        plain
            .partitions
            .iter()
            .all(|partition| partition.light_view.seam_depth == 0.0)
    );
}

#[test]
fn every_slice_has_its_own_strength() {
    let views = Town::new(settings("zp2+free:etas=-1/0")).views(Vec3::new(0.9, -0.5, 0.0));
    let bend = |index: usize| views.partitions[index].light_view.clip_from_light.transpose().w_axis.y;
    assert_eq!(bend(0), 0.0, "the first is uniform");
    assert!(bend(1) > 0.0, "the second is not");
}

#[test]
fn unaligned_maps_do_not_turn_with_the_camera() {
    let axes = |text: &str, yaw: f32| {
        let mut town = Town::new(settings(text));
        let camera = Transform::from_xyz(0.0, 1.7, 10.0).with_rotation(Quat::from_rotation_y(yaw));
        town.app.world_mut().entity_mut(town.camera).insert(camera);
        let light_view = town.views(Vec3::new(0.4, -1.0, -0.3)).partitions[0].light_view.clone();
        light_view.world_from_light.y_axis
    };
    assert!(axes("uniform:align=off", 0.0).distance(axes("uniform:align=off", 0.6)) < 1.0e-6);
    assert!(axes("uniform", 0.0).distance(axes("uniform", 0.6)) > 0.1);
}

/// Stingl, equation 4.1: inner splits of the scheme over the pseudo planes, outer ones where they were.
#[test]
fn pseudo_planes_move_the_inner_splits() {
    let sun = Vec3::new(0.4, -1.0, -0.3);
    let mut planes = settings("zp2+lispsm:pseudo_near=5,pseudo_far=20");
    planes.partitions.scheme = SplitScheme::Logarithmic;
    let views = Town::new(planes).views(sun);
    let plain = Town::new(settings("zp2+lispsm:split=log")).views(sun);
    assert!(
        (views.partitions[0].light_view.far_depth - 10.0).abs() < 1.0e-4,
        "√(5 · 20)"
    );
    assert_eq!(views.near_depth, plain.near_depth);
    assert_eq!(
        views.partitions[1].light_view.far_depth,
        plain.partitions[1].light_view.far_depth
    );
}

#[test]
fn settings_reach_the_fit() {
    let sun = Vec3::new(0.7, -0.6, -0.2);
    let matrix = |text: &str| {
        Town::new(settings(text)).views(sun).partitions[0]
            .light_view
            .clip_from_world
    };
    let default = matrix("lispsm");
    for text in [
        "lispsm:center=vertex",
        "lispsm:axis=middle",
        "lispsm:optimum=demo",
        "lispsm:pseudo_near=9",
        "lispsm:pseudo_far=12",
    ] {
        assert_ne!(matrix(text), default, "{text}");
    }
    let is_guarded = (1..=10).any(|step| {
        let inside = Vec3::new(0.03, -0.03 * step as f32, -1.0);
        let matrix = |text: &str| {
            Town::new(settings(text)).views(inside).partitions[0]
                .light_view
                .clip_from_world
        };
        matrix("lispsm:guard=off") != matrix("lispsm")
    });
    assert!(is_guarded, "light from inside the view cone weakens the warp");
    assert_eq!(settings("lispsm").partitions.faces, Faces::Together);
    assert_eq!(settings("lispsm").warp, Warp::Lispsm);
}
