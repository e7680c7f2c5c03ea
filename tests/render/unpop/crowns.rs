//! Fading crowns: many layers, shadows on themselves, objects before each other, and how much is seen of it.

use std::sync::Arc;

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::prepass::DeferredPrepass,
    mesh::{Indices, PrimitiveTopology},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
};
use umbrage::{
    lod::{
        chain::LodChain,
        settings::{LodKind, LodSettings},
    },
    maths::lod::{energy::picture_energy, selection::LodBorders},
    prelude::*,
};

use super::{BAND, BORDER, cards, chain, picture, picture_at, set_share, stage};
use crate::harness::Harness;

/// Three crowns beside each other, and where their levels change.
const ROW: [(Vec3, f64); 3] = [
    (Vec3::new(-1.6, 0.1, 0.0), BORDER),
    (Vec3::new(0.3, 0.1, 0.0), BORDER),
    (Vec3::new(2.1, 0.1, 0.0), BORDER),
];

/// Two warped maps.
const SLICES: &str = "zp2+lispsm:size=512";

/// Crowns of cards under a sun: solid things with many layers, shadows on themselves and on the ground.
fn grove(harness: &mut Harness, crowns: &[(Vec3, f64)], technique: &str) {
    let leaves = |seed: u32, count: u32, side: f32| {
        let mut state = seed;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
        };
        let mut mesh: Option<Mesh> = None;
        for _ in 0..count {
            let middle = Vec3::new(next(), next(), next()) * 0.9;
            let turn = Quat::from_euler(EulerRot::XYZ, 3.0 * next(), 3.0 * next(), 0.0);
            let card =
                cards(&[(side, side, 0.0)]).transformed_by(Transform::from_translation(middle).with_rotation(turn));
            match &mut mesh {
                None => mesh = Some(card),
                Some(mesh) => mesh.merge(&card).expect("meshes of one kind"),
            }
        }
        mesh.expect("leaves")
    };
    let material = |harness: &mut Harness, color: Color| {
        harness.material(StandardMaterial {
            base_color: color,
            cull_mode: None,
            double_sided: true,
            perceptual_roughness: 1.0,
            ..default()
        })
    };
    let (green, olive) = (
        material(harness, Color::srgb(0.2, 0.55, 0.15)),
        material(harness, Color::srgb(0.4, 0.5, 0.2)),
    );
    let (fine, coarse) = (harness.mesh(leaves(1, 160, 0.14)), harness.mesh(leaves(2, 40, 0.28)));
    for (place, border) in crowns {
        let levels = [(&fine, &green), (&coarse, &olive)];
        let crown = chain(harness, Transform::from_translation(*place), &levels);
        let mut crown = harness.app.world_mut().get_mut::<LodChain>(crown).expect("a chain");
        crown.borders = Arc::new(LodBorders::new([*border]));
    }
    let ground = harness.mesh(Plane3d::default().mesh().size(30.0, 30.0));
    let gray = material(harness, Color::srgb(0.5, 0.5, 0.5));
    let place = Transform::from_xyz(0.0, -1.2, 0.0);
    harness
        .app
        .world_mut()
        .spawn((Mesh3d(ground), MeshMaterial3d(gray), place));
    harness.sun(
        Vec3::new(-0.5, -0.8, -0.4),
        match technique.parse() {
            Ok(Technique::Umbrage(settings)) => settings,
            other => panic!("no technique of Umbrage: {other:?}"),
        },
    );
}

/// Shares of pixels that differ by more than so many codes.
fn share_beyond(a: &[u8], b: &[u8], codes: u8) -> f64 {
    let pixels = a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0);
    let far = pixels
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > codes))
        .count();
    far as f64 / (a.len() / 4) as f64
}

/// Lit and shadowed, forward and deferred, the fading level just before it becomes opaque looks like the opaque one just
/// after: its shadow lookups are its own, in maps of every kind.
#[test]
fn fading_levels_are_lit_and_shadowed_like_opaque_ones() {
    for (technique, deferred) in [
        (SLICES, false),
        (SLICES, true),
        ("tiled:n=4,tile=256", false),
        ("fitted:n=8,tile_max=256", false),
    ] {
        let mut harness = stage();
        if deferred {
            harness.app.insert_resource(DefaultOpaqueRendererMethod::deferred());
            let camera = harness.camera;
            harness.app.world_mut().entity_mut(camera).insert(DeferredPrepass);
        }
        grove(&mut harness, &ROW, technique);
        harness.start();
        let (start, end) = (picture_at(&mut harness, 0.0), picture_at(&mut harness, 1.0));
        let before = picture_at(&mut harness, 0.4995);
        let after = picture_at(&mut harness, 0.5);
        let (pop, jump) = (picture_energy(&start, &end), picture_energy(&before, &after));
        println!(
            "{technique}, deferred {deferred}: jump {:.4} of a pop, {:.4} of pixels by more than 8 codes",
            jump / pop,
            share_beyond(&before, &after, 8)
        );
        assert!(pop > 1.0, "{technique}: the levels differ: {pop}");
        // Fading crowns before each other, and rounding at the edges of leaves.
        assert!(jump < 0.005 * pop, "{technique}: {jump} of {pop}");
    }
}

