//! Face partitions, balanced maps and seams, drawn.

use bevy::{math::DVec2, prelude::*};
use umbrage::{
    maths::selection::{BorderBand, SelectableView, Selection, view_weights},
    shadow::views::{CameraSunViews, SunViews},
};

use crate::{
    harness::{Harness, eye},
    truth::{LIGHTS, SIZE, boxes, errors, harness_with, settings, trace, viewing_ray},
};

/// The camera of these tests looks along it, so that light and view are nearly parallel.
const ALONG_THE_VIEW: Vec3 = Vec3::new(0.12, -0.2, -1.0);

fn total(light: Vec3, technique: &str) -> f64 {
    let (false_shadow, false_lit) = errors(light, technique);
    false_shadow + false_lit
}

/// Lloyd, section 5.3: for light along the view, S̄ of one map is α² with or without a warp, of faces 2 (α − 1) + 1; here α is
/// over 30. At equal texels (768² in all) faces must be better.
#[test]
fn faces_beat_one_map_where_light_and_view_are_parallel() {
    let one = total(ALONG_THE_VIEW, "lispsm:size=768,filter=hard");
    let faces = total(ALONG_THE_VIEW, "fp+lispsm:size=256,filter=hard");
    assert!(faces < one, "{faces} against {one}");
}

/// Faces and balanced maps are drawn where they are read, in every light: a map that is missing or read in another one's
/// place would make tens of percent of the pixels wrong; texels of their size are worth less than one.
#[test]
fn faces_and_balanced_maps_are_nearly_exact() {
    let faces = "fp2+lispsm:size=341";
    let cases = [
        (LIGHTS[0], faces),
        (LIGHTS[1], faces),
        (ALONG_THE_VIEW, faces),
        (LIGHTS[0], "fp2+lispsm:size=341,resolution=equal"),
        (LIGHTS[1], "zp4+lispsm:size=256,resolution=balanced"),
        (LIGHTS[2], "zp4+lispsm:size=256,resolution=balanced"),
    ];
    for (light, technique) in cases {
        let wrong = total(light, technique);
        assert!(
            wrong < 0.01,
            "{technique}, light {light}: {wrong} of the pixels are wrong"
        );
    }
}

struct Drawn {
    result: Vec<f32>,
    views: CameraSunViews,
}

fn draw(technique: &str) -> Drawn {
    let mut harness: Harness = harness_with(&boxes());
    let sun = harness.sun(LIGHTS[0], settings(technique));
    harness.start();
    let views = harness.app.world().get::<SunViews>(sun).expect("the sun has views");
    Drawn {
        result: harness.shadow_result(harness.camera),
        views: views.cameras[&harness.camera].clone(),
    }
}

/// The weights of the maps at every pixel that sees a surface.
fn weights(views: &CameraSunViews, selection: Selection, band: BorderBand) -> Vec<Option<Vec<f64>>> {
    let selectable: Vec<SelectableView> = (views.partitions.iter())
        .map(|partition| {
            let rect = partition.light_view.atlas_rect;
            let size = UVec2::new(rect.z, rect.w);
            SelectableView {
                clip_from_world: partition.light_view.clip_from_world.as_dmat4(),
                end_depth: f64::from(partition.light_view.far_depth),
                margin: DVec2::ONE / size.as_dvec2(),
                size,
                seam_depth: f64::from(partition.light_view.seam_depth),
                stands_in: partition.light_view.stands_in,
            }
        })
        .collect();
    let (origin, forward) = (eye().translation.as_dvec3(), eye().forward().as_dvec3());
    let boxes = boxes();
    (0..SIZE.x * SIZE.y)
        .map(|index| {
            // Every third pixel will do.
            if index % 3 != 0 {
                return None;
            }
            let (x, y) = (f64::from(index % SIZE.x) + 0.5, f64::from(index / SIZE.x) + 0.5);
            let direction = viewing_ray(eye(), x, y);
            let (t, ..) = trace(origin, direction, &boxes)?;
            let point = origin + t * direction;
            let depth = (point - origin).dot(forward);
            let distance = f64::from(views.far_depth);
            Some(view_weights(&selectable, selection, band, point, depth, distance))
        })
        .collect()
}

/// Seams change the pixels in them and no others, and what they change lies between lit and shadow.
#[test]
fn seams_change_only_their_pixels() {
    for (select, selection) in [("best", Selection::BestResolution), ("finest", Selection::Finest)] {
        let technique = format!("zp4+lispsm:size=128,select={select}");
        let plain = draw(&technique);
        for (seam, band) in [("0.2", BorderBand::Share(0.2)), ("1m", BorderBand::Metres(1.0))] {
            seams_change_only_theirs(&plain, &format!("{technique},seam={seam}"), selection, band);
        }
    }
}

fn seams_change_only_theirs(plain: &Drawn, technique: &str, selection: Selection, band: BorderBand) {
    let blended = draw(technique);
    assert_eq!(blended.views.layout, plain.views.layout, "the same maps");
    let weights = weights(&blended.views, selection, band);
    let (mut in_seams, mut changed) = (0, 0);
    for (index, weights) in weights.iter().enumerate() {
        let (seamless, seamed) = (plain.result[index], blended.result[index]);
        let Some(weights) = weights else {
            continue;
        };
        let largest = weights.iter().copied().fold(0.0, f64::max);
        if largest == 1.0 {
            // Positions that the GPU reconstructs differ by a millionth: beside the seam its weight is that small.
            assert!(
                (seamless - seamed).abs() < 0.002,
                "{technique}: pixel {index}: {seamless} and {seamed}"
            );
        } else if largest > 0.0 {
            in_seams += 1;
            changed += u32::from(seamless != seamed);
        }
    }
    println!("{technique}: {in_seams} pixels in seams, {changed} changed");
    assert!(in_seams > 300, "{technique}: only {in_seams} pixels are in seams");
    assert!(changed > 6, "{technique}: only {changed} pixels changed");
}

/// Shadows fade to lit at the end of the range: full up to the fade, none behind it.
#[test]
fn shadows_fade_out_at_the_end() {
    let plain = draw("zp4+lispsm:size=256,distance=30");
    let faded = draw("zp4+lispsm:size=256,distance=30,fade=0.5");
    let (origin, forward) = (eye().translation.as_dvec3(), eye().forward().as_dvec3());
    let boxes = boxes();
    let (mut full, mut partial) = (0, 0);
    for (index, (plain, faded)) in plain.result.iter().zip(&faded.result).enumerate() {
        let index = index as u32;
        let (x, y) = (f64::from(index % SIZE.x) + 0.5, f64::from(index / SIZE.x) + 0.5);
        let direction = viewing_ray(eye(), x, y);
        let Some((t, ..)) = trace(origin, direction, &boxes) else {
            continue;
        };
        let depth = t * direction.dot(forward);
        assert!(faded >= plain, "pixel {index}: fading only brightens");
        if depth < 14.99 {
            assert_eq!(plain, faded, "pixel {index} at {depth} m");
            full += u32::from(*plain < 0.5);
        } else if *plain == 0.0 && depth < 29.99 {
            let expected = 1.0 - umbrage::maths::selection::range_fade(depth, 30.0, 0.5);
            // Half precision and depths of the prepass.
            assert!(
                (f64::from(*faded) - expected).abs() < 0.005,
                "{depth} m: {faded}, not {expected}"
            );
            partial += 1;
        }
    }
    assert!(
        full > 100 && partial > 30,
        "{full} in full shadow, {partial} in faded shadow"
    );
}
