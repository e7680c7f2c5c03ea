//! Pictures to look at: levels of detail side by side, in the sun.

use bevy_math::{Vec2, Vec3};

use super::raster::{Raster, Sight, Surface};
use crate::forge::{
    mesh::{Lod, Model, Variant},
    portable::{mix, srgb_code},
    texture::picture::{Channels, Picture},
};

/// Towards the sun.
const SUN: Vec3 = Vec3::new(0.48, 0.70, 0.53);
/// Towards the viewer: a little from above.
const VIEWER: Vec3 = Vec3::new(0.12, 0.16, 0.98);
/// Points per pixel and axis.
const OVERSAMPLING: usize = 3;
const SUN_POINTS: usize = 1400;

/// All levels of a variant side by side, each `height` pixels high.
pub fn variant(model: &Model, variant: &Variant, height: usize) -> Picture {
    let tiles: Vec<Picture> = variant
        .lods
        .iter()
        .map(|lod| level(model, lod, variant, height))
        .collect();
    let width: usize = tiles.iter().map(|tile| tile.width).sum();
    Picture::from_fn(&variant.name, width, height, Channels::Rgb, |x, y| {
        let mut left = x;
        for tile in &tiles {
            if left < tile.width {
                return tile.texels[y * tile.width + left];
            }
            left -= tile.width;
        }
        [0; 4]
    })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a size in pixels"
)]
fn level(model: &Model, lod: &Lod, of: &Variant, height: usize) -> Picture {
    let bounds = of.lods.first().and_then(Lod::bounds);
    let (low, high) = bounds.unwrap_or((Vec3::ZERO, Vec3::ONE));
    let center = (low + high) * 0.5;
    let extent = high - low;
    let half_height = 0.56 * extent.y.max(0.25 * extent.x.max(extent.z));
    let half = Vec2::new((0.60 * extent.x.max(extent.z)).max(half_height * 0.4), half_height);
    let width = ((height as f32 * half.x / half.y) as usize).max(16);
    let sight = Sight::from_direction(center, VIEWER.normalize(), half);
    let mut seen = Raster::new(width * OVERSAMPLING, height * OVERSAMPLING);
    seen.draw(model, lod, &sight);
    let sun_sight = Sight::from_direction(center, SUN.normalize(), Vec2::splat(extent.length() * 0.55));
    let mut sunlit = Raster::new(SUN_POINTS, SUN_POINTS);
    sunlit.draw(model, lod, &sun_sight);
    let scene = Scene {
        seen,
        sight,
        sunlit,
        sun_sight,
    };
    Picture::from_fn(&of.name, width, height, Channels::Rgb, |x, y| {
        let mut sum = Vec3::ZERO;
        for i in 0..OVERSAMPLING * OVERSAMPLING {
            sum += scene.light(x * OVERSAMPLING + i % OVERSAMPLING, y * OVERSAMPLING + i / OVERSAMPLING);
        }
        let mean = sum / (OVERSAMPLING * OVERSAMPLING) as f32;
        // A soft shoulder, so that bright leaves keep their colour.
        let [r, g, b] = mean
            .to_array()
            .map(|c| srgb_code(c * (1.0 + 0.12 * c) / (1.0 + 0.55 * c)));
        [r, g, b, 255]
    })
}

struct Scene {
    seen: Raster,
    sight: Sight,
    sunlit: Raster,
    sun_sight: Sight,
}

impl Scene {
    /// Linear light of a point of the picture.
    fn light(&self, x: usize, y: usize) -> Vec3 {
        let (width, height) = (self.seen.width as f32, self.seen.height as f32);
        let right = ((x as f32 + 0.5) / width * 2.0 - 1.0) * self.sight.half.x;
        let up = (1.0 - (y as f32 + 0.5) / height * 2.0) * self.sight.half.y;
        let flat = self.sight.center + self.sight.right * right + self.sight.up * up;
        let toward = self.sight.toward();
        if let Some(surface) = self.seen.pixels[y * self.seen.width + x] {
            let at = flat + toward * surface.height;
            if at.y >= 0.0 {
                return self.shaded(&surface, at);
            }
        }
        // The ground, or the sky behind it.
        let distance = flat.y / toward.y;
        let at = flat - toward * distance;
        let reach = self.sun_sight.half.x * 1.1;
        let beyond = (at - self.sight.center).with_y(0.0).length() / reach;
        let ground = Surface {
            color: Vec3::new(0.16, 0.19, 0.09),
            normal: Vec3::Y,
            height: 0.0,
            transmission: 0.0,
        };
        let sky = Vec3::new(0.55, 0.72, 0.95) * mix(1.25, 0.9, y as f32 / height);
        self.shaded(&ground, at)
            .lerp(sky, ((beyond - 0.9) * 1.2).clamp(0.0, 1.0))
    }

    fn shaded(&self, surface: &Surface, at: Vec3) -> Vec3 {
        let sun = SUN.normalize();
        let facing = surface.normal.dot(sun);
        let direct = facing.max(0.0) + surface.transmission * 0.8 * (-facing).max(0.0);
        let sky = 0.36 + 0.24 * surface.normal.y;
        let lit = if self.in_sun(at) { 2.6 * direct } else { 0.0 };
        surface.color * (Vec3::new(1.0, 0.95, 0.84) * lit + Vec3::new(0.80, 0.92, 1.10) * sky)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked to be inside"
    )]
    fn in_sun(&self, at: Vec3) -> bool {
        let p = self.sun_sight.place(at);
        let half = self.sun_sight.half;
        let (u, v) = (0.5 + 0.5 * p.x / half.x, 0.5 - 0.5 * p.y / half.y);
        if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
            return true;
        }
        let (x, y) = ((u * SUN_POINTS as f32) as usize, (v * SUN_POINTS as f32) as usize);
        let bias = half.x * 0.006;
        self.sunlit.pixels[y * SUN_POINTS + x].is_none_or(|first| first.height < p.z + bias)
    }
}
