//! A square tile of ground that is being laid: relief and colour, without seams at its edges.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    portable::{mix, smooth, srgb_code},
    texture::picture::{Channels, Picture},
};

/// Texels per side.
pub(super) const SIDE: usize = 512;

/// A place on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Metres.
    pub(super) height: f32,
    /// Linear colour.
    pub(super) color: Vec3,
}

/// A tile: [`SIDE`] × [`SIDE`] places.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    /// Width in metres.
    pub(super) width: f32,
    places: Vec<Place>,
}

impl Sheet {
    /// A tile `width` metres wide whose places come from their position, 0..1 in both directions, y down.
    pub(super) fn new(width: f32, place: impl Fn(Vec2) -> Place) -> Self {
        let at = |i: usize| Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) / SIDE as f32;
        Self {
            width,
            places: (0..SIDE * SIDE).map(|i| place(at(i))).collect(),
        }
    }

    fn index(x: i64, y: i64) -> usize {
        let side = SIDE as i64;
        usize::try_from(y.rem_euclid(side) * side + x.rem_euclid(side)).unwrap_or(0)
    }

    /// The place nearest to a point in metres; the tile repeats.
    #[expect(clippy::cast_possible_truncation, reason = "texels of a tile")]
    pub(super) fn at(&self, p: Vec2) -> Place {
        let texel = (p * (SIDE as f32 / self.width)).round();
        self.places[Self::index(texel.x as i64, texel.y as i64)]
    }

    /// Calls `paint` for all places within `reach` metres of `center` with their offset from it in metres and what is
    /// there; keeps what it returns.
    #[expect(clippy::cast_possible_truncation, reason = "texels of a tile")]
    pub(super) fn paint(&mut self, center: Vec2, reach: f32, paint: impl Fn(Vec2, Place) -> Place) {
        let texel = self.width / SIDE as f32;
        let (low, high) = (((center - reach) / texel).ceil(), ((center + reach) / texel).floor());
        for y in low.y as i64..=high.y as i64 {
            for x in low.x as i64..=high.x as i64 {
                let place = &mut self.places[Self::index(x, y)];
                *place = paint(Vec2::new(x as f32, y as f32) * texel - center, *place);
            }
        }
    }

    /// A thin round thing that lies on the ground: a twig, a needle, a blade. It tapers from `radii.0` to `radii.1`
    /// metres and blends from the first to the second colour.
    pub(super) fn stroke(&mut self, from: Vec2, to: Vec2, radii: (f32, f32), lift: f32, colors: (Vec3, Vec3)) {
        let middle = 0.5 * (from + to);
        let along = to - from;
        let length_squared = along.length_squared().max(1e-12);
        let soft = 0.6 * self.width / SIDE as f32;
        let reach = 0.5 * length_squared.sqrt() + radii.0.max(radii.1) + soft;
        self.paint(middle, reach, |offset, there| {
            let p = offset + middle - from;
            let t = (p.dot(along) / length_squared).clamp(0.0, 1.0);
            let radius = mix(radii.0, radii.1, t);
            let off = (p - along * t).length();
            let cover = smooth(radius + soft, (radius - soft).max(0.0), off);
            if cover <= 0.0 {
                return there;
            }
            let round = (1.0 - (off / (radius + soft)) * (off / (radius + soft)))
                .max(0.0)
                .sqrt();
            let color = colors.0.lerp(colors.1, t) * mix(0.55, 1.0, round);
            Place {
                height: mix(there.height, there.height + lift + radius * round, cover),
                color: there.color.lerp(color, cover),
            }
        });
    }

    /// Colour and, at half the resolution, normals, in this order. Hollows are darker: less sky reaches them.
    pub(super) fn pictures(&self, name: &str) -> [Picture; 2] {
        let high = |x: usize, y: usize, dx: i64, dy: i64| self.places[Self::index(x as i64 + dx, y as i64 + dy)].height;
        let texel = self.width / SIDE as f32;
        let color = Picture::from_fn(name, SIDE, SIDE, Channels::RgbJpeg, |x, y| {
            let place = self.places[y * SIDE + x];
            let around: f32 = RING.iter().map(|(dx, dy)| high(x, y, *dx, *dy)).sum();
            let depth = (around / RING.len() as f32 - place.height) / (3.0 * texel);
            let open = 1.0 - 0.45 * smooth(0.0, 1.0, depth);
            let [r, g, b] = (place.color * open).to_array().map(srgb_code);
            [r, g, b, 255]
        });
        let normal_name = format!("{name}_normal");
        let normal = Picture::from_fn(&normal_name, SIDE / 2, SIDE / 2, Channels::RgbJpeg, |x, y| {
            // Slopes over two texels of the colour, which lie under one of the normals.
            let (x, y) = (2 * x, 2 * y);
            let across = high(x, y, 1, 0) + high(x, y, 1, 1) - high(x, y, -1, 0) - high(x, y, -1, 1)
                + high(x, y, 2, 0)
                + high(x, y, 2, 1)
                - high(x, y, 0, 0)
                - high(x, y, 0, 1);
            let down = high(x, y, 0, 1) + high(x, y, 1, 1) - high(x, y, 0, -1) - high(x, y, 1, -1)
                + high(x, y, 0, 2)
                + high(x, y, 1, 2)
                - high(x, y, 0, 0)
                - high(x, y, 1, 0);
            let slope = Vec2::new(-across, down) / (8.0 * texel);
            // Steep edges of leaves and stones would only glitter.
            let slope = slope / (1.0 + 0.5 * slope.length());
            let normal = slope.extend(1.0).normalize();
            let [x, y, z] = normal.to_array().map(code);
            [x, y, z, 255]
        });
        [color, normal]
    }
}

