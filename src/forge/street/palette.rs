//! The picture that all street models share: plain colours, signs, prints.
//!
//! Faces with a plain colour have one texture coordinate, so that filters never mix in a neighbour.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    portable::{smooth, srgb_code},
    texture::{
        noise::octaves,
        picture::{Channels, Picture},
    },
};

/// Texels per side.
const SIDE: usize = 256;
/// Texels per side of a plain colour.
const CELL: usize = 16;

/// Centre of a plain colour.
const fn swatch(index: usize) -> Vec2 {
    let (column, row) = (index % 16, index / 16);
    let cell = CELL as f32 / SIDE as f32;
    Vec2::new((column as f32 + 0.5) * cell, (row as f32 + 0.5) * cell)
}

/// Linear colours in the order of their constants.
const COLORS: [[f32; 3]; 32] = [
    [0.022, 0.026, 0.024],
    [0.30, 0.31, 0.32],
    [0.115, 0.12, 0.125],
    [0.235, 0.140, 0.072],
    [0.195, 0.112, 0.058],
    [0.275, 0.170, 0.092],
    [0.36, 0.35, 0.33],
    [0.42, 0.40, 0.365],
    [0.27, 0.255, 0.23],
    [0.50, 0.028, 0.020],
    [0.020, 0.070, 0.300],
    [0.760, 0.510, 0.020],
    [0.76, 0.76, 0.74],
    [0.016, 0.016, 0.017],
    [0.024, 0.024, 0.025],
    [0.030, 0.042, 0.050],
    [0.86, 0.80, 0.64],
    [0.018, 0.090, 0.050],
    [0.270, 0.115, 0.068],
    [0.035, 0.110, 0.120],
    [0.200, 0.360, 0.300],
    [0.55, 0.020, 0.016],
    [0.72, 0.30, 0.02],
    [0.125, 0.090, 0.050],
    [0.66, 0.58, 0.42],
    [0.54, 0.55, 0.56],
    [0.050, 0.34, 0.10],
    [0.205, 0.085, 0.055],
    [0.105, 0.066, 0.038],
    [0.060, 0.036, 0.022],
    [0.145, 0.085, 0.050],
    [0.020, 0.022, 0.05],
];

/// Painted cast iron, nearly black.
pub(super) const IRON: Vec2 = swatch(0);
/// Bare steel.
pub(super) const STEEL: Vec2 = swatch(1);
/// Dark painted steel.
pub(super) const DARK_STEEL: Vec2 = swatch(2);
/// Boards in three tones.
pub(super) const WOODS: [Vec2; 3] = [swatch(3), swatch(4), swatch(5)];
/// Concrete.
pub(super) const CONCRETE: Vec2 = swatch(6);
/// Pale stone.
pub(super) const STONE: Vec2 = swatch(7);
/// Dark stone.
pub(super) const DARK_STONE: Vec2 = swatch(8);
/// Signal red.
pub(super) const RED: Vec2 = swatch(9);
/// Traffic blue.
pub(super) const BLUE: Vec2 = swatch(10);
/// Traffic yellow.
pub(super) const YELLOW: Vec2 = swatch(11);
/// White paint.
pub(super) const WHITE: Vec2 = swatch(12);
/// Black.
pub(super) const BLACK: Vec2 = swatch(13);
/// Tyres.
pub(super) const RUBBER: Vec2 = swatch(14);
/// Window glass from outside.
pub(super) const GLASS: Vec2 = swatch(15);
/// Frosted glass of a lamp.
pub(super) const LAMP: Vec2 = swatch(16);
/// Bottle green paint.
pub(super) const GREEN: Vec2 = swatch(17);
/// Brown-red paint of the tower.
pub(super) const TOWER: Vec2 = swatch(18);
/// Water in a basin.
pub(super) const WATER: Vec2 = swatch(19);
/// A red lamp.
pub(super) const RED_LAMP: Vec2 = swatch(21);
/// An amber lamp.
pub(super) const AMBER_LAMP: Vec2 = swatch(22);
/// Bronze.
pub(super) const BRONZE: Vec2 = swatch(23);
/// Cream paint.
pub(super) const CREAM: Vec2 = swatch(24);
/// Polished metal.
pub(super) const CHROME: Vec2 = swatch(25);
/// A green lamp.
pub(super) const GREEN_LAMP: Vec2 = swatch(26);
/// Fired clay.
pub(super) const CLAY: Vec2 = swatch(27);
/// Old logs, their ends, shingles.
pub(super) const LOGS: [Vec2; 3] = [swatch(28), swatch(29), swatch(30)];

