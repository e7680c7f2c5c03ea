//! The blur of the shadow result against its CPU twin.

use bevy::prelude::*;
use umbrage::maths::filter::eye_blur::{EyeBlur, EyePicture, EyePixel};

use crate::{
    harness::eye,
    truth::{LIGHTS, SIZE, boxes, harness_with, settings, trace, viewing_ray},
};

fn shadow_result(technique: &str) -> Vec<f32> {
    let boxes = boxes();
    let mut harness = harness_with(&boxes);
    harness.sun(LIGHTS[0], settings(technique));
    harness.start();
    harness.shadow_result(harness.camera)
}

/// What the camera sees, from formulas.
fn pixels() -> Vec<EyePixel> {
    let boxes = boxes();
    let (origin, forward) = (eye().translation.as_dvec3(), eye().forward().as_dvec3());
    (0..SIZE.x * SIZE.y)
        .map(|index| {
            let direction = viewing_ray(eye(), f64::from(index % SIZE.x) + 0.5, f64::from(index / SIZE.x) + 0.5);
            // The far plane is at 120 m.
            let hit = trace(origin, direction, &boxes).filter(|(t, ..)| *t * direction.dot(forward) < 120.0);
            hit.map_or(
                EyePixel {
                    position: Vec3::ZERO,
                    normal: Vec3::Y,
                    view_depth: 0.0,
                },
                |(t, normal, _)| EyePixel {
                    position: (origin + direction * t).as_vec3(),
                    normal: normal.as_vec3(),
                    view_depth: (t * direction.dot(forward)) as f32,
                },
            )
        })
        .collect()
}

#[test]
fn the_blur_is_that_of_its_twin() {
    let sharp = shadow_result("zp4+lispsm:size=512");
    for (iterations, full_depth) in [(1, 10.0), (5, 12.0), (16, 1.0e6)] {
        let blurred = shadow_result(&format!(
            "zp4+lispsm:size=512,blur={iterations},blur_depth={full_depth}"
        ));
        let twin = EyePicture {
            width: SIZE.x as usize,
            pixels: pixels(),
            visibility: sharp.clone(),
        }
        .blurred(&EyeBlur { iterations, full_depth });
        let changed = sharp
            .iter()
            .zip(&blurred)
            .filter(|(a, b)| (*a - *b).abs() > 0.05)
            .count();
        assert!(changed > 300, "{iterations} iterations change only {changed} pixels");
        let different: Vec<usize> = (0..blurred.len())
            .filter(|index| (blurred[*index] - twin.visibility[*index]).abs() > 1.0 / 255.0)
            .collect();
        println!(
            "{iterations} iterations to {full_depth} m: {} pixels differ",
            different.len()
        );
        assert!(
            different.is_empty(),
            "{iterations}: {} pixels differ from the twin by more than 1 of 255, first {:?}",
            different.len(),
            different.first().map(|index| (
                index % SIZE.x as usize,
                index / SIZE.x as usize,
                blurred[*index],
                twin.visibility[*index]
            ))
        );
    }
}
