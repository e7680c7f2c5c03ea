//! Casters per partition: none is missing, and none too many.

use bevy_math::{DVec2, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    bounds::Bounds,
    cull::{CasterVolume, partition_range, receivers_in_map},
    face::{FaceOptions, face_partitions},
    fit::{FitInput, FitOptions, fit_light_view},
    polytope::{Polytope, PolytopeState},
    selection::SelectableView,
    split::{SplitScheme, split_depths},
    warp::Warp,
};

use crate::{
    partition_properties::inside,
    properties::{direction, light_for, point, seen},
    support::bodies,
};

fn unit_box() -> Polytope {
    Polytope::from_box(DVec3::splat(-1.0), DVec3::ONE)
}

fn cube_at(center: DVec3, half_side: f64) -> Bounds {
    Bounds::new(center, center).expanded(half_side)
}

/// Light from above: what is above touches however high, what is beside or below does not.
#[test]
fn casters_of_a_box() {
    let volume = CasterVolume::new(&unit_box(), DVec3::NEG_Y);
    let touches = |x, y, z| volume.touches(&cube_at(DVec3::new(x, y, z), 0.5));
    assert!(touches(0.0, 0.0, 0.0) && touches(0.0, 1.0e6, 0.0) && touches(1.4, 3.0, -1.4));
    assert!(!touches(1.6, 3.0, 0.0) && !touches(0.0, -1.6, 0.0) && !touches(0.0, 5.0, -1.6));
    assert_eq!(volume.half_spaces().len(), 5, "none towards the light");
    assert!(volume.half_spaces().iter().all(|half_space| half_space.normal.y <= 0.0));
}

/// A box beside an edge that lies askew: no face of either separates them, only a plane along one edge of each.
#[test]
fn edges_separate_what_faces_do_not() {
    let body = Polytope::hull(&[
        DVec3::ZERO,
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(1.0, 1.0, 0.01),
        DVec3::new(0.0, 0.0, 0.01),
    ]);
    let body = body.sweep(DVec3::new(0.0, 0.0, 1.0), 0.5);
    let light = DVec3::new(1.0, -1.0, 0.3);
    let volume = CasterVolume::new(&body, light);
    let mut by_faces_only = 0;
    for step in 0..30 * 30 * 30 {
        let place = [1, 30, 900].map(|stride| f64::from(step / stride % 30) / 29.0 * 4.0 - 2.0);
        let caster = cube_at(DVec3::from_array(place), 0.3);
        let is_near = volume.half_spaces().iter().all(|half_space| {
            let reach = half_space.normal.abs().element_sum() * 0.3;
            half_space.excess(caster.center()) <= reach
        });
        by_faces_only += usize::from(is_near && !volume.touches(&caster));
    }
    assert!(by_faces_only > 0);
}

#[test]
fn volumes_without_answer() {
    let caster = cube_at(DVec3::ZERO, 1.0);
    assert!(!CasterVolume::new(&Polytope::default(), DVec3::NEG_Y).touches(&caster));
    assert!(CasterVolume::new(&unit_box(), DVec3::ZERO).touches(&caster));
    assert!(CasterVolume::new(&unit_box(), DVec3::NAN).touches(&caster));
    let volume = CasterVolume::new(&unit_box(), DVec3::NEG_Y);
    assert!(!volume.touches(&Bounds::EMPTY) && !volume.touches(&Bounds::new(DVec3::NAN, DVec3::ONE)));
    // Casters without bounds are always drawn.
    assert!(volume.touches(&Bounds::new(DVec3::NEG_INFINITY, DVec3::INFINITY)));
    let ground = Polytope::from_box(DVec3::new(-5.0, 0.0, -5.0), DVec3::new(5.0, 0.0, 5.0));
    let volume = CasterVolume::new(&ground, DVec3::new(0.5, -1.0, 0.0));
    assert!(volume.touches(&cube_at(DVec3::new(-7.0, 5.0, 0.0), 0.1)));
    assert!(!volume.touches(&cube_at(DVec3::new(7.0, 5.0, 0.0), 0.1)));
}