/// A piece of the picture: lower left and upper right corner.
pub(super) type Piece = (Vec2, Vec2);

/// Pieces are squares of 64 texels in the lower three quarters.
const fn piece(column: usize, row: usize) -> Piece {
    let side = 64.0 / SIDE as f32;
    let inset = 0.5 / SIDE as f32;
    let (left, top) = (column as f32 * side, (row + 1) as f32 * side);
    (
        Vec2::new(left + inset, top + side - inset),
        Vec2::new(left + side - inset, top + inset),
    )
}

/// Front pages in rows.
pub(super) const PAPERS: Piece = piece(0, 0);
/// A poster.
pub(super) const POSTER: Piece = piece(1, 0);
/// Another poster.
pub(super) const PLACARD: Piece = piece(2, 0);
/// Stripes of an awning.
pub(super) const AWNING: Piece = piece(3, 0);
/// No parking.
pub(super) const NO_PARKING: Piece = piece(0, 1);
/// Priority road.
pub(super) const PRIORITY: Piece = piece(1, 1);
/// Pedestrian crossing.
pub(super) const CROSSING: Piece = piece(2, 1);
/// A street name, white on blue.
pub(super) const STREET_NAME: Piece = piece(3, 1);
/// A tram stop.
pub(super) const STOP: Piece = piece(0, 2);
/// A number plate.
pub(super) const PLATE: Piece = piece(1, 2);

/// The whole picture.
pub(super) fn picture() -> Picture {
    Picture::from_fn("street", SIDE, SIDE, Channels::Rgb, |x, y| {
        let color = if y < 64 {
            let index = y / CELL * 16 + x / CELL;
            COLORS.get(index).copied().map_or(Vec3::splat(0.5), Vec3::from)
        } else {
            let within = Vec2::new((x % 64) as f32 + 0.5, (y % 64) as f32 + 0.5) / 64.0;
            print((x / 64, y / 64 - 1), within)
        };
        let [r, g, b] = color.to_array().map(srgb_code);
        [r, g, b, 255]
    })
}

