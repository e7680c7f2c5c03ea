//! The heat map on the GPU against texel ÷ pixel, and texels per pixel, on the CPU.

use std::collections::HashSet;

use bevy::prelude::*;
use umbrage::{
    maths::sampling_rate::RateMeasure,
    prelude::*,
    render::{
        capture,
        heat_map::{
            HeatColors, TexelHeatMap,
            color::{heat_color, sampling_color},
        },
        light_maps::LightMaps,
        mask::ShadowMask,
        reference::{
            extract::truth_scene,
            pixels::{self, PixelRays},
            sampling::{Sample, samples},
        },
    },
    shadow::technique::Technique,
};

use crate::harness::{Harness, eye};

const SIZE: UVec2 = UVec2::new(160, 90);
const LIGHT: Vec3 = Vec3::new(-0.5, -0.8, -0.4);

/// What can be computed from a sample.
const COLORS: [HeatColors; 4] = [
    HeatColors::TexelRatio,
    HeatColors::SamplingRate(RateMeasure::Area),
    HeatColors::SamplingRate(RateMeasure::Across),
    HeatColors::SamplingRate(RateMeasure::Along),
];

fn wanted_color(colors: HeatColors, sample: &Sample) -> Srgba {
    match colors {
        HeatColors::TexelRatio => heat_color(sample.mean_size as f32).into(),
        HeatColors::SamplingRate(measure) => sampling_color(sample.texels_per_pixel.get(measure) as f32).into(),
        HeatColors::Maps => unreachable!("its colors are not those of a number"),
    }
}

/// A picture against the CPU's numbers.
struct Comparison {
    /// Share of pixels whose color is not that of the CPU's number.
    different: f64,
    compared: usize,
    shown: HashSet<Vec<u8>>,
}

fn compare(picture: &[u8], samples: &[Option<Sample>], colors: HeatColors) -> Comparison {
    let (mut compared, mut different, mut all_shown) = (0_usize, 0_usize, HashSet::new());
    for (index, sample) in samples.iter().enumerate() {
        let Some(sample) = sample else {
            continue;
        };
        let wanted = wanted_color(colors, sample);
        let shown = &picture[index * 4..index * 4 + 3];
        let is_close = |(wanted, shown): (f32, &u8)| (wanted * 255.0 - f32::from(*shown)).abs() <= 6.0;
        compared += 1;
        different += usize::from(
            ![wanted.red, wanted.green, wanted.blue]
                .into_iter()
                .zip(shown)
                .all(is_close),
        );
        all_shown.insert(shown.to_vec());
    }
    Comparison {
        different: different as f64 / compared as f64,
        compared,
        shown: all_shown,
    }
}

/// One comparison for each of [`COLORS`], of some of the maps.
fn comparisons(technique: &str, maps_of: fn(&World, Entity, Entity) -> LightMaps) -> [Comparison; 4] {
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
    let maps = maps_of(harness.app.world(), light, camera);
    assert!(!maps.maps.is_empty(), "{technique} has maps");
    let pictures = COLORS.map(|colors| {
        harness.app.world_mut().entity_mut(camera).insert(TexelHeatMap {
            light_maps: maps.clone(),
            direction_to_light: -LIGHT.normalize(),
            colors,
            opacity: 1.0,
        });
        harness.frames(3);
        capture::read_image(&harness.app, &harness.target).expect("the picture can be read")
    });
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
    let samples = samples(&maps, &rays, &traced);
    std::array::from_fn(|index| compare(&pictures[index].bytes, &samples, COLORS[index]))
}

#[test]
fn the_gpu_shows_what_the_cpu_computes() {
    let mut shown = COLORS.map(|_| HashSet::new());
    let (of_frame, before_films) = (LightMaps::of as fn(&World, _, _) -> _, LightMaps::before_films);
    for (technique, maps_of) in [
        ("zp4+lispsm:size=256", of_frame),
        ("lispsm:size=512,select=depth", of_frame),
        ("zp2+lispsm:path=dropin,size=256", of_frame),
        ("bevy", of_frame),
        ("optimal:size=512,frusta=4", of_frame),
        ("optimal:size=512,frusta=4", before_films),
    ] {
        for ((colors, found), shown) in COLORS.iter().zip(comparisons(technique, maps_of)).zip(&mut shown) {
            let Comparison {
                different, compared, ..
            } = found;
            let count = found.shown.len();
            println!("{technique}, {colors:?}: {different:.4} of {compared} differ; {count} colors");
            assert!(compared > 3_000, "{technique}, {colors:?}: {compared} pixels");
            // The scale of texels per pixel ends at 10.
            assert!(
                count > 10 || *colors != HeatColors::TexelRatio,
                "{technique}: {count} colors"
            );
            // Beside the seams of maps one may take the other map.
            assert!(
                different < 0.01,
                "{technique}, {colors:?}: {different} of the pixels have another color"
            );
            shown.extend(found.shown);
        }
    }
    for (colors, shown) in COLORS.iter().zip(shown) {
        assert!(shown.len() > 100, "{colors:?}: {} colors in all", shown.len());
    }
}
