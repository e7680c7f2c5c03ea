//! Face partitions against Lloyd's oracles; what holds for random cameras is in `partition_properties`.

use bevy_math::{DVec2, DVec3, UVec2};
use umbrage::maths::{
    body::{intersection_body, light_visible},
    bounds::Bounds,
    error::LargestErrors,
    face::{FaceOptions, FacePartition, FaceSet, FrustumFace, face_partitions, partition_of_point},
    fit::{FitInput, FitOptions, WarpAxis, fit_light_view},
    polytope::Polytope,
    split::SplitScheme,
    view::ViewVolume,
    warp::Warp,
};

use crate::support::{OPENING, close, huge_scene, light_at, papers_camera, roomy_scene};

/// The partitions of the papers' camera, which sees nothing but the scene.
fn partitions(ratio: f64, light_travel: DVec3, options: &FaceOptions) -> (ViewVolume, Vec<FacePartition>) {
    let view = papers_camera(1.0, ratio);
    let visible = light_visible(&view, &huge_scene());
    let partitions = face_partitions(&view, &visible, light_travel, options);
    (view, partitions)
}

/// S̄ of all maps together, each with `LiSPSM`.
fn storage((view, partitions): &(ViewVolume, Vec<FacePartition>)) -> f64 {
    let errors = partitions.iter().map(|partition| partition.largest_errors(view, 0.0));
    errors.map(|errors| errors.storage_factor()).sum()
}

fn faces(partitions: &[FacePartition]) -> Vec<FrustumFace> {
    partitions.iter().map(|partition| partition.face).collect()
}

fn sliced(slices: usize) -> FaceOptions {
    FaceOptions {
        slices,
        ..FaceOptions::default()
    }
}

/// Lloyd's hemisphere: polar angle from overhead in `rows` steps, azimuth in `columns`; directions of travel.
pub(crate) fn hemisphere(rows: u32, columns: u32) -> impl Iterator<Item = DVec3> {
    (0..=rows).flat_map(move |row| {
        let polar = (90.0 * f64::from(row) / f64::from(rows)).to_radians();
        (0..if row == 0 { 1 } else { columns }).map(move |column| {
            let azimuth = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            -DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
        })
    })
}

/// Area of a body's outline along the light.
fn projected_area(body: &Polytope, light: DVec3) -> f64 {
    let faces = body
        .faces()
        .filter(|face| face.half_space.normal.dot(light) > 0.0)
        .map(|face| {
            let corner = |index: usize| body.vertices()[face.indices[index] as usize];
            let triangles = (1..face.indices.len() - 1)
                .map(|index| (corner(index) - corner(0)).cross(corner(index + 1) - corner(0)) * 0.5);
            triangles.sum::<DVec3>().dot(light)
        });
    faces.sum()
}

/// Lloyd, oracle 15: never far; one side for light from above; four and near for light from behind and from ahead.
#[test]
fn the_faces_with_the_narrowest_pixels_are_chosen() {
    use FrustumFace::{Bottom, Left, Near, Right, Top};
    for (degrees, expected) in [
        (90.0, vec![Top]),
        (0.0, vec![Bottom, Right, Top, Left, Near]),
        (180.0, vec![Bottom, Right, Top, Left, Near]),
        (80.0, vec![Right, Top, Left, Near]),
        (100.0, vec![Right, Bottom, Left, Near]),
        (25.0, vec![Bottom, Right, Top, Left, Near]),
        (155.0, vec![Bottom, Right, Top, Left, Near]),
    ] {
        let (_, partitions) = partitions(1000.0, light_at(degrees), &FaceOptions::default());
        let mut found = faces(&partitions);
        assert_eq!(found.len(), expected.len(), "{degrees}: {found:?}");
        found.retain(|face| !expected.contains(face));
        assert!(found.is_empty(), "{degrees}: {found:?} too many");
    }
}

