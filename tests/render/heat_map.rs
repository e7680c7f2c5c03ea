//! The heat map on the GPU against texel ÷ pixel on the CPU.

use bevy::prelude::*;
use umbrage::{
    prelude::*,
    render::{
        capture,
        heat_map::{HeatColors, TexelHeatMap, color::heat_color},
        light_maps::LightMaps,
        mask::ShadowMask,
        reference::{
            extract::truth_scene,
            pixels::{self, PixelRays},
            sampling::samples,
        },
    },
    shadow::technique::Technique,
};

use crate::harness::{Harness, eye};

const SIZE: UVec2 = UVec2::new(160, 90);
const LIGHT: Vec3 = Vec3::new(-0.5, -0.8, -0.4);

/// Share of pixels whose color is not that of the CPU's ratio, how many were compared, and how many colors there are.
fn compare(technique: &str) -> (f64, usize, usize) {
    let mut harness = Harness::new(SIZE, eye());
    let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
    let plane = harness.mesh(Plane3d::default().mesh().size(120.0, 120.0));
    let cuboid = harness.mesh(Cuboid::new(2.0, 2.0, 2.0));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    for (x, z) in [(-2.0, 0.0), (4.0, -8.0), (-6.0, -25.0)] {
        world.spawn((
            Mesh3d(cuboid.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(x, 1.0, z),
        ));
    }
    let light = harness.sun(LIGHT, SunShadows::default());
    let technique: Technique = technique.parse().unwrap_or_else(|error| panic!("{technique}: {error}"));
    technique.apply(&mut harness.app.world_mut().commands().entity(light));
    harness.app.world_mut().flush();
    harness.add_mask(light, SIZE);
    harness.start();
    let camera = harness.camera;
    let maps = LightMaps::of(harness.app.world(), light, camera);
    assert!(!maps.maps.is_empty(), "{technique} has maps");
    harness.app.world_mut().entity_mut(camera).insert(TexelHeatMap {
        light_maps: maps.clone(),
        direction_to_light: -LIGHT.normalize(),
        colors: HeatColors::TexelRatio,
        opacity: 1.0,
    });
    harness.frames(3);
    let picture = capture::read_image(&harness.app, &harness.target).expect("the picture can be read");
    let depth = harness
        .app
        .world()
        .get::<ShadowMask>(camera)
        .expect("a mask")
        .depth
        .clone();
    let depth = capture::read_image(&harness.app, &depth).expect("depths can be read");
    let truth = truth_scene(harness.app.world_mut(), Some(camera)).expect("meshes are in main memory");
    let rays = PixelRays::of_camera(SIZE, &eye(), std::f64::consts::FRAC_PI_4);
    let traced = pixels::trace(&truth, &rays, &depth.to_f32(), 120.0, -LIGHT.as_dvec3(), |_| {});
    let (mut compared, mut different, mut colors) = (0_usize, 0_usize, std::collections::HashSet::new());
    for (index, sample) in samples(&maps, &rays, &traced).iter().enumerate() {
        let Some(sample) = sample else {
            continue;
        };
        let wanted = Srgba::from(heat_color(sample.mean_size as f32));
        let shown = &picture.bytes[index * 4..index * 4 + 3];
        let is_close = |(wanted, shown): (f32, &u8)| (wanted * 255.0 - f32::from(*shown)).abs() <= 6.0;
        compared += 1;
        different += usize::from(
            ![wanted.red, wanted.green, wanted.blue]
                .into_iter()
                .zip(shown)
                .all(is_close),
        );
        colors.insert(shown.to_vec());
    }
    (different as f64 / compared as f64, compared, colors.len())
}

#[test]
fn the_gpu_shows_what_the_cpu_computes() {
    for technique in [
        "zp4+lispsm:size=256",
        "lispsm:size=512,select=depth",
        "zp2+lispsm:path=dropin,size=256",
        "bevy",
    ] {
        let (different, compared, colors) = compare(technique);
        println!("{technique}: {different:.4} of {compared} differ; {colors} colors");
        assert!(
            compared > 3_000 && colors > 10,
            "{technique}: {compared} pixels, {colors} colors"
        );
        // Beside the seams of maps one may take the other map.
        assert!(
            different < 0.01,
            "{technique}: {different} of the pixels have another color"
        );
    }
}
