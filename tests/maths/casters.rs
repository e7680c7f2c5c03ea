//! What may be left out of a map: casters outside of B (Scherzer 2005, section 4.4).

use bevy_math::DVec3;
use umbrage::maths::{
    body::{intersection_body, light_visible},
    bounds::Bounds,
    polytope::{HalfSpace, Polytope},
    view::ViewVolume,
};

/// Numbers in 0..1, the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn place(&mut self, bounds: &Bounds) -> DVec3 {
        bounds.min + bounds.size() * DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// Whether a ray from a point meets a box.
fn is_met(caster: &Bounds, point: DVec3, direction: DVec3) -> bool {
    let [to_min, to_max] = [caster.min, caster.max].map(|corner| (corner - point) / direction);
    let (enter, leave) = (to_min.min(to_max).max_element(), to_min.max(to_max).min_element());
    enter <= leave && leave > 0.0
}

/// Whether a box and a body have a point in common.
fn touches(body: &Polytope, caster: &Bounds) -> bool {
    let walls = Polytope::from_box(caster.min, caster.max);
    let walls: Vec<HalfSpace> = walls.faces().map(|face| face.half_space).collect();
    let common = walls.iter().fold(body.clone(), |common, wall| common.clip(wall));
    !common.is_empty()
}

/// Scherzer, oracle 12: a caster that does not touch B shades nothing that is visible, by rays from every visible point
/// tried. And B is not too large for that to say anything: casters in it do shade.
#[test]
fn casters_outside_the_body_shade_nothing_visible() {
    let scene = Bounds::new(DVec3::new(-40.0, 0.0, -40.0), DVec3::new(40.0, 20.0, 40.0));
    let mut numbers = Numbers(12);
    let (mut outside, mut shading) = (0, 0);
    for _ in 0..40 {
        let eye = numbers.place(&scene);
        let target = numbers.place(&scene);
        let view = ViewVolume::perspective(eye, target - eye, DVec3::Y, 0.9, 1.4, 0.1, 60.0).expect("a camera");
        let light_travel = DVec3::new(numbers.unit() - 0.5, -0.1 - numbers.unit(), numbers.unit() - 0.5);
        let visible = light_visible(&view, &scene);
        let body = intersection_body(&visible, &scene, light_travel);
        let corners = visible.vertices();
        let receivers: Vec<DVec3> = (0..60)
            .map(|_| {
                let weights: Vec<f64> = corners.iter().map(|_| numbers.unit().powi(3)).collect();
                let sum: DVec3 = corners
                    .iter()
                    .zip(&weights)
                    .map(|(corner, weight)| corner * *weight)
                    .sum();
                sum / weights.iter().sum::<f64>()
            })
            .collect();
        for _ in 0..40 {
            let low = numbers.place(&scene);
            let high = (low + DVec3::splat(1.0 + 5.0 * numbers.unit())).min(scene.max);
            let caster = Bounds::new(low, high);
            let shades = receivers
                .iter()
                .any(|receiver| is_met(&caster, *receiver, -light_travel));
            if touches(&body, &caster) {
                shading += usize::from(shades);
            } else {
                outside += 1;
                assert!(!shades, "{caster:?} shades what {view:?} sees");
            }
        }
    }
    assert!(outside > 300 && shading > 40, "{outside} outside, {shading} shading");
}

/// Scherzer, section 4.4 and oracle 12: the farthest visible depth must not cut B. With light from ahead a tree behind
/// it, which nobody sees, shades the ground in front; the body without what is farther has lost it.
#[test]
fn visible_depths_must_not_cut_the_body() {
    let scene = Bounds::new(DVec3::new(-50.0, 0.0, -100.0), DVec3::new(50.0, 30.0, 0.0));
    let eye = DVec3::new(0.0, 2.0, 0.0);
    let view = ViewVolume::perspective(eye, DVec3::NEG_Z, DVec3::Y, 1.0, 1.4, 0.1, 100.0).expect("a camera");
    let light_travel = DVec3::new(0.0, -1.0, 2.0);
    let visible_far = 30.0;
    let receiver = DVec3::new(0.0, 0.0, -20.0);
    let tree = Bounds::new(DVec3::new(-2.0, 5.0, -44.0), DVec3::new(2.0, 20.0, -40.0));
    assert!(is_met(&tree, receiver, -light_travel), "it shades visible ground");

    let body = intersection_body(&light_visible(&view, &scene), &scene, light_travel);
    assert!(touches(&body, &tree));
    let cut = body
        .clone()
        .clip(&HalfSpace::through(eye + DVec3::NEG_Z * visible_far, DVec3::NEG_Z));
    assert!(!touches(&cut, &tree));

    // Receivers may be cut there, if the depths are those of this very picture: B of what is left has the tree still.
    let receivers = light_visible(&view.split(0.1, visible_far), &scene);
    let shrunk = intersection_body(&receivers, &scene, light_travel);
    assert!(
        touches(&shrunk, &tree),
        "B of the visible receivers has what shades them"
    );
    assert!(shrunk.volume() < 0.8 * body.volume(), "and is smaller");
    for vertex in shrunk.vertices() {
        assert!(body.contains(*vertex, 1.0e-6), "{vertex}");
    }
}
