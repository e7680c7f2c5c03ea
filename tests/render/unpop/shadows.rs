//! Shadows of fading levels.

use bevy::prelude::*;
use umbrage::{
    prelude::*,
    render::{atlas::ShadowAtlas, virtual_map::report::VirtualMapReports},
};

use super::{SIZE, cards, chain, set_share, stage};
use crate::harness::Harness;

/// Columns of the picture in which the shadow lies on the wall, left of what casts it.
const SHADOW: std::ops::Range<usize> = 20..54;

/// A box before a wall that becomes larger, or smaller, as it changes its level.
fn boxes(harness: &mut Harness, grows: bool, technique: &str) {
    let material = harness.material(Color::srgb(0.5, 0.5, 0.5));
    let (small, large) = (
        harness.mesh(Cuboid::new(0.3, 0.3, 0.3)),
        harness.mesh(Cuboid::new(0.9, 0.9, 0.9)),
    );
    let mut levels = [(&small, &material), (&large, &material)];
    if !grows {
        levels.reverse();
    }
    chain(harness, Transform::from_xyz(1.6, 0.5, 0.3), &levels);
    let wall = harness.mesh(cards(&[(3.5, 1.8, -0.5)]));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(wall), MeshMaterial3d(material.clone())));
    // What reaches beyond both levels keeps the maps where they are.
    for place in [Vec3::new(-3.3, -1.6, 1.2), Vec3::new(3.3, 1.6, 1.2)] {
        let place = Transform::from_translation(place);
        world.spawn((Mesh3d(small.clone()), MeshMaterial3d(material.clone()), place));
    }
    match technique.parse() {
        Ok(Technique::Umbrage(settings)) => harness.sun(Vec3::new(-1.6, -0.6, -0.8), settings),
        other => panic!("no technique of Umbrage: {other:?}"),
    };
}

fn result_at(harness: &mut Harness, t: f64) -> Vec<f32> {
    set_share(harness, t);
    harness.frames(3);
    let result = harness.shadow_result(harness.camera);
    let rows = result.chunks(SIZE.x as usize);
    rows.flat_map(|row| row[SHADOW].to_vec()).collect()
}

/// While a level fades, the light that it takes is its share of what it will take: in every pixel, without steps. In the first
/// half that is what the new level adds, in the second what the old one leaves.
#[test]
fn shadows_of_fading_levels_change_little_by_little() {
    // Of filters that find their width themselves both levels widen the same penumbra.
    for (technique, grows, tolerance) in [
        ("zp2+lispsm:size=512", true, 0.01),
        ("zp2+lispsm:size=512", false, 0.01),
        ("zp2:size=512,passes=each", false, 0.01),
        ("zp2+lispsm:size=512,store=midpoint", true, 0.01),
        ("lispsm:size=512,filter=pcss", true, 0.05),
        ("tiled:n=4,tile=256", true, 0.01),
        ("fitted:n=8,tile_max=256", false, 0.01),
    ] {
        let mut harness = stage();
        boxes(&mut harness, grows, technique);
        harness.start();
        let (old, new) = (result_at(&mut harness, 0.0), result_at(&mut harness, 1.0));
        let covered = |result: &[f32]| result.iter().map(|lit| 1.0 - lit).sum::<f32>();
        let (most, least) = if grows { (&new, &old) } else { (&old, &new) };
        assert!(
            covered(most) > 2.0 * covered(least) && covered(least) > 1.0,
            "{technique}: {} and {} pixels in shadow",
            covered(most),
            covered(least)
        );
        let fades = |harness: &Harness| harness.of_camera(|atlas: &ShadowAtlas| atlas.fades);
        for t in [0.05, 0.4, 0.5, 0.75] {
            let found = result_at(&mut harness, t);
            let (opaque, share) = if t < 0.5 {
                (&old, 2.0 * t as f32)
            } else {
                (&new, 2.0 * (1.0 - t as f32))
            };
            let farthest = found
                .iter()
                .zip(opaque.iter().zip(most))
                .map(|(found, (opaque, both))| (found - (opaque + share * (both - opaque))).abs())
                .fold(0.0, f32::max);
            assert!(
                farthest < tolerance,
                "{technique}, grows {grows}: {farthest} off at t {t}"
            );
            assert!(fades(&harness), "{technique}: something fades at t {t}");
        }
        result_at(&mut harness, 1.0);
        assert!(!fades(&harness), "{technique}: nothing fades at rest");
    }
}

/// Casters that fade have tile textures of their own. Their memory is kept for them from the start: the bound holds while
/// something fades, and tiles are the same before.
#[test]
fn the_memory_of_tiles_is_bounded_while_levels_fade() {
    for technique in [
        "tiled:n=4,tile=512,memory=1,filter=hard",
        "queried:min=0,max=4,tile=256,tile_max=512,memory=1,filter=hard",
        "fitted:n=8,tile_max=512,memory=1,filter=hard",
    ] {
        let mut harness = stage();
        boxes(&mut harness, true, technique);
        harness.start();
        let mut report_at = |t: f64| {
            set_share(&mut harness, t);
            harness.frames(3);
            let reports = harness.app.world().resource::<VirtualMapReports>();
            let fades = harness.of_camera(|atlas: &ShadowAtlas| atlas.fades);
            let report = reports.get(harness.camera).expect("a virtual map");
            (fades, report.texture_bytes)
        };
        let (rests, before) = report_at(0.0);
        let (fades, during) = report_at(0.4);
        assert_eq!((rests, fades), (false, true), "{technique}");
        assert_eq!(
            during,
            2 * before,
            "{technique}: the same cells, and as many for what fades"
        );
        assert!(during <= 1 << 20, "{technique}: {during} bytes");
    }
}
