//! One mask against the truth of its shot: [`ShotTruth`].

use bevy::{
    math::{DVec3, UVec2},
    prelude::*,
};

use super::report::{Confirmation, Distance, Floor, Row, TexelPixel, Texels, percent};
use crate::{
    level::shot::Shot,
    maths::{bounds::Bounds, view::ViewVolume},
    render::{
        light_maps::LightMaps,
        reference::{
            accuracy::{self, Counts, Kinds, LIT_ABOVE},
            coverage,
            floor::sampling_floor,
            pixels::{PixelRays, PixelTruth, Traced, trace},
            sampling::{self, Quantiles, Sample},
            scene::TruthScene,
        },
    },
};

/// The longest extent of a texel in pixels at which a map has no excuse outside the edge band.
const FINE: f64 = 0.25;

/// Texel ÷ pixel at which the sampling floor is computed for every shot.
const FLOOR_AT: [f64; 3] = [1.0, 0.25, 0.125];

/// Bins of texel ÷ pixel per doubling, and doublings on both sides of 1.
const BINS_PER_OCTAVE: f64 = 4.0;
const OCTAVES: f64 = 6.0;

/// Everything about a shot that no technique changes.
pub(super) struct ShotTruth {
    scene: TruthScene,
    rays: PixelRays,
    /// `None`: the camera has none.
    view: Option<ViewVolume>,
    to_light: DVec3,
    pub(super) traced: Traced,
    band: Vec<bool>,
    floors: Vec<Floor>,
}

impl ShotTruth {
    /// Traces a picture, from the view depths in metres that the GPU wrote.
    pub(super) fn new(
        scene: TruthScene,
        shot: &Shot,
        size: UVec2,
        depths: &[f32],
        with_floor: bool,
        progress: impl Fn(usize) + Sync,
    ) -> Self {
        let rays = PixelRays::of_camera(size, &shot.camera(), f64::from(shot.fov_y_deg).to_radians());
        let to_light = -Vec3::from(shot.light_dir).as_dvec3();
        let traced = trace(&scene, &rays, depths, f64::from(shot.far), to_light, progress);
        let mut shot_truth = Self {
            band: accuracy::edge_band(size, &traced.truth),
            scene,
            view: view(&rays, shot),
            rays,
            to_light,
            traced,
            floors: Vec::new(),
        };
        if with_floor {
            shot_truth.floors = FLOOR_AT.map(|ratio| shot_truth.floor(ratio, false)).to_vec();
        }
        shot_truth
    }

    /// What the scene has in it.
    pub(super) fn scene(&self) -> &TruthScene {
        &self.scene
    }

    /// All numbers of one technique; names are left empty.
    pub(super) fn row(&self, mask: &[u8], maps: &LightMaps, texels_drawn: u64) -> Row {
        let truth = &self.traced.truth;
        let valid = accuracy::count_where(mask, truth, |_| true);
        let samples = sampling::samples(maps, &self.rays, &self.traced);
        let texel_pixel = texel_pixel(&samples, valid.valid);
        let over_receivers = coverage::touched_texels(maps, &self.rays, &self.traced, self.to_light);
        let in_view = self.view.as_ref().map_or(0.0, |view| {
            let statistics = self.scene.statistics();
            let [min, max] =
                [statistics.bounds_min_m, statistics.bounds_max_m].map(|corner| Vec3::from(corner).as_dvec3());
            coverage::texels_in_view(maps, view, &Bounds::new(min, max))
        });
        let mut floor = self.floors.clone();
        if let Some(found) = texel_pixel.as_ref().filter(|_| !floor.is_empty()) {
            floor.push(self.floor(found.mean_size.median, true));
        }
        Row {
            pixels: self.rays.size.x * self.rays.size.y,
            kinds: Kinds::of(truth),
            overall: valid.into(),
            band: accuracy::count_where(mask, truth, |index| self.band[index]).into(),
            confirmation: self.confirm(mask, &samples, valid.valid),
            texel_pixel,
            texels: Texels {
                drawn: texels_drawn,
                over_receivers,
                over_receivers_percent: 100.0 * over_receivers as f64 / texels_drawn.max(1) as f64,
                in_view,
                in_view_percent: 100.0 * in_view / texels_drawn.max(1) as f64,
            },
            floor,
            distances: self.distances(mask),
            ..Row::default()
        }
    }

