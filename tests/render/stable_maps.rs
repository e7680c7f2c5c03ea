//! Maps that stand still while the camera moves.

use bevy::{math::DVec3, prelude::*};
use umbrage::{
    maths::stable::blend_history::{BlendedFrame, blend},
    shadow::views::SunViews,
};

use crate::{
    harness::{Harness, eye},
    truth::{Cuboid3, LIGHTS, SIZE, boxes, harness_with, settings, trace, viewing_ray},
};

/// Texels per side.
const MAP: i32 = 256;

/// The map's depths as they come from the GPU, and its matrix.
fn map_of(harness: &Harness, sun: Entity) -> (Vec<f32>, Mat4) {
    let views = harness.app.world().get::<SunViews>(sun).expect("views");
    let light_view = &views.cameras[&harness.camera].partitions[0].light_view;
    (harness.atlas().to_f32(), light_view.clip_from_world)
}

/// The place of a world-space point in a map, in texels from the top left.
fn texel(clip_from_world: &Mat4, point: Vec3) -> Vec2 {
    let ndc = clip_from_world.project_point3(point);
    (ndc.truncate() * Vec2::new(0.5, -0.5) + 0.5) * MAP as f32
}

/// One step of the camera.
#[derive(Debug)]
struct Step {
    /// Whether two points have moved by the same whole number of texels.
    is_whole: bool,
    /// How far, in texels.
    shift: Vec2,
    /// Whether the same depths lie at the same heights.
    is_same_range: bool,
    /// Shares of texels that are not those of the map before, moved by as much.
    changed: [f64; 2],
}

/// Walks and turns a little for some frames.
fn walk(technique: &str, steps: usize) -> Vec<Step> {
    let mut harness = harness_with(&boxes());
    let sun = harness.sun(LIGHTS[0], settings(technique));
    harness.start();
    let mut before = map_of(&harness, sun);
    let mut found = Vec::new();
    for _ in 0..steps {
        let mut camera = harness
            .app
            .world_mut()
            .get_mut::<Transform>(harness.camera)
            .expect("a camera");
        let ahead = camera.forward() * 0.07;
        camera.translation += ahead;
        camera.rotate_y(0.004);
        harness.frames(1);
        let after = map_of(&harness, sun);
        let shift_of = |point| texel(&after.1, point) - texel(&before.1, point);
        let (shift, elsewhere) = (shift_of(Vec3::ZERO), shift_of(Vec3::new(3.0, 0.0, 2.0)));
        let height_of = |map: &Mat4, height| map.project_point3(Vec3::new(0.0, height, 0.0)).z;
        let is_same = |height| (height_of(&before.1, height) - height_of(&after.1, height)).abs() < 1.0e-6;
        found.push(Step {
            is_same_range: is_same(0.0) && is_same(3.0),
            is_whole: shift.distance(shift.round()) < 0.01 && elsewhere.distance(shift) < 0.01,
            shift,
            changed: changed(&before.0, &after.0, shift.round().as_ivec2()),
        });
        before = after;
    }
    found
}

/// Shares of the texels of two maps that differ when the first one is moved by a number of texels: in any bit, and by more
/// than rounding of depths.
fn changed(before: &[f32], after: &[f32], shift: IVec2) -> [f64; 2] {
    let (mut compared, mut changed) = (0, [0, 0]);
    for index in 0..MAP * MAP {
        let place = IVec2::new(index % MAP, index / MAP);
        let from = place - shift;
        if from.cmpge(IVec2::ZERO).all() && from.cmplt(IVec2::splat(MAP)).all() {
            compared += 1;
            let (a, b) = (before[(from.y * MAP + from.x) as usize], after[index as usize]);
            changed[0] += i32::from(a.to_bits() != b.to_bits());
            changed[1] += i32::from((a - b).abs() > ROUNDING);
        }
    }
    assert!(compared > MAP * MAP / 2, "only {compared} texels are in both maps");
    changed.map(|changed| f64::from(changed) / f64::from(compared))
}

/// Depths that are interpolated from other corners of the same triangle differ by this: some units in the last place.
const ROUNDING: f32 = 4.0e-6;

