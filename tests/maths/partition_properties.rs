//! Properties of partitions that hold for random cameras, scenes and lights.

use bevy_math::{DVec2, DVec3};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use umbrage::maths::{
    body::adjusted_depths,
    bounds::Bounds,
    face::{FaceOptions, FacePartition, FaceSet, FrustumFace, face_partitions, partition_of_point},
    polytope::{Polytope, PolytopeState, RELATIVE_TOLERANCE},
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

/// The smallest width of a partition seen along the light, in metres: over all directions, since a sliver may lie askew to
/// any box. A convex outline is narrowest across one of its edges, and its edges are among the pairs of vertices.
fn width(partition: &FacePartition, light: DVec3) -> f64 {
    let (right, up) = light.any_orthonormal_pair();
    let vertices = partition.receivers.vertices().iter();
    let outline: Vec<DVec2> = vertices
        .map(|vertex| DVec2::new(vertex.dot(right), vertex.dot(up)))
        .collect();
    let across = |[a, b]: [DVec2; 2]| {
        let normal = (b - a).perp().try_normalize()?;
        let along = || outline.iter().map(|point| point.dot(normal));
        Some(along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min))
    };
    let pairs = outline.iter().flat_map(|a| outline.iter().map(|b| [*a, *b]));
    // Vertices that all coincide have no width.
    pairs.filter_map(across).reduce(f64::min).unwrap_or(0.0)
}

/// A light that turns.
#[derive(Clone, Debug)]
struct Turn {
    view: ViewVolume,
    visible: Polytope,
    lights: [DVec3; 2],
    options: FaceOptions,
}

impl Turn {
    fn partitions(&self) -> [Vec<FacePartition>; 2] {
        self.lights
            .map(|light| face_partitions(&self.view, &self.visible, light, &self.options))
    }

    /// Those that one light has and the other has not, with their widths.
    fn popping(&self) -> Vec<(FrustumFace, usize, f64)> {
        let key = |partition: &FacePartition| (partition.face, partition.slice);
        let partitions = self.partitions();
        let popping = |index: usize| {
            let other: Vec<_> = partitions[1 - index].iter().map(key).collect();
            let gone = partitions[index].iter().filter(move |one| !other.contains(&key(one)));
            gone.map(move |one| (one.face, one.slice, width(one, self.lights[index])))
        };
        (0..2).flat_map(popping).collect()
    }

    /// Halved a number of times, keeping a half in which partitions come or go; any half if none do.
    fn halved(mut self, times: u32) -> Self {
        for _ in 0..times {
            let [start, end] = self.lights;
            let middle = (start + end).normalize();
            self.lights = [start, middle];
            if self.popping().is_empty() {
                self.lights = [middle, end];
            }
        }
        self
    }

    /// How wide a partition can be that one light has and the other has not.
    ///
    /// Seen along the light from the eye, no point farther than `reach` moves by more than δ = reach × the turn. Each ray
    /// of a column meets its face no deeper than the receiver that it comes from: the set is chosen so. Hence a partition
    /// is the outline of H cut with that of its face up to H's far end, two convex outlines of points within `reach`.
    /// - If they meet under one light only, a line separates them under the other; under the first both reach across it by
    ///   no more than δ, so that they meet in a strip of 2 δ.
    /// - If the face itself comes or goes, it turns edge-on in between. There its outline lies on a line, so that under
    ///   either light it lies in such a strip. It counts as edge-on for a millionth longer.
    ///
    /// The strip lies across the light in any direction, and its length has no limit.
    fn widest(&self) -> f64 {
        let (near, far) = adjusted_depths(&self.visible, &self.view).expect("a body");
        let corners = self.view.corners(near, far);
        let reach = corners.map(|corner| corner.distance(self.view.eye()));
        let turn = self.lights[0].distance(self.lights[1]) + 1.0e-6;
        let vertices = self.visible.vertices().iter();
        let scale = vertices.map(|vertex| vertex.abs().max_element()).fold(1.0, f64::max);
        2.0 * turn * reach.into_iter().fold(0.0, f64::max) + 4.0 * RELATIVE_TOLERANCE * scale
    }
}

/// Turns between two random lights that choose the same set, narrowed to where partitions come or go.
fn turns() -> impl Strategy<Value = Turn> {
    (seen(), [direction(), direction()], 5_u32..20, 1_usize..4, any::<bool>()).prop_filter_map(
        "no body",
        |((scene, view), [start, end], halvings, slices, near_partition)| {
            let (visible, _) = bodies(&view, &scene, start);
            let options = FaceOptions {
                slices,
                near_partition,
                ..FaceOptions::default()
            };
            let same_set = (start.dot(view.forward()) > 0.0) == (end.dot(view.forward()) > 0.0);
            let turn = Turn {
                view,
                visible,
                lights: [start, if same_set { end } else { -end }],
                options,
            };
            let is_cut = !turn.view.is_orthographic() && turn.visible.state() == PolytopeState::Solid;
            is_cut.then(|| turn.halved(halvings))
        },
    )
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

    /// Lloyd's popping rule: while the light turns, partitions of one set come and go only where they are thin.
    #[test]
    fn partitions_come_and_go_thin(turn in turns()) {
        let thin = turn.widest();
        for (face, slice, width) in turn.popping() {
            prop_assert!(width <= thin, "{face:?} {slice} pops with {width} m of {thin} m");
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

/// The turns above do make partitions come and go.
#[test]
fn turns_make_partitions_pop() {
    let mut runner = TestRunner::deterministic();
    let popping = (0..400)
        .map(|_| turns().new_tree(&mut runner).expect("a turn").current())
        .filter(|turn| !turn.popping().is_empty())
        .count();
    assert!(popping > 200, "{popping} of 400");
}

/// A right side that comes as a sliver of metres by millimetres, askew to the axes: thin, though its box is not.
#[test]
fn sliver_that_comes_askew_is_thin() {
    let scene = Bounds::new(
        DVec3::new(42.877, -12.022, -35.871),
        DVec3::new(155.384, -10.228, 80.651),
    );
    let eye = DVec3::new(37.942, 46.454, 30.926);
    let slopes = [
        DVec3::new(0.011_252, -0.850_890, -1.393_923),
        DVec3::new(1.211_614, -0.850_890, 0.689_303),
        DVec3::new(1.557_989, 0.002_419, 0.489_720),
        DVec3::new(0.357_626, 0.002_419, -1.593_505),
    ];
    let forward = DVec3::new(0.784_620, -0.424_235, -0.452_101);
    let corners = [1.0, 2.0].map(|depth| slopes.map(|slope| eye + slope * depth));
    let view = ViewVolume::from_corners(eye, forward, DVec3::Y, corners, 0.05, 1516.42).unwrap();
    let light = DVec3::new(-0.643_590, 0.632_232, -0.431_363);
    let turn = Turn {
        visible: bodies(&view, &scene, light).0,
        view,
        lights: [light, light + DVec3::Z * 1.0e-4].map(DVec3::normalize),
        options: FaceOptions {
            near_partition: false,
            ..FaceOptions::default()
        },
    };
    let popping = turn.popping();
    assert!(
        matches!(popping[..], [(FrustumFace::Right, 0, width)] if width > 0.0 && width < turn.widest()),
        "{popping:?} of {} m",
        turn.widest()
    );
}