#[test]
fn a_caster_is_drawn_from_its_first_to_its_last_partition() {
    let volumes: Vec<CasterVolume> = [0.0, 10.0, 20.0, 30.0]
        .map(|x| Polytope::from_box(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 10.0, 1.0, 1.0)))
        .iter()
        .map(|body| CasterVolume::new(body, DVec3::NEG_Y))
        .collect();
    let range = |min: f64, max: f64| {
        let caster = Bounds::new(DVec3::new(min, 2.0, 0.0), DVec3::new(max, 3.0, 1.0));
        partition_range(&volumes, &caster)
    };
    assert_eq!(range(12.0, 13.0), Some((1, 1)));
    assert_eq!(range(5.0, 25.0), Some((0, 2)));
    assert_eq!(range(-5.0, 95.0), Some((0, 3)));
    assert_eq!(range(41.0, 45.0), None);
    assert_eq!(partition_range(&[], &Bounds::new(DVec3::ZERO, DVec3::ONE)), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A caster whose shadow falls on a visible point is in the volume of that point's partition, for slices and faces.
    #[test]
    fn no_caster_is_missing(
        (scene, view) in seen(), direction in direction(), along in 0_u8..8, by_faces in any::<bool>(),
        shares in prop::collection::vec(0.0..1.0, 7), distance in 0.0..500.0, offset in point(1.0), half_side in 0.0..3.0,
    ) {
        let light_travel = light_for(&view, direction, along);
        let (visible, _) = bodies(&view, &scene, light_travel);
        prop_assume!(!visible.is_empty());
        let receivers: Vec<Polytope> = if by_faces {
            let partitions = face_partitions(&view, &visible, light_travel, &FaceOptions::default());
            partitions.into_iter().map(|partition| partition.receivers).collect()
        } else {
            let depths = split_depths(&SplitScheme::Logarithmic, view.near(), view.far(), 4);
            depths.windows(2).map(|range| bodies(&view.split(range[0], range[1]), &scene, light_travel).0).collect()
        };
        let volumes: Vec<CasterVolume> = receivers.iter().map(|body| CasterVolume::new(body, light_travel)).collect();
        let mut last = None;
        for (index, (body, volume)) in receivers.iter().zip(&volumes).enumerate() {
            prop_assert_eq!(body.is_empty(), !volume.touches(&cube_at(body.center(), 1.0)));
            if body.is_empty() { continue; }
            let occluder = inside(body, &shares) - light_travel.normalize() * distance;
            let caster = cube_at(occluder + offset * half_side, half_side);
            prop_assert!(volume.touches(&caster), "{caster:?} shades partition {index}");
            prop_assert!(volume.half_spaces().iter().all(|half_space| half_space.excess(occluder) <= 1.0e-5));
            let range = partition_range(&volumes, &caster);
            prop_assert!(range.is_some_and(|(first, last)| first <= index && index <= last));
            last = Some(index);
        }
        prop_assert!(last.is_some());
    }

    /// No caster too many: one that touches has a shadow that meets the receivers, by cutting both.
    #[test]
    fn casters_that_touch_shade(points in prop::collection::vec(point(10.0), 4..9), light in direction(), center in point(20.0), size in [0.1..8.0, 0.1..8.0, 0.1..8.0]) {
        let receivers = Polytope::hull(&points);
        prop_assume!(receivers.state() == PolytopeState::Solid);
        let caster = Bounds::new(center, center + DVec3::from_array(size));
        let shadow = Polytope::from_box(caster.min, caster.max).sweep(light, 100.0);
        let meet = |margin: f64| {
            shadow.faces().fold(receivers.clone(), |body, face| {
                let mut half_space = face.half_space;
                half_space.distance += margin;
                body.clip(&half_space)
            }).is_empty()
        };
        let touches = CasterVolume::new(&receivers, light).touches(&caster);
        // Only those that just touch may be either.
        prop_assert!(touches || meet(-1.0e-6), "{caster:?} shades");
        prop_assert!(!touches || !meet(1.0e-6), "{caster:?} shades nothing");
    }

    /// With selection by best resolution a map needs the casters of all that is visible in it.
    #[test]
    fn receivers_of_a_map((scene, view) in seen(), direction in direction(), along in 0_u8..8, warped in any::<bool>(), shares in prop::collection::vec(0.0..1.0, 7)) {
        let light_travel = light_for(&view, direction, along);
        let (visible, _) = bodies(&view, &scene, light_travel);
        prop_assume!(visible.state() == PolytopeState::Solid);
        let depths = split_depths(&SplitScheme::Logarithmic, view.near(), view.far(), 3);
        let slice = view.split(depths[1], depths[2]);
        let (of_slice, body) = bodies(&slice, &scene, light_travel);
        let warp = if warped { Warp::Lispsm } else { Warp::Uniform };
        let fit = fit_light_view(&FitInput { view: &slice, visible: &of_slice, body: &body, light_travel, warp, map_size: UVec2::splat(512), guard_texels: 2.0, guard_metres: 0.0, options: FitOptions::default() }).fitted();
        let Some(fit) = fit else { return Ok(()) };
        let in_map = receivers_in_map(&visible, &fit.clip_from_world);
        let tolerance = 1.0e-5;
        for vertex in of_slice.vertices() {
            prop_assert!(in_map.contains(*vertex, tolerance), "{vertex} of the slice is not in the map");
        }
        let map = SelectableView { clip_from_world: fit.clip_from_world, end_depth: depths[2], margin: DVec2::ZERO, size: UVec2::splat(512), seam_depth: 0.0, stands_in: false };
        let point = inside(&visible, &shares);
        if map.contains(point) {
            prop_assert!(in_map.contains(point, tolerance), "{point}");
        } else {
            prop_assert!(!in_map.contains(point, -tolerance), "{point}");
        }
    }
}
