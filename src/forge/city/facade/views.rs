//! The picture of all façades: what is painted, and the far views of bays, rendered from their near shapes.

use bevy_math::{Vec2, Vec3};

use super::{atlas, bays, kit, paint};
use crate::forge::{
    bake::raster::{Raster, Sight},
    mesh::{Lod, Material, Mesh, Model, Part},
    portable::srgb_code,
    texture::picture::{Channels, Picture, quantised},
};

/// Steps per colour channel in the file.
const COLOR_LEVELS: u32 = 52;
/// Points per texel and axis of a far view.
const OVERSAMPLING: usize = 3;
/// So many points below an edge are in its shade.
const SHADE_POINTS: usize = 9;

/// Paints and renders the picture.
pub fn picture() -> Picture {
    let mut light = paint::painting();
    let mut model = Model::default();
    let base_picture = Some(model.add_picture(coded(&light)));
    model.add_material(Material {
        base_picture,
        ..Material::plain("painting", [1.0; 3])
    });
    for (index, (style, storey, bay)) in kit().into_iter().enumerate() {
        let mesh = bays::front(style, storey, bay).mesh;
        view(
            &model,
            mesh,
            (style.bay(), storey.reach()),
            atlas::view(index),
            &mut light,
        );
    }
    coded(&light)
}

/// Linear light as sRGB codes.
fn coded(light: &[Vec3]) -> Picture {
    Picture::from_fn("facades", atlas::WIDTH, atlas::HEIGHT, Channels::Rgb, |x, y| {
        let [r, g, b] = light[y * atlas::WIDTH + x]
            .to_array()
            .map(|c| quantised(f32::from(srgb_code(c)) / 255.0, COLOR_LEVELS));
        [r, g, b, 255]
    })
}

/// Renders the front of a bay into a cell.
fn view(model: &Model, mesh: Mesh, (width, (low, high)): (f32, (f32, f32)), cell: atlas::Cell, light: &mut [Vec3]) {
    let half = Vec2::new(width, high - low) * 0.5;
    let sight = Sight::from_direction(Vec3::new(half.x, low + half.y, 0.0), Vec3::Z, half);
    let (columns, rows) = (cell.columns * OVERSAMPLING, cell.rows * OVERSAMPLING);
    let mut seen = Raster::new(columns, rows);
    let part = Part { mesh, material: 0 };
    let lod = Lod {
        parts: vec![part],
        screen_coverage: 0.0,
    };
    seen.draw(model, &lod, &sight);
    let at = |x: usize, y: usize| {
        let Some(surface) = seen.pixels[y * columns + x] else {
            return Vec3::ZERO;
        };
        // What stands out above keeps the sky off.
        let above = (1..=SHADE_POINTS.min(y)).filter_map(|k| seen.pixels[(y - k) * columns + x]);
        let deepest = above.map(|other| other.height - surface.height).fold(0.0, f32::max);
        surface.color * (1.0 - 0.45 * (deepest * 4.0).min(1.0))
    };
    for y in 0..cell.rows {
        for x in 0..cell.columns {
            let points = (0..OVERSAMPLING * OVERSAMPLING)
                .map(|i| at(x * OVERSAMPLING + i % OVERSAMPLING, y * OVERSAMPLING + i / OVERSAMPLING));
            light[(cell.top + y) * atlas::WIDTH + cell.left + x] =
                points.sum::<Vec3>() / (OVERSAMPLING * OVERSAMPLING) as f32;
        }
    }
}
