//! What perfectly spread texels would still get wrong: [`sampling_floor`].
//!
//! A shadow map of r texel ÷ pixel whose texels follow the pixels exactly, everywhere, still has its samples somewhere
//! else than the pixels: each texel is one ray to the sun, at its own centre. The floor replaces the map by such rays
//! through the true scene, with no depth error and no bias. Texels have the shape of the pixel's own footprint on the
//! receiver's plane, r times as large, and lie at random under the pixel.
//!
//! * *nearest*: the one ray of the texel that holds the pixel;
//! * *2×2*: the four nearest rays, weighted bilinearly; lit above [`LIT_ABOVE`](super::accuracy::LIT_ABOVE) ÷ 255.
//!
//! Techniques that get less wrong than the floor of their median either put texels where they matter more than the
//! median says, or profit from texels that are finer along one axis.

use bevy::math::{DVec2, DVec3};

use super::{
    accuracy::{Counts, LIT_ABOVE},
    pixels::{OFFSETS, PixelRays, PixelTruth, SurfacePoint, Traced, rows},
    sampling::Camera,
    scene::TruthScene,
};

/// What is wrong at best, of the valid pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SamplingFloor {
    /// With one comparison.
    pub nearest: Counts,
    /// With four, weighted bilinearly.
    pub bilinear: Counts,
}

/// The floor at `ratio` texel ÷ pixel (lengths). The same input gives the same floor: texels lie where a hash of the
/// pixel's index says.
pub fn sampling_floor(
    scene: &TruthScene,
    rays: &PixelRays,
    traced: &Traced,
    direction_to_light: DVec3,
    ratio: f64,
) -> SamplingFloor {
    let camera = Camera::new(rays);
    let to_light = direction_to_light.normalize_or_zero();
    let (width, height) = (rays.size.x as usize, rays.size.y as usize);
    if traced.truth.len() < width * height {
        return SamplingFloor::default();
    }
    let found = rows(
        width,
        height,
        |x, y| {
            let index = y * width + x;
            let point = traced.valid_point(index)?;
            let steps = camera.footprint(point)?.on_plane(point.normal_world);
            let texel = Texel {
                scene,
                point,
                steps: steps.map(|step| step * ratio),
                to_light,
            };
            let place = DVec2::new(unit(2 * index as u64), unit(2 * index as u64 + 1));
            Some((texel.nearest(place), texel.bilinear(place)))
        },
        &|| {},
    );
    let mut floor = SamplingFloor::default();
    for (truth, found) in traced.truth.iter().zip(found) {
        if let Some((nearest, bilinear)) = found {
            let is_lit = *truth == PixelTruth::Lit;
            floor.nearest.add(is_lit, nearest);
            floor.bilinear.add(is_lit, bilinear);
        }
    }
    floor
}

/// The texels around one pixel.
struct Texel<'a> {
    scene: &'a TruthScene,
    point: &'a SurfacePoint,
    /// Sides of a texel on the receiver's plane.
    steps: [DVec3; 2],
    to_light: DVec3,
}

impl Texel<'_> {
    /// Whether the sun is seen from a place on the receiver's plane, in texels from the pixel.
    fn is_lit(&self, place: DVec2) -> bool {
        let start = self.point.position_world + self.steps[0] * place.x + self.steps[1] * place.y;
        !self.scene.is_in_shadow(start, self.to_light, OFFSETS[1])
    }

    /// The pixel is at `place` (0..1) in its texel.
    fn nearest(&self, place: DVec2) -> bool {
        self.is_lit(0.5 - place)
    }

    /// The pixel is at `place` (0..1) between four texel centres.
    fn bilinear(&self, place: DVec2) -> bool {
        let lit = |x: f64, y: f64| f64::from(u8::from(self.is_lit(DVec2::new(x, y) - place)));
        let top = lit(0.0, 0.0) * (1.0 - place.x) + lit(1.0, 0.0) * place.x;
        let bottom = lit(0.0, 1.0) * (1.0 - place.x) + lit(1.0, 1.0) * place.x;
        top * (1.0 - place.y) + bottom * place.y > f64::from(LIT_ABOVE) / 255.0
    }
}

