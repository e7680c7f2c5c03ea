//! Properties of partitions that hold for random cameras, scenes and lights.

use bevy_math::DVec3;
use proptest::prelude::*;
use umbrage::maths::{
    bounds::Bounds,
    face::{FaceOptions, FacePartition, FaceSet, FrustumFace, face_partitions, partition_of_point},
    polytope::{Polytope, PolytopeState},
    split::SplitScheme,
    view::ViewVolume,
};

use crate::{
    properties::{direction, light_for, seen},
    support::bodies,
};

fn face_options() -> impl Strategy<Value = FaceOptions> {
    let previous = prop_oneof![
        Just(None),
        Just(Some(FaceSet::TowardsLight)),
        Just(Some(FaceSet::AwayFromLight))
    ];
    (1_usize..5, any::<bool>(), any::<bool>(), previous).prop_map(|(slices, near_partition, warp, previous)| {
        FaceOptions {
            slices,
            scheme: SplitScheme::Logarithmic,
            near_partition,
            warp,
            previous,
        }
    })
}

/// Directions that make trouble besides those of `light_for`: along a side, along a corner line, perpendicular to the
/// view; exactly or almost.
fn awkward_light(view: &ViewVolume, direction: DVec3, kind: u8, share: f64) -> DVec3 {
    let corners = view.corners(1.0, 2.0);
    let line = |index: usize| corners[index + 4] - corners[index];
    let offset = direction * if kind.is_multiple_of(2) { 0.0 } else { 1.0e-7 };
    offset
        + match kind / 2 {
            0 => line(0),
            1 => -line(2),
            2 => line(1) * share + line(2) * (1.0 - share),
            3 => line(3) * share - line(0) * (1.0 - share),
            4 => corners[1] - corners[0],
            5 => view.forward().cross(direction),
            _ => return light_for(view, direction, kind),
        }
}

/// A point of a body from shares of its vertices.
pub(crate) fn inside(body: &Polytope, shares: &[f64]) -> DVec3 {
    let vertices = body.vertices();
    let weight = |index: usize| shares[index % shares.len()].powi(3) + 1.0e-6;
    let sum: f64 = (0..vertices.len()).map(weight).sum();
    vertices
        .iter()
        .enumerate()
        .map(|(index, vertex)| *vertex * (weight(index) / sum))
        .sum()
}

