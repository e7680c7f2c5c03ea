//! Kinds of bias, and maps that store other surfaces than the nearest.

use bevy::prelude::*;
use umbrage::render::atlas::ShadowAtlas;

use crate::{
    harness::Harness,
    truth::{LIGHTS, boxes, errors, harness_with, settings},
};

/// Scherzer 2005, figure 6: without bias lit surfaces are full of moiré; every remedy takes nearly all of it away, and
/// keeps the shadows. Measured on llvmpipe: 0.49 without bias, at most 0.0003 with any.
#[test]
fn every_bias_removes_moire_and_keeps_shadows() {
    let light = LIGHTS[0];
    let (moire, _) = errors(light, "zp4+lispsm:size=512,bias=none");
    assert!(moire > 0.15, "without bias only {moire} is wrongly in shadow");
    for keys in [
        "bias_m=0.1",
        "bias=slope",
        "bias=world-slope",
        "bias=receiver",
        "store=back,bias=none",
        "store=second,bias=none",
        "store=midpoint,bias=none",
        "store=back",
        "store=back,bias=slope",
        "store=second",
        "store=midpoint",
    ] {
        let (false_shadow, false_lit) = errors(light, &format!("zp4+lispsm:size=512,{keys}"));
        assert!(
            false_shadow < 0.001,
            "{keys}: {false_shadow} wrongly in shadow, {moire} without bias"
        );
        assert!(false_lit < 0.001, "{keys}: {false_lit} wrongly lit");
    }
}

/// Both atlases of one light view: depths by texel.
fn atlases(technique: &str, with_leaf: bool) -> (Vec<f32>, Option<Vec<f32>>) {
    let mut harness = harness_with(&boxes());
    if with_leaf {
        let leaf = harness.mesh(Rectangle::new(4.0, 4.0));
        let holes = harness.holes();
        let place = Transform::from_xyz(0.0, 8.0, 4.0).looking_to(Vec3::Y, Vec3::X);
        harness
            .app
            .world_mut()
            .spawn((Mesh3d(leaf), MeshMaterial3d(holes), place));
    }
    harness.sun(LIGHTS[0], settings(technique));
    harness.start();
    let first = harness.atlas().to_f32();
    let second = second_atlas(&harness);
    (first, second)
}

fn second_atlas(harness: &Harness) -> Option<Vec<f32>> {
    let has_second = std::cell::Cell::new(false);
    let texels = harness.camera_texture::<ShadowAtlas>(harness.camera, |atlas| {
        has_second.set(atlas.second.is_some());
        atlas.second.as_ref().map_or(&atlas.texture, |(texture, _)| texture)
    });
    has_second.get().then(|| texels.to_f32())
}

#[test]
fn the_second_atlas_holds_what_lies_behind_the_first() {
    const TECHNIQUE: &str = "lispsm:size=512";
    let (nearest, none) = atlases(TECHNIQUE, false);
    assert!(none.is_none(), "one atlas suffices for the nearest surface");
    let (first, second) = atlases(&format!("{TECHNIQUE},store=second"), false);
    let second = second.expect("a second atlas");
    assert_eq!(first, nearest, "the first atlas does not change");
    let (_, midpoint) = atlases(&format!("{TECHNIQUE},store=midpoint"), false);
    let midpoint = midpoint.expect("a second atlas");
    let (back, _) = atlases(&format!("{TECHNIQUE},store=back"), false);
    let mut solid = 0;
    for (index, (first, second)) in first.iter().zip(&second).enumerate() {
        assert!(
            *second < *first || *first == 0.0,
            "texel {index}: {second} is not behind {first}"
        );
        // The boxes are closed and stand on or over the ground, which is one sheet: behind a box's top is its bottom.
        // (Where the two are one to a millionth, at edges, the second is what comes next.)
        if back[index] > 0.0 && back[index] < *first * (1.0 - 2.0e-6) {
            solid += 1;
            assert!(
                *second >= back[index] - 1.0e-6,
                "texel {index}: {second} is behind the back face at {}",
                back[index]
            );
        }
        let middle = if *second > 0.0 { 0.5 * (first + second) } else { 0.0 };
        assert!(
            (midpoint[index] - middle).abs() < 1.0e-6,
            "texel {index}: {} is not the middle {middle} of {first} and {second}",
            midpoint[index]
        );
    }
    assert!(solid > 1_000, "only {solid} texels of closed boxes");
}

/// Leaves have no back side: they stay in the map, with their holes.
#[test]
fn sheets_with_holes_stay_in_the_map() {
    for store in ["back", "second", "midpoint"] {
        let technique = format!("lispsm:size=512,store={store}");
        let with = atlases(&technique, true);
        let without = atlases(&technique, false);
        let lookup = |(first, second): (Vec<f32>, Option<Vec<f32>>)| second.unwrap_or(first);
        let (with, without) = (lookup(with), lookup(without));
        let covered = with.iter().zip(&without).filter(|(a, b)| *a > *b).count();
        assert!(covered > 300, "{store}: the leaf covers only {covered} texels");
    }
}