/// Lloyd, oracle 15: the columns project onto the outline of the frustum exactly once.
#[test]
fn columns_cover_the_outline_once() {
    let view = papers_camera(1.0, 100.0);
    let visible = light_visible(&view, &huge_scene());
    for light in hemisphere(9, 16) {
        for near_partition in [true, false] {
            let options = FaceOptions {
                slices: 3,
                near_partition,
                ..FaceOptions::default()
            };
            let partitions = face_partitions(&view, &visible, light, &options);
            let sum: f64 = partitions
                .iter()
                .map(|partition| projected_area(&partition.receivers, light))
                .sum();
            close(sum, projected_area(&visible, light), 1.0e-6);
        }
    }
}

/// Lloyd, oracle 13 and equation 21 with k = 1: each side behaves like a camera of 45° half opening.
#[test]
fn storage_with_light_along_the_view() {
    for ratio in [10.0, 100.0, 1000.0, 10000.0] {
        for degrees in [0.0, 180.0] {
            let sum = storage(&partitions(ratio, light_at(degrees), &FaceOptions::default()));
            close(sum, 2.0 * (ratio - 1.0) + 1.0, 1.0e-6);
        }
    }
}

/// Lloyd, equations 19 and 21, with table 3.2: k slices of each side.
#[test]
fn storage_with_slices() {
    for (ratio, slices, overhead, behind) in [
        (10.0, 2, 3.745, 9.649),
        (100.0, 4, 7.490, 18.30),
        (1000.0, 2, 53.04, 123.5),
        (1000.0, 4, 16.02, 37.99),
        (1000.0, 16, 7.481, 18.28),
        (10000.0, 8, 14.98, 35.6),
    ] {
        close(
            storage(&partitions(ratio, light_at(90.0), &sliced(slices))),
            overhead,
            2.0e-3,
        );
        close(
            storage(&partitions(ratio, light_at(0.0), &sliced(slices))),
            behind,
            2.0e-3,
        );
    }
}

/// Lloyd, table 3.8: light in the plane of view and up; and oracle 14, ahead is like behind.
#[test]
fn storage_over_the_angle_of_light() {
    for (degrees, expected) in [
        (90.0, 865.2),
        (100.0, 1141.0),
        (110.0, 1450.0),
        (120.0, 1795.0),
        (130.0, 2167.0),
        (140.0, 2496.0),
        (145.0, 2595.0),
        (150.0, 2616.0),
        (155.0, 2636.0),
        (160.0, 2577.0),
        (170.0, 2314.0),
        (180.0, 1999.0),
    ] {
        for degrees in [degrees, 180.0 - degrees] {
            let sum = storage(&partitions(1000.0, light_at(degrees), &FaceOptions::default()));
            close(sum, expected, 1.0e-3);
        }
    }
}

/// Lloyd, table 3.8 and oracle 17: no peak anywhere on the hemisphere; table 3.9 for slices.
#[test]
fn storage_over_the_hemisphere() {
    for (ratio, slices, largest, mean) in [
        (100.0, 1, 308.0, 164.5),
        (1000.0, 1, 3024.0, 1645.0),
        (1000.0, 2, 197.1, 102.9),
        (1000.0, 4, 73.9, 32.7),
    ] {
        let mut sums: Vec<f64> = hemisphere(18, 36)
            .map(|light| storage(&partitions(ratio, light, &sliced(slices))))
            .collect();
        sums.sort_by(f64::total_cmp);
        close(sums[sums.len() - 1], largest, 3.0e-3);
        let logarithms: f64 = sums.iter().map(|sum| sum.ln()).sum();
        close((logarithms / sums.len() as f64).exp(), mean, 3.0e-2);
        assert!(sums[sums.len() - 1] <= 2.0 * (2.0 * (ratio - 1.0) + 1.0), "oracle 17");
    }
}