    fn confirm(&self, mask: &[u8], samples: &[Option<Sample>], valid: u32) -> Confirmation {
        let is_fine = |index: usize| samples[index].is_some_and(|sample| sample.largest <= FINE);
        let counts = accuracy::count_where(mask, &self.traced.truth, |index| !self.band[index] && is_fine(index));
        let wrong = counts.false_shadow + counts.false_lit;
        Confirmation {
            largest: FINE,
            pixels: counts.valid,
            pixels_percent: percent(counts.valid, valid),
            wrong,
            wrong_percent: percent(wrong, counts.valid),
        }
    }

    fn floor(&self, ratio: f64, is_median: bool) -> Floor {
        let floor = sampling_floor(&self.scene, &self.rays, &self.traced, self.to_light, ratio);
        Floor {
            texel_pixel: ratio,
            is_median,
            nearest_percent: 100.0 * floor.nearest.wrong_share(),
            bilinear_percent: 100.0 * floor.bilinear.wrong_share(),
        }
    }

    /// Half octaves of view depth, those with valid pixels only.
    fn distances(&self, mask: &[u8]) -> Vec<Distance> {
        let mut bins: std::collections::BTreeMap<i32, Counts> = std::collections::BTreeMap::new();
        for (index, (value, truth)) in mask.iter().zip(&self.traced.truth).enumerate() {
            if let Some(point) = self.traced.valid_point(index) {
                let bin = (point.view_depth.log2() * 2.0).floor() as i32;
                let counts = bins.entry(bin).or_default();
                counts.add(*truth == PixelTruth::Lit, *value > LIT_ABOVE);
            }
        }
        bins.into_iter()
            .map(|(bin, counts)| Distance {
                from_m: (f64::from(bin) * 0.5).exp2(),
                to_m: (f64::from(bin + 1) * 0.5).exp2(),
                valid: counts.valid,
                wrong: counts.false_shadow + counts.false_lit,
            })
            .collect()
    }
}

fn texel_pixel(samples: &[Option<Sample>], valid: u32) -> Option<TexelPixel> {
    let found = || samples.iter().flatten();
    let pixels = found().count() as u32;
    let mut histogram = vec![0; (2.0 * OCTAVES * BINS_PER_OCTAVE) as usize + 2];
    for sample in found() {
        histogram[bin_of(sample.mean_size)] += 1;
    }
    Some(TexelPixel {
        pixels,
        without_map: valid.saturating_sub(pixels),
        mean_size: Quantiles::of(found().map(|sample| sample.mean_size))?,
        largest: Quantiles::of(found().map(|sample| sample.largest))?,
        perspective: Quantiles::of(found().map(|sample| sample.perspective))?,
        projection: Quantiles::of(found().map(|sample| sample.projection))?,
        histogram,
    })
}

/// Which number of a histogram counts a texel ÷ pixel.
fn bin_of(mean_size: f64) -> usize {
    let bin = (mean_size.log2() + OCTAVES) * BINS_PER_OCTAVE;
    bin.ceil().clamp(0.0, 2.0 * OCTAVES * BINS_PER_OCTAVE + 1.0) as usize
}

/// The upper end of a number of a histogram; infinite for the last.
pub(super) fn bin_end(bin: usize) -> f64 {
    if bin as f64 > 2.0 * OCTAVES * BINS_PER_OCTAVE {
        f64::INFINITY
    } else {
        (bin as f64 / BINS_PER_OCTAVE - OCTAVES).exp2()
    }
}