/// Texels around one, for its share of sky.
const RING: [(i64, i64); 8] = [(4, 0), (3, 3), (0, 4), (-3, 3), (-4, 0), (-3, -3), (0, -4), (3, -3)];

/// −1..=1 as 8 bits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=255"
)]
fn code(component: f32) -> u8 {
    ((0.5 + 0.5 * component) * 255.0 + 0.5).clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat() -> Sheet {
        Sheet::new(2.0, |_| Place {
            height: 0.0,
            color: Vec3::splat(0.2),
        })
    }

    #[test]
    fn what_is_painted_at_an_edge_goes_on_at_the_other() {
        let mut sheet = flat();
        sheet.paint(Vec2::new(0.0, 1.0), 0.1, |offset, there| Place {
            height: 0.1 - offset.length(),
            ..there
        });
        assert!(sheet.at(Vec2::new(1.95, 1.0)).height > 0.04);
        assert!(sheet.at(Vec2::new(0.05, 1.0)).height > 0.04);
        assert_eq!(sheet.at(Vec2::new(1.0, 1.0)).height, 0.0);
    }

    #[test]
    fn a_stroke_covers_its_width_and_no_more() {
        let mut sheet = flat();
        let red = Vec3::new(0.8, 0.0, 0.0);
        sheet.stroke(Vec2::splat(0.5), Vec2::new(1.5, 0.5), (0.03, 0.03), 0.0, (red, red));
        assert!(sheet.at(Vec2::new(1.0, 0.5)).color.x > 0.7);
        assert!(sheet.at(Vec2::new(1.0, 0.522)).color.x > 0.3);
        assert_eq!(sheet.at(Vec2::new(1.0, 0.54)).color.x, 0.2);
        assert_eq!(sheet.at(Vec2::new(1.6, 0.5)).color.x, 0.2);
    }

    #[test]
    fn a_slope_to_the_right_leans_to_the_left() {
        // 45° between two level halves; the limit of slopes makes tan = 1 / 1.5.
        let ramp = Sheet::new(1.0, |p| Place {
            height: p.x.clamp(0.25, 0.75),
            color: Vec3::ONE,
        });
        let [_, normal] = ramp.pictures("ramp");
        let [x, y, z, _] = normal.texels[50 * SIDE / 2 + 128];
        // (−0.555, 0, 0.832) in steps of 1/127.5.
        assert!(
            x.abs_diff(57) <= 1 && y.abs_diff(128) <= 1 && z.abs_diff(234) <= 1,
            "{x} {y} {z}"
        );
        assert!(normal.texels[50 * SIDE / 2 + 25][2] >= 254);
    }
}