/// Lloyd, oracle 16.
#[test]
fn storage_of_the_near_face_is_the_cosine() {
    for degrees in [0.0_f64, 20.0, 40.0, 60.0, 85.0, 130.0, 170.0] {
        let (view, partitions) = partitions(100.0, light_at(degrees), &FaceOptions::default());
        let near = partitions.last().unwrap();
        assert_eq!((near.face, near.warped), (FrustumFace::Near, false));
        let errors = near.largest_errors(&view, 0.0);
        close(errors.storage_factor(), degrees.to_radians().cos().abs(), 1.0e-6);
    }
}

/// Lloyd, sections 5.2 and 5.3: sides stretched over the near face keep M_x, and M_z grows by
/// √α ÷ (√α − 1).
#[test]
fn stretched_sides_are_slightly_worse() {
    for (ratio, growth) in [(1000.0, 1.0327), (100.0, 1.1111), (10.0, 1.4625), (5.62, 1.7296)] {
        let errors = |near_partition| -> Vec<LargestErrors> {
            let options = FaceOptions {
                near_partition,
                ..FaceOptions::default()
            };
            let (view, partitions) = partitions(ratio, light_at(0.0), &options);
            let sides = partitions
                .iter()
                .filter(|partition| partition.face != FrustumFace::Near);
            sides.map(|partition| partition.largest_errors(&view, 0.0)).collect()
        };
        let (own, stretched) = (errors(true), errors(false));
        assert_eq!((own.len(), stretched.len()), (4, 4));
        for (own, stretched) in own.iter().zip(&stretched) {
            close(stretched.across, own.across, 1.0e-6);
            close(stretched.along / own.along, growth, 1.0e-3);
        }
    }
}

/// Lloyd, section 4.1 on a face: n' = n + √(n f) from the near edge, so √(n f) behind the projected eye; the bisector is
/// the camera's up direction for the top face with light from behind.
#[test]
fn the_warp_of_a_face() {
    for near_partition in [true, false] {
        let options = FaceOptions {
            near_partition,
            ..FaceOptions::default()
        };
        let (_, partitions) = partitions(100.0, light_at(0.0), &options);
        let top = partitions
            .iter()
            .find(|partition| partition.face == FrustumFace::Top)
            .unwrap();
        assert!(top.axes.y.distance(DVec3::Y) < 1.0e-9 && top.warped, "{top:?}");
        let half = OPENING * 0.5;
        close(top.near_along, half, 1.0e-9);
        close(top.far_along, 100.0 * half, 1.0e-9);
        close(top.warp_near(0.0) - top.start_along, 10.0 * half, 1.0e-9);
        assert_eq!(top.warp_near(-1.0), f64::INFINITY);
    }
}

/// Lloyd, section 5.1: the warp axis of a side halves the angle between its projected corner lines, for light from
/// anywhere. Their plain sum, as it is printed, leans to the longer one.
#[test]
fn the_axis_of_a_side_is_the_bisector() {
    let view = papers_camera(1.0, 100.0);
    let visible = light_visible(&view, &huge_scene());
    let corners = view.corners(1.0, 1.0);
    let (mut sides, mut leaning) = (0, 0);
    for light in hemisphere(9, 16) {
        for partition in face_partitions(&view, &visible, light, &FaceOptions::default()) {
            let edges = match partition.face {
                FrustumFace::Bottom => [0, 1],
                FrustumFace::Right => [1, 2],
                FrustumFace::Top => [2, 3],
                FrustumFace::Left => [3, 0],
                FrustumFace::All | FrustumFace::Near => continue,
            }
            .map(|corner| corners[corner].reject_from(light));
            let axis = partition.axes.y;
            let [first, second] = edges.map(|edge| axis.dot(edge.normalize()));
            close(first, second, 1.0e-9);
            assert!(
                first > 0.0 && axis.dot(light).abs() < 1.0e-9,
                "{:?} for {light}",
                partition.face
            );
            let in_their_middle = (edges[0].normalize() + edges[1].normalize()).normalize();
            assert!(
                axis.distance(in_their_middle) < 1.0e-6,
                "{:?} for {light}",
                partition.face
            );
            sides += 1;
            leaning += i32::from((edges[0] + edges[1]).normalize().distance(axis) > 0.05);
        }
    }
    assert!(
        sides > 300 && leaning > 60,
        "{sides} sides, of {leaning} the sum is another axis"
    );
}