/// Berries as wide as two pixels, whose vertex normals are up to 109 degrees apart: no plane goes through such pixels, and
/// the normals of the prepass are short. Both levels are the same mesh and material, and texels are wide, so that shadows
/// depend on the normals: nothing may change with the roles.
#[test]
fn rounded_foliage_has_its_normals_while_it_fades() {
    let mut harness = stage();
    let sign = |corner: u32, axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|corner| [sign(corner, 0), sign(corner, 1), sign(corner, 2)]);
    let corners: Vec<[f32; 3]> = corners.collect();
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let indices = faces.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]);
    let berry = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, corners)
        .with_inserted_indices(Indices::U32(indices.collect()));
    let place = |number: u32| {
        let (turn, height) = (number as f32 * 2.4, number as f32 / 60.0 - 1.0);
        let across = (1.0 - height * height).max(0.0).sqrt();
        let middle = Vec3::new(across * turn.cos(), height, across * turn.sin()) * 1.5;
        let place = Transform::from_translation(middle).with_rotation(Quat::from_rotation_y(turn));
        berry.clone().transformed_by(place.with_scale(Vec3::splat(0.08)))
    };
    let mut crown = place(0);
    for number in 1..120 {
        crown.merge(&place(number)).expect("meshes of one kind");
    }
    let (crown, green) = (harness.mesh(crown), harness.material(Color::srgb(0.2, 0.5, 0.2)));
    chain(
        &mut harness,
        Transform::default(),
        &[(&crown, &green), (&crown, &green)],
    );
    let sun = harness.sun(
        Vec3::new(-0.5, -0.8, -0.4),
        match "uniform:size=16".parse() {
            Ok(Technique::Umbrage(settings)) => settings,
            other => panic!("no technique of Umbrage: {other:?}"),
        },
    );
    harness.start();
    let (before, after) = (picture_at(&mut harness, 0.4995), picture_at(&mut harness, 0.5));
    let changed = share_beyond(&before, &after, 8);
    let mut light = harness.app.world_mut().get_mut::<DirectionalLight>(sun).expect("a sun");
    light.shadow_maps_enabled = false;
    let shadowed = share_beyond(&after, &picture_at(&mut harness, 0.5), 8);
    println!("{changed:.4} of the picture changes, {shadowed:.4} is in shadow");
    assert!(shadowed > 0.01, "{shadowed} of the picture is in shadow");
    assert!(changed * 50.0 < shadowed, "{changed} of the picture changes");
}

/// A crown ends to fade before another one that fades: what it covered keeps its nearest leaves and their shadows.
#[test]
fn fading_objects_before_each_other_do_not_jump() {
    let mut harness = stage();
    // When the nearer one ends, the other is at 0.7.
    let crowns = [
        (Vec3::new(0.0, 0.1, 1.5), BORDER),
        (Vec3::new(0.3, 0.1, -1.5), BORDER + 0.3 * BAND),
    ];
    grove(&mut harness, &crowns, SLICES);
    harness.start();
    let mut jumps = Vec::new();
    for layers in [1, 4] {
        harness.app.world_mut().resource_mut::<LodSettings>().fading_layers = layers;
        picture_at(&mut harness, 0.0);
        let before = picture_at(&mut harness, 0.9995);
        let after = picture_at(&mut harness, 1.0);
        jumps.push(picture_energy(&before, &after));
    }
    println!("energies {jumps:?} with one layer and with four");
    assert!(jumps[1] < 0.3 * jumps[0], "{jumps:?} with one layer and with four");
}

/// Peak energies of all kinds over one crossing of 24 frames, in parts of the pop of switching at once.
#[test]
fn unpopping_is_seen_less_than_its_rivals() {
    let frames = 24;
    let mut peaks = Vec::new();
    for kind in [LodKind::Hard, LodKind::Dither, LodKind::Plain, LodKind::Unpopping] {
        let mut harness = stage();
        grove(&mut harness, &ROW, SLICES);
        harness.app.world_mut().resource_mut::<LodSettings>().transition.kind = kind;
        set_share(&mut harness, -0.1);
        harness.start();
        let mut last = picture(&harness);
        let mut peak = 0.0_f64;
        for frame in 0..=frames + 2 {
            set_share(&mut harness, f64::from(frame) / f64::from(frames));
            harness.frames(1);
            let next = picture(&harness);
            peak = peak.max(picture_energy(&last, &next));
            last = next;
        }
        peaks.push((kind, peak));
    }
    let hard = peaks[0].1;
    for (kind, peak) in &peaks {
        println!("{kind:?}: {:.4} of hard", peak / hard);
    }
    let (dither, unpopping) = (peaks[1].1, peaks[3].1);
    assert!(hard > 1.0, "a pop is seen: {hard}");
    assert!(unpopping <= 0.02 * hard, "{unpopping} of {hard}");
    assert!(unpopping <= 0.5 * dither, "{unpopping}, dithering {dither}");
}