#[test]
fn stable_maps_move_by_whole_texels() {
    for technique in [
        "uniform:size=256,stable=sphere",
        "uniform:size=256,stable=quantised",
        "lispsm:size=256,stable=held",
    ] {
        let steps = walk(technique, 12);
        let still: Vec<&Step> = steps
            .iter()
            .filter(|step| step.is_whole && step.is_same_range)
            .collect();
        println!("{technique}: {} of 12 steps are whole, {steps:?}", still.len());
        assert!(
            still.len() >= 8,
            "{technique}: only {} of 12 steps keep the grid",
            still.len()
        );
        for step in still {
            // Corners of triangles are rounded to a 256th of a texel, so a texel's middle changes sides that seldom.
            assert!(
                step.changed[1] < 1.0 / 256.0,
                "{technique}, moved by {}: {step:?}",
                step.shift
            );
        }
    }
    let fresh = walk("lispsm:size=256", 4);
    println!("off: {fresh:?}");
    for step in fresh {
        assert!(!step.is_whole && step.changed[1] > 0.01, "a fresh fit: {step:?}");
    }
}

/// What every pixel of a camera sees, from formulas; `None` for sky.
fn positions(eye: Transform, boxes: &[Cuboid3]) -> Vec<Option<DVec3>> {
    let (origin, forward) = (eye.translation.as_dvec3(), eye.forward().as_dvec3());
    (0..SIZE.x * SIZE.y)
        .map(|index| {
            let direction = viewing_ray(eye, f64::from(index % SIZE.x) + 0.5, f64::from(index / SIZE.x) + 0.5);
            // The far plane is at 120 m.
            let hit = trace(origin, direction, boxes).filter(|(t, ..)| t * direction.dot(forward) < 120.0);
            hit.map(|(t, ..)| origin + t * direction)
        })
        .collect()
}

/// A step ahead and a little turn.
fn stepped(eye: Transform) -> Transform {
    let mut next = eye;
    next.translation += eye.forward() * 0.07;
    next.rotate_y(0.004);
    next
}

/// The result of the last of some frames, in each of which the camera stands elsewhere.
fn result_along(technique: &str, eyes: &[Transform]) -> Vec<f32> {
    let mut harness = harness_with(&boxes());
    harness.sun(LIGHTS[0], settings(technique));
    harness.start();
    for eye in eyes {
        let mut camera = harness
            .app
            .world_mut()
            .get_mut::<Transform>(harness.camera)
            .expect("a camera");
        *camera = *eye;
        harness.frames(1);
    }
    harness.shadow_result(harness.camera)
}

/// While the camera stands, the blend of equal results is that result; when it moves, it is what the twin says.
#[test]
fn the_blend_with_the_frame_before_is_that_of_its_twin() {
    // Measured depths would change the maps in the second frame.
    const SHARP: &str = "zp4+lispsm:size=256,near=bounds,stable=sharp";
    const OFF: &str = "zp4+lispsm:size=256,near=bounds";
    let boxes = boxes();
    let next = stepped(eye());
    let before = result_along(SHARP, &[eye()]);
    let worst = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst(&before, &result_along(OFF, &[eye()])) < 0.005, "standing still");
    let own = result_along(OFF, &[next]);
    let blended = result_along(SHARP, &[next]);
    let seen = positions(eye(), &boxes);
    let view_from_world = eye().to_matrix().as_dmat4().inverse();
    let aspect = f64::from(SIZE.x) / f64::from(SIZE.y);
    let projection = bevy::math::DMat4::perspective_infinite_reverse_rh(std::f64::consts::FRAC_PI_4, aspect, 0.2);
    let view_depth_from_world = -view_from_world.row(2);
    let view_depths: Vec<f32> = seen
        .iter()
        .map(|point| point.map_or(0.0, |point| view_depth_from_world.dot(point.extend(1.0)) as f32))
        .collect();
    let frame = BlendedFrame {
        size: SIZE,
        clip_from_world: projection * view_from_world,
        view_depth_from_world,
        visibility: &before,
        view_depths: &view_depths,
    };
    let twin = blend(SIZE, &own, &positions(next, &boxes), &frame, 0.25);
    let different = |a: &[f32], b: &[f32], limit: f32| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > limit).count();
    let (blurred, off) = (different(&own, &blended, 0.02), different(&twin, &blended, 0.02));
    println!("{blurred} pixels are blended, {off} differ from the twin");
    assert!(blurred > 200, "only {blurred} pixels are blended");
    // Pixels through whose middle an edge of a box goes see either side of it.
    assert!(off <= 10, "{off} pixels differ from the twin");
}