/// What is drawn is what is computed: the fit of a partition has its n', also where a side is stretched over the near face.
#[test]
fn fits_have_the_warp_of_their_face() {
    let view = papers_camera(1.0, 100.0);
    let scene = roomy_scene();
    for near_partition in [true, false] {
        for degrees in [0.0, 20.0, 60.0, 90.0, 140.0] {
            let light_travel = light_at(degrees);
            let visible = light_visible(&view, &scene);
            let options = FaceOptions {
                slices: 2,
                near_partition,
                ..FaceOptions::default()
            };
            let mut warped = 0;
            for partition in face_partitions(&view, &visible, light_travel, &options) {
                let fit = fit_light_view(&FitInput {
                    view: &view,
                    visible: &partition.receivers,
                    body: &intersection_body(&partition.receivers, &scene, light_travel),
                    light_travel,
                    warp: if partition.warped { Warp::Lispsm } else { Warp::Uniform },
                    map_size: UVec2::new(512, 256),
                    guard_texels: 0.0,
                    guard_metres: 0.0,
                    options: FitOptions {
                        axis: WarpAxis::Direction(partition.axes.y),
                        face_start: Some(partition.near_along),
                        guard: false,
                        ..FitOptions::default()
                    },
                });
                let near = fit.fitted().expect("a light view").warp_near;
                let expected = partition.warp_near(0.0);
                warped += u32::from(expected.is_finite());
                if expected.is_finite() {
                    close(near, expected, 1.0e-6);
                } else {
                    assert!(near.is_infinite(), "{near} of a face without a warp");
                }
            }
            assert!(warped > 0, "{degrees}: no face is warped");
        }
    }
}

/// Over a whole frustum the guard changes next to nothing, wherever the light is.
#[test]
fn the_guard_leaves_whole_faces_alone() {
    for degrees in (0..=180).step_by(5).map(f64::from) {
        for (slices, near_partition) in [(1, true), (4, true), (1, false)] {
            let options = FaceOptions {
                near_partition,
                ..sliced(slices)
            };
            let cut = partitions(1000.0, light_at(degrees), &options);
            let (view, partitions) = &cut;
            let guarded = partitions.iter().map(|partition| {
                let eta = partition.guarded_eta(view, 0.0);
                partition.largest_errors(view, eta).storage_factor()
            });
            let share = guarded.sum::<f64>() / storage(&cut);
            assert!((0.9..=1.02).contains(&share), "{degrees} {slices}: {share}");
        }
    }
    // Stretching does not weaken the warp.
    for ratio in [2.0, 5.62, 10.0] {
        let etas = [true, false].map(|near_partition| {
            let options = FaceOptions {
                near_partition,
                ..FaceOptions::default()
            };
            let (view, partitions) = partitions(ratio, light_at(0.0), &options);
            partitions[0].guarded_eta(&view, 0.0)
        });
        close(etas[1], etas[0], 1.0e-9);
    }
}

#[test]
fn warps_can_be_left_out() {
    let options = FaceOptions {
        warp: false,
        ..FaceOptions::default()
    };
    let unwarped = partitions(1000.0, light_at(30.0), &options);
    assert!(unwarped.1.iter().all(|partition| !partition.warped));
    let warped = partitions(1000.0, light_at(30.0), &FaceOptions::default());
    assert!(storage(&unwarped) > 20.0 * storage(&warped));
}