fn size(partition: &FacePartition, light: DVec3) -> f64 {
    let (right, up) = light.any_orthonormal_pair();
    let outline = partition.receivers.vertices().iter();
    let bounds = Bounds::from_points(outline.map(|vertex| DVec3::new(vertex.dot(right), vertex.dot(up), 0.0)));
    bounds.size().truncate().min_element()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// No gap: every visible point lies in a partition's receivers, the one that selection finds.
    #[test]
    fn face_partitions_hold_every_visible_point(
        (scene, view) in seen(), direction in direction(), kind in 0_u8..24, share in 0.0..1.0,
        options in face_options(), shares in prop::collection::vec(prop::collection::vec(0.0..1.0, 7), 12),
    ) {
        let light = awkward_light(&view, direction, kind, share);
        let (visible, _) = bodies(&view, &scene, light);
        prop_assume!(!visible.is_empty());
        let partitions = face_partitions(&view, &visible, light, &options);
        prop_assert!(!partitions.is_empty());
        let scale = visible.vertices().iter().map(|vertex| vertex.abs().max_element()).fold(1.0, f64::max);
        for point in shares.iter().map(|shares| inside(&visible, shares)).chain(visible.vertices().iter().copied()) {
            let holder = partitions.iter().find(|partition| partition.receivers.contains(point, 1.0e-6 * scale));
            prop_assert!(holder.is_some(), "{point} is in none of {:?}", partitions.iter().map(|p| (p.face, p.slice)).collect::<Vec<_>>());
            let selected = &partitions[partition_of_point(&partitions, point).unwrap()];
            prop_assert!(selected.receivers.contains(point, 1.0e-6 * scale), "selection finds a partition without {point}");
        }
        // None twice: volumes add up.
        if visible.state() == PolytopeState::Solid {
            let sum: f64 = partitions.iter().map(|partition| partition.receivers.volume()).sum();
            let surface = visible.bounds().size().max_element().powi(2);
            prop_assert!((sum - visible.volume()).abs() <= 1.0e-5 * visible.volume() + 1.0e-5 * surface, "{sum} against {}", visible.volume());
        }
        let towards_light = -light.normalize();
        for partition in &partitions {
            prop_assert!((partition.axes.y.length() - 1.0).abs() < 1.0e-9 && partition.axes.y.dot(towards_light).abs() < 1.0e-9);
            prop_assert!(partition.start_along <= partition.near_along + 1.0e-9 && partition.near_along <= partition.far_along + 1.0e-9);
            prop_assert!(partition.warp_near(0.0) > 0.0);
            let errors = partition.largest_errors(&view, 0.0);
            prop_assert!(errors.across.is_finite() && errors.along.is_finite());
        }
    }

    /// Lloyd's popping rule: partitions come and go with the light only where they are thin, and stay what they are
    /// otherwise.
    #[test]
    fn partitions_come_and_go_thin((scene, view) in seen(), light in direction(), turn in direction(), slices in 1_usize..4, near_partition in any::<bool>()) {
        let (visible, _) = bodies(&view, &scene, light);
        if view.is_orthographic() || visible.state() != PolytopeState::Solid {
            return Ok(());
        }
        let options = FaceOptions { slices, near_partition, ..FaceOptions::default() };
        let step = 1.0e-4;
        let lights = [light, (light + turn * step).normalize()];
        let [before, after] = lights.map(|light| face_partitions(&view, &visible, light, &options));
        prop_assume!(before[0].set == after[0].set);
        let thin = 20.0 * step * visible.bounds().size().length();
        for (one, other) in [(&before, &after), (&after, &before)] {
            for partition in one {
                let key = |partition: &FacePartition| (partition.face, partition.slice);
                if !other.iter().any(|candidate| key(candidate) == key(partition)) {
                    let size = size(partition, light);
                    prop_assert!(size <= thin, "{:?} pops with {size} m of {thin} m", key(partition));
                }
            }
        }
    }

    /// With all of a camera's frustum visible, the number of partitions is one of few, and both sets have as many sides
    /// where they meet.
    #[test]
    fn both_face_sets_have_as_many_sides_where_they_meet(direction in direction(), fov in 0.3..2.0, aspect in 0.5..2.5) {
        let view = ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov, aspect, 1.0, 100.0).unwrap();
        let visible = view.polytope(100.0);
        let across = view.forward().cross(direction).normalize();
        prop_assume!(across.x.abs().min(across.y.abs()) > 1.0e-3);
        let sides = |tilt: f64| {
            let partitions = face_partitions(&view, &visible, across + view.forward() * tilt, &FaceOptions::default());
            partitions.iter().filter(|partition| partition.face != FrustumFace::Near).count()
        };
        prop_assert_eq!((sides(1.0e-5), sides(-1.0e-5)), (2, 2));
    }

    /// A guarded warp is hardly worse than none by the measure of storage, where the scene leaves the face too.
    #[test]
    fn guarded_faces_are_no_worse_than_unwarped(
        (scene, view) in seen(), direction in direction(), kind in 0_u8..24, share in 0.0..1.0, slices in 1_usize..4, near_partition in any::<bool>(),
    ) {
        let light = awkward_light(&view, direction, kind, share);
        let (visible, _) = bodies(&view, &scene, light);
        if visible.state() != PolytopeState::Solid {
            return Ok(());
        }
        let options = FaceOptions { slices, near_partition, ..FaceOptions::default() };
        for partition in face_partitions(&view, &visible, light, &options) {
            let storage = |eta| partition.largest_errors(&view, eta).storage_factor();
            let (guarded, unwarped) = (storage(partition.guarded_eta(&view, 0.0)), storage(-1.0));
            // A stretched side is judged with a slightly weaker warp than it gets.
            let allowed = if partition.start_along < partition.near_along { 1.3 } else { 1.021 };
            prop_assert!(guarded <= unwarped * allowed, "{:?} {}: {guarded} against {unwarped}", partition.face, partition.slice);
        }
    }
}