/// What a shot's camera sees between near and far.
fn view(rays: &PixelRays, shot: &Shot) -> Option<ViewVolume> {
    let (near, far) = (f64::from(shot.near), f64::from(shot.far));
    let size = rays.size.as_dvec2();
    let opening = 2.0 * rays.tan_half_fov_y.atan();
    ViewVolume::perspective(rays.eye, rays.forward, rays.up, opening, size.x / size.y, near, far).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{maths::sampling_rate::TexelsPerPixel, render::reference::pixels::SurfacePoint};

    fn truth(kinds: &[PixelTruth], depths: &[f64]) -> ShotTruth {
        let points = depths.iter().map(|view_depth| {
            Some(SurfacePoint {
                position_world: DVec3::ZERO,
                normal_world: DVec3::Y,
                view_depth: *view_depth,
            })
        });
        let size = UVec2::new(kinds.len() as u32, 1);
        ShotTruth {
            scene: TruthScene::new([]),
            rays: PixelRays {
                size,
                eye: DVec3::Y,
                right: DVec3::X,
                up: DVec3::NEG_Z,
                forward: DVec3::NEG_Y,
                tan_half_fov_y: 1.0,
            },
            view: None,
            to_light: DVec3::Y,
            band: accuracy::edge_band(size, kinds),
            traced: Traced {
                truth: kinds.to_vec(),
                points: points.collect(),
            },
            floors: Vec::new(),
        }
    }

    #[test]
    fn bins_end_where_they_say() {
        assert_eq!((bin_of(1.0), bin_end(24)), (24, 1.0));
        assert_eq!((bin_of(1.001), bin_of(1.0e9), bin_of(1.0e-9)), (25, 49, 0));
        assert!(bin_end(49).is_infinite() && bin_end(28) == 2.0 && bin_end(0) == 1.0 / 64.0);
    }

    #[test]
    fn fine_texels_away_from_edges_confirm_truth() {
        use PixelTruth::{Lit, Shadow, Sky};
        // Pixels 0 to 2 are lit, away from the edge; 3 to 8 are near it; 9 to 11 are in shadow.
        let kinds = [
            Lit, Lit, Lit, Lit, Lit, Lit, Shadow, Shadow, Shadow, Shadow, Sky, Shadow,
        ];
        let shot = truth(&kinds, &[1.0; 12]);
        let sample = |largest| {
            Some(Sample {
                map: 0,
                mean_size: 0.1,
                largest,
                perspective: 0.1,
                projection: 1.0,
                texels_per_pixel: TexelsPerPixel {
                    area: 100.0,
                    across: 10.0,
                    along: 10.0,
                },
            })
        };
        let mut samples = vec![sample(0.25); 12];
        samples[1] = sample(0.26);
        samples[2] = None;
        // Wrong everywhere but at pixel 0.
        let mut mask = kinds.map(|kind| if kind == Lit { 0 } else { 255 });
        mask[0] = 255;
        let found = shot.confirm(&mask, &samples, 11);
        assert_eq!((found.pixels, found.wrong), (3, 2), "pixels 0, 9 and 11");
        assert!(
            (found.pixels_percent - 300.0 / 11.0).abs() < 1.0e-9 && (found.wrong_percent - 200.0 / 3.0).abs() < 1.0e-9
        );
        let sampled = texel_pixel(&samples, 11).expect("samples");
        assert_eq!((sampled.pixels, sampled.without_map), (11, 0));
        assert_eq!(sampled.histogram.iter().sum::<u32>(), 11);
        assert_eq!(texel_pixel(&[None; 3], 3), None);
    }

    #[test]
    fn errors_are_sorted_by_distance() {
        use PixelTruth::{Lit, Shadow};
        let shot = truth(&[Lit, Lit, Shadow, Shadow], &[1.1, 1.3, 1.5, 9.0]);
        let found = shot.distances(&[255, 0, 255, 0]);
        assert_eq!(found.len(), 3);
        let [near, middle, far] = [found[0], found[1], found[2]];
        assert_eq!((near.from_m, near.valid, near.wrong), (1.0, 2, 1));
        assert!((near.to_m - 2.0_f64.sqrt()).abs() < 1.0e-12 && middle.to_m == 2.0);
        assert_eq!((middle.valid, middle.wrong), (1, 1));
        assert_eq!((far.from_m, far.valid, far.wrong), (8.0, 1, 0));
    }
}