/// Slices share planes, the near face has none, and a slice's depths on the face are the split distances.
#[test]
fn slices_follow_the_scheme() {
    let options = FaceOptions {
        slices: 3,
        scheme: SplitScheme::Manual(vec![5.0, 20.0]),
        ..FaceOptions::default()
    };
    let (_, partitions) = partitions(100.0, light_at(90.0), &options);
    let depths: Vec<[f64; 2]> = partitions.iter().map(|partition| partition.depths).collect();
    assert_eq!(depths.len(), 3);
    for (depths, expected) in depths.iter().zip([[1.0, 5.0], [5.0, 20.0], [20.0, 100.0]]) {
        // Light from above: columns are slices of the view.
        close(depths[0], expected[0], 1.0e-6);
        close(depths[1], expected[1], 1.0e-6);
    }
    let behind = self::partitions(100.0, light_at(0.0), &options).1;
    assert_eq!(behind.len(), 13);
    let slices: Vec<usize> = behind.iter().map(|partition| partition.slice).collect();
    assert_eq!(slices, [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
}

/// The set of the picture before stays where light and view are almost perpendicular, and only there.
#[test]
fn the_face_set_has_inertia() {
    let set_of = |degrees, previous| {
        let options = FaceOptions {
            previous,
            ..FaceOptions::default()
        };
        partitions(100.0, light_at(degrees), &options).1[0].set
    };
    let (towards, away) = (FaceSet::TowardsLight, FaceSet::AwayFromLight);
    assert_eq!([set_of(89.0, None), set_of(91.0, None)], [towards, away]);
    for degrees in [89.0, 91.0] {
        assert_eq!(set_of(degrees, Some(towards)), towards);
        assert_eq!(set_of(degrees, Some(away)), away);
    }
    assert_eq!(set_of(88.0, Some(away)), towards);
    assert_eq!(set_of(92.0, Some(towards)), away);
}

/// An opening so wide that light falls along lines of sight where it is almost perpendicular to the view: the other set of
/// faces would leave gaps, so the picture before does not count.
#[test]
fn inertia_opens_no_gaps() {
    let opening = 179.0_f64.to_radians();
    let view = ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, opening, 1.0, 1.0, 100.0).unwrap();
    let visible = view.polytope(100.0);
    for degrees in [89.3_f64, 90.7] {
        let light = light_at(degrees);
        for previous in [FaceSet::TowardsLight, FaceSet::AwayFromLight] {
            let options = FaceOptions {
                previous: Some(previous),
                ..FaceOptions::default()
            };
            let partitions = face_partitions(&view, &visible, light, &options);
            let volumes = partitions.iter().map(|partition| partition.receivers.volume());
            close(volumes.sum(), visible.volume(), 1.0e-6);
        }
    }
}

#[test]
fn cameras_and_lights_without_faces() {
    let options = FaceOptions::default();
    let scene = Bounds::new(DVec3::splat(-10.0), DVec3::splat(10.0));
    let half = DVec2::splat(5.0);
    let parallel = ViewVolume::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, -half, half, 0.0, 50.0).unwrap();
    let visible = light_visible(&parallel, &scene);
    let whole = face_partitions(&parallel, &visible, light_at(40.0), &options);
    assert_eq!(faces(&whole), [FrustumFace::All]);
    assert_eq!(whole[0].receivers, visible);
    assert!(!whole[0].warped && whole[0].axes.y.dot(light_at(40.0)).abs() < 1.0e-12);

    let view = papers_camera(0.5, 100.0);
    let visible = light_visible(&view, &scene);
    for light in [DVec3::ZERO, DVec3::NAN] {
        assert_eq!(
            faces(&face_partitions(&view, &visible, light, &options)),
            [FrustumFace::All]
        );
    }
    assert!(face_partitions(&view, &Polytope::default(), light_at(40.0), &options).is_empty());
    let nowhere = light_visible(&view, &Bounds::new(DVec3::NAN, DVec3::ONE));
    assert!(face_partitions(&view, &nowhere, light_at(40.0), &options).is_empty());
    assert_eq!(partition_of_point(&[], DVec3::ZERO), None);
}