/// A number in 0..1 from an index: the finaliser of SplitMix64 (Steele, Lea, Flood 2014).
fn unit(index: u64) -> f64 {
    let mut bits = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^= bits >> 31;
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy::math::{Affine3A, UVec2, Vec3};

    use super::*;
    use crate::render::reference::{mesh::TruthMesh, scene::TruthInstance};

    /// A sheet over the half x < 0 of the ground, 5 m up, and a camera 10 m above the ground that sees 400 pixels of 0.1 m
    /// around x = 0 in each of 50 rows (the sheet is not in its way: the points are given).
    fn half_in_shadow() -> (TruthScene, PixelRays, Traced) {
        let corners = [
            [-50.0, 5.0, -50.0],
            [0.0, 5.0, -50.0],
            [0.0, 5.0, 50.0],
            [-50.0, 5.0, 50.0],
        ];
        let sheet = TruthMesh::new(corners.map(Vec3::from).to_vec(), Vec::new(), vec![[0, 2, 1], [0, 3, 2]]);
        let scene = TruthScene::new([TruthInstance {
            mesh: Arc::new(sheet.expect("two triangles")),
            world_from_local: Affine3A::IDENTITY,
            alpha: None,
            double_sided: true,
            casts: true,
        }]);
        let rays = PixelRays {
            size: UVec2::new(400, 50),
            eye: DVec3::Y * 10.0,
            right: DVec3::X,
            up: DVec3::NEG_Z,
            forward: DVec3::NEG_Y,
            tan_half_fov_y: 0.25,
        };
        let points: Vec<_> = (0..50)
            .flat_map(|y| (0..400).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)))
            .map(|(x, y)| {
                Some(SurfacePoint {
                    position_world: rays.eye + rays.direction(x, y) * 10.0,
                    normal_world: DVec3::Y,
                    view_depth: 10.0,
                })
            })
            .collect();
        let truth = points
            .iter()
            .flatten()
            .map(|point: &SurfacePoint| {
                if point.position_world.x < 0.0 {
                    PixelTruth::Shadow
                } else {
                    PixelTruth::Lit
                }
            })
            .collect();
        (scene, rays, Traced { truth, points })
    }

    /// Along a straight edge a pixel at distance d (in texels) is wrong with probability max(0, 1/2 − d) with one comparison,
    /// and with four when the weight on the other side exceeds a half: with probability max(0, 1/2 − d) too, d measured
    /// along the edge's normal. Both sum up to r ÷ 4 pixels per row where pixels are small against texels.
    #[test]
    fn an_edge_has_the_floor_that_can_be_worked_out() {
        let (scene, rays, traced) = half_in_shadow();
        for ratio in [4.0, 16.0] {
            let floor = sampling_floor(&scene, &rays, &traced, DVec3::Y, ratio);
            assert_eq!(floor.nearest.valid, 20_000);
            let per_row = |counts: Counts| f64::from(counts.false_shadow + counts.false_lit) / 50.0;
            // Binomial noise of 50 rows: a standard deviation of about 0.2 pixels at r = 16.
            let expected = ratio / 4.0;
            assert!((per_row(floor.nearest) - expected).abs() < 0.7, "{floor:?}");
            assert!((per_row(floor.bilinear) - expected).abs() < 0.7, "{floor:?}");
            let again = sampling_floor(&scene, &rays, &traced, DVec3::Y, ratio);
            assert_eq!(floor, again, "deterministic");
        }
        let fine = sampling_floor(&scene, &rays, &traced, DVec3::Y, 0.01);
        assert_eq!(
            fine.nearest.wrong_share() + fine.bilinear.wrong_share(),
            0.0,
            "{fine:?}"
        );
    }

    #[test]
    fn numbers_are_spread_evenly() {
        let mean = (0..10_000).map(unit).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert!((0..10_000).map(unit).all(|value| (0.0..1.0).contains(&value)));
    }
}