/// What a piece shows at a point, 0..1, y down.
fn print(piece: (usize, usize), p: Vec2) -> Vec3 {
    let white = Vec3::new(0.76, 0.76, 0.73);
    let blue = Vec3::new(0.02, 0.08, 0.34);
    let red = Vec3::new(0.55, 0.025, 0.02);
    let black = Vec3::splat(0.02);
    let centered = p - 0.5;
    match piece {
        (0, 0) => papers(p),
        (1, 0) => {
            let sun = (p - Vec2::new(0.62, 0.34)).length() < 0.2;
            let hill = p.y > 0.62 + 0.1 * octaves(501, Vec2::new(p.x, 0.3), (4, 4), 2);
            let text = p.y > 0.82 && p.y < 0.9 && (0.15..0.85).contains(&p.x);
            if text {
                white
            } else if hill {
                Vec3::new(0.03, 0.10, 0.13)
            } else if sun {
                Vec3::new(0.80, 0.42, 0.06)
            } else {
                Vec3::new(0.62, 0.20, 0.09).lerp(Vec3::new(0.75, 0.55, 0.3), p.y)
            }
        }
        (2, 0) => {
            let ring = (centered + Vec2::new(0.0, 0.1)).length();
            let words = p.y > 0.75 && p.y < 0.93 && (p.y * 11.0).fract() < 0.55 && (0.12..0.88).contains(&p.x);
            if words || (0.18..0.27).contains(&ring) {
                Vec3::new(0.02, 0.05, 0.10)
            } else {
                Vec3::new(0.70, 0.62, 0.40)
            }
        }
        (3, 0) => {
            if (p.x * 4.0).fract() < 0.5 {
                white
            } else {
                Vec3::new(0.45, 0.03, 0.03)
            }
        }
        (0, 1) => {
            let r = centered.length();
            let bar = (centered.x - centered.y).abs() < 0.06;
            if r > 0.38 || bar { red } else { blue }
        }
        (1, 1) => {
            let diamond = centered.x.abs() + centered.y.abs();
            if diamond < 0.33 {
                Vec3::new(0.78, 0.55, 0.02)
            } else if diamond < 0.46 {
                white
            } else {
                black
            }
        }
        (2, 1) => {
            let triangle = p.y > 0.18 && p.y < 0.82 && centered.x.abs() < 0.55 * (p.y - 0.18) + 0.02;
            let walker = (centered - Vec2::new(0.0, -0.08)).length() < 0.05
                || (centered.x.abs() < 0.035 && (0.46..0.62).contains(&p.y))
                || ((centered.x.abs() - (p.y - 0.6) * 0.6).abs() < 0.025 && (0.6..0.76).contains(&p.y));
            if triangle && walker {
                black
            } else if triangle {
                white
            } else {
                blue
            }
        }
        (3, 1) => {
            let letters = (0.38..0.62).contains(&p.y)
                && (0.1..0.9).contains(&p.x)
                && octaves(502, Vec2::new(p.x, 0.25 * p.y), (22, 8), 1).abs() > 0.08;
            let rim = centered.abs().max_element() > 0.46;
            if letters || rim { white } else { blue }
        }
        (0, 2) => {
            let r = centered.length();
            let tram = centered.x.abs() < 0.16 && (-0.22..0.18).contains(&centered.y);
            let window = centered.x.abs() < 0.11 && (-0.15..-0.02).contains(&centered.y);
            if tram && !window {
                Vec3::new(0.02, 0.25, 0.08)
            } else if r < 0.42 {
                Vec3::new(0.78, 0.60, 0.05)
            } else {
                Vec3::new(0.02, 0.25, 0.08)
            }
        }
        (1, 2) => {
            let letters = (0.25..0.75).contains(&p.y)
                && (0.16..0.94).contains(&p.x)
                && octaves(503, Vec2::new(p.x, 0.2 * p.y), (16, 6), 1).abs() > 0.1;
            if p.x < 0.1 {
                blue
            } else if letters {
                black
            } else {
                white
            }
        }
        _ => Vec3::splat(0.5),
    }
}

/// Rows of front pages: a headline, a picture, columns of text.
fn papers(p: Vec2) -> Vec3 {
    let cell = (p * Vec2::new(4.0, 3.0)).floor();
    let q = p * Vec2::new(4.0, 3.0) - cell;
    let hue = octaves(504, (cell + 0.5) / 4.0 + 0.1, (4, 4), 1);
    let inside = (0.08..0.92).contains(&q.x) && (0.06..0.94).contains(&q.y);
    if !inside {
        return Vec3::splat(0.05);
    }
    if q.y < 0.24 {
        return Vec3::new(0.5, 0.05, 0.04).lerp(Vec3::new(0.03, 0.06, 0.25), smooth(-0.2, 0.2, hue));
    }
    if q.y < 0.6 && q.x > 0.3 {
        return Vec3::new(0.25, 0.2, 0.15) * (1.0 + hue);
    }
    if (q.y * 14.0).fract() < 0.5 {
        Vec3::splat(0.28)
    } else {
        Vec3::splat(0.62)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_point_at_their_colors() {
        let picture = picture();
        for (at, color) in [(IRON, COLORS[0]), (TOWER, COLORS[18]), (LOGS[2], COLORS[30])] {
            let [r, g, b, _] = picture.nearest(at).expect("a texel");
            assert_eq!([r, g, b], color.map(srgb_code));
        }
    }

    #[test]
    fn pieces_show_what_they_are_called() {
        let picture = picture();
        let texel = |(low, high): Piece, x: f32, y: f32| {
            let [r, g, b, _] = picture.nearest(low + (high - low) * Vec2::new(x, y)).expect("a texel");
            [r, g, b]
        };
        let [r, _, b] = texel(NO_PARKING, 0.5, 0.72);
        assert!(b > r, "blue between red ring and bar");
        let [r, _, b] = texel(NO_PARKING, 0.5, 0.95);
        assert!(r > b, "a red ring");
        // The blue band of a plate is at its left.
        let [r, _, b] = texel(PLATE, 0.03, 0.5);
        assert!(b > r);
    }
}
