//! Impostors: many views of a model in one picture.
//!
//! Views stand on a hemi-octahedron, so that a shader finds the nearest ones without a search: a direction towards the
//! viewer d with d.y ≥ 0 is divided by |x| + |y| + |z|, and (x + z, z − x) of it runs over the square −1..=1. Each view
//! is a parallel projection onto a rectangle that holds the model from every side: colour with alpha; normals relative to
//! the view (x right, y up, z towards the viewer) with depth in alpha.
//!
//! For renderers without such a shader there is a mesh: four upright cards and a level one that show five of the views.

use bevy_math::{Vec2, Vec3};

use super::raster::{Raster, Sight};
use crate::forge::{
    mesh::{Lod, Material, Mesh, Model, Part, Vertex, Views},
    portable::srgb_code,
    texture::{
        canvas::spread_colors,
        picture::{Channels, Picture, quantised},
    },
};

/// Views per side.
pub const GRID: u32 = 5;
/// Texels of a view, about.
const VIEW_TEXELS: f32 = 6900.0;
/// Columns and rows of a view are multiples of this, so that mips of neighbours stay apart.
const BLOCK: f32 = 8.0;
/// Rasterised points per texel and axis.
const OVERSAMPLING: usize = 4;
/// Steps of channels in the file.
const COLOR_LEVELS: u32 = 40;
const NORMAL_LEVELS: u32 = 24;
const DEPTH_LEVELS: u32 = 24;
/// Alpha below this is not there.
const CUTOFF: f32 = 0.5;

/// The direction towards the viewer of a view, a unit vector.
pub fn direction(column: u32, row: u32) -> Vec3 {
    let last = (GRID - 1) as f32;
    let e = Vec2::new(column as f32, row as f32) / last * 2.0 - 1.0;
    let (x, z) = ((e.x - e.y) * 0.5, (e.x + e.y) * 0.5);
    Vec3::new(x, 1.0 - x.abs() - z.abs(), z).normalize()
}

/// A texel before it is rounded.
#[derive(Clone, Copy)]
struct Texel {
    color: Vec3,
    /// Relative to the view.
    normal: Vec3,
    /// −1 far to 1 near.
    depth: f32,
    /// Share of the texel that is covered.
    coverage: f32,
}

/// Bakes a level of detail of `model` into pictures and a material of `model`, and gives the level that shows them.
pub fn bake(model: &mut Model, lod: &Lod, name: &str) -> Lod {
    let (low, high) = lod.bounds().unwrap_or((Vec3::ZERO, Vec3::ONE));
    // Below the ground there is nothing to see.
    let low = low.with_y(low.y.max(0.0));
    let frame = Frame::around(low, high);
    let (width, height) = (frame.width * GRID as usize, frame.height * GRID as usize);
    let empty = Texel {
        color: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: -1.0,
        coverage: 0.0,
    };
    let mut texels = vec![empty; width * height];
    for row in 0..GRID {
        for column in 0..GRID {
            let view = view(model, lod, direction(column, row), &frame);
            for (i, texel) in view.into_iter().enumerate() {
                let x = column as usize * frame.width + i % frame.width;
                let y = row as usize * frame.height + i / frame.width;
                texels[y * width + x] = texel;
            }
        }
    }
    let [color, normal] = pictures(&texels, width, name);
    let (base_picture, normal_picture) = (model.add_picture(color), model.add_picture(normal));
    let material = model.add_material(Material {
        base_picture: Some(base_picture),
        normal_picture: Some(normal_picture),
        cutoff: Some(CUTOFF),
        views: Some(Views {
            grid: GRID,
            center: frame.center,
            half: frame.half,
            radius: frame.half.y,
        }),
        ..Material::plain(&format!("{name}_impostor"), [1.0; 3])
    });
    Lod {
        parts: vec![Part {
            mesh: cards(&frame),
            material,
        }],
        screen_coverage: 0.0,
    }
}

/// What all views of a model have in common.
struct Frame {
    center: Vec3,
    /// Half the width and height in metres.
    half: Vec2,
    /// Texels.
    width: usize,
    height: usize,
}

impl Frame {
    /// The frame that holds a box from every side.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small and positive"
    )]
    fn around(low: Vec3, high: Vec3) -> Self {
        let extent = high - low;
        let across = 0.5 * (extent.x * extent.x + extent.z * extent.z).sqrt();
        // From the side it is as high as the box, from above as high as it is wide, between them higher than both.
        let half = Vec2::new(across, 0.5 * extent.length()).max(Vec2::splat(1e-3));
        let ratio = (half.y / half.x).min(8.0);
        let blocks = |texels: f32| ((texels / BLOCK + 0.5).floor().max(1.0) * BLOCK) as usize;
        let width = blocks((VIEW_TEXELS / ratio).sqrt());
        Self {
            center: (low + high) * 0.5,
            half,
            width,
            height: blocks(VIEW_TEXELS / width as f32),
        }
    }
}

/// One view, with alpha that keeps its coverage under the test.
fn view(model: &Model, lod: &Lod, toward: Vec3, frame: &Frame) -> Vec<Texel> {
    let sight = Sight::from_direction(frame.center, toward, frame.half);
    let mut raster = Raster::new(frame.width * OVERSAMPLING, frame.height * OVERSAMPLING);
    raster.draw(model, lod, &sight);
    let mut texels: Vec<Texel> = (0..frame.width * frame.height)
        .map(|i| average(&raster, &sight, i % frame.width, i / frame.width))
        .collect();
    let covered: f32 = texels.iter().map(|texel| texel.coverage).sum();
    let mut coverages: Vec<f32> = texels.iter().map(|texel| texel.coverage).collect();
    coverages.sort_by(|a, b| b.total_cmp(a));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0..=number of texels"
    )]
    let border = coverages.get((covered + 0.5) as usize).copied().unwrap_or(0.0);
    if border > 0.0 {
        for texel in &mut texels {
            texel.coverage = (texel.coverage * CUTOFF / border).min(1.0);
        }
    }
    texels
}

fn average(raster: &Raster, sight: &Sight, x: usize, y: usize) -> Texel {
    let (mut color, mut normal, mut height, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0, 0.0);
    for i in 0..OVERSAMPLING * OVERSAMPLING {
        let (column, row) = (x * OVERSAMPLING + i % OVERSAMPLING, y * OVERSAMPLING + i / OVERSAMPLING);
        if let Some(surface) = raster.pixels[row * raster.width + column] {
            color += surface.color;
            normal += surface.normal;
            height += surface.height;
            count += 1.0;
        }
    }
    let share = 1.0 / f32::max(count, 1.0);
    let normal = normal.normalize_or_zero();
    Texel {
        color: color * share,
        normal: Vec3::new(
            normal.dot(sight.right),
            normal.dot(sight.up),
            normal.dot(sight.toward()),
        ),
        depth: if count > 0.0 {
            height * share / sight.half.y
        } else {
            -1.0
        },
        coverage: count / (OVERSAMPLING * OVERSAMPLING) as f32,
    }
}

/// Colour with alpha, and normals with depth.
fn pictures(texels: &[Texel], width: usize, name: &str) -> [Picture; 2] {
    let height = texels.len() / width;
    let mut colors: Vec<(Vec3, f32)> = texels.iter().map(|texel| (texel.color, texel.coverage)).collect();
    spread_colors(&mut colors, width);
    let mut normals: Vec<(Vec3, f32)> = texels.iter().map(|texel| (texel.normal, texel.coverage)).collect();
    spread_colors(&mut normals, width);
    let color = Picture::from_fn(&format!("{name}_views"), width, height, Channels::Rgba, |x, y| {
        let (color, alpha) = colors[y * width + x];
        let [r, g, b] = color
            .to_array()
            .map(|c| quantised(f32::from(srgb_code(c)) / 255.0, COLOR_LEVELS));
        [r, g, b, quantised(alpha, 16)]
    });
    // Normals and depth vary slowly: half the resolution.
    let normal_name = format!("{name}_view_normals");
    let normal = Picture::from_fn(&normal_name, width / 2, height / 2, Channels::Rgba, |x, y| {
        let (mut normal, mut depth) = (Vec3::ZERO, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let i = (2 * y + dy) * width + 2 * x + dx;
            normal += normals[i].0;
            depth += texels[i].depth * 0.25;
        }
        let normal = normal.normalize_or(Vec3::Z);
        let [r, g, b] = normal.to_array().map(|c| quantised(0.5 + 0.5 * c, NORMAL_LEVELS));
        [r, g, b, quantised(0.5 + 0.5 * depth, DEPTH_LEVELS)]
    });
    [color, normal]
}

/// Four upright cards through the axis of the trunk (x = z = 0), each with the view from its side, and a level one
/// through the centre, seen from above.
fn cards(frame: &Frame) -> Mesh {
    let (center, half) = (frame.center, frame.half);
    let last = GRID - 1;
    let views = [(last, 0), (last, last), (0, last), (0, 0), (last / 2, last / 2)];
    let mut mesh = Mesh {
        tangents: true,
        ..Mesh::default()
    };
    for (column, row) in views {
        let sight = Sight::from_direction(center, direction(column, row), half);
        // Trunks then meet where the cards cross.
        let toward = sight.toward();
        let onto_axis = if toward.y > 0.5 {
            Vec3::ZERO
        } else {
            -toward * center.dot(toward)
        };
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let u = (column as f32 + 0.5 + 0.5 * x) / GRID as f32;
            let v = (row as f32 + 0.5 - 0.5 * y) / GRID as f32;
            mesh.push(Vertex {
                position: center + onto_axis + sight.right * (x * half.x) + sight.up * (y * half.y),
                normal: sight.toward(),
                uv: Vec2::new(u, v),
                tangent: sight.right,
                shade: 1.0,
            })
        });
        mesh.push_quad(corners);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_stand_on_the_upper_half() {
        assert_eq!(direction(4, 0), Vec3::X);
        assert_eq!(direction(4, 4), Vec3::Z);
        assert_eq!(direction(0, 4), Vec3::NEG_X);
        assert_eq!(direction(0, 0), Vec3::NEG_Z);
        assert_eq!(direction(2, 2), Vec3::Y);
        for row in 0..GRID {
            for column in 0..GRID {
                assert!(direction(column, row).y >= 0.0);
            }
        }
    }

    #[test]
    fn a_box_looks_in_its_views_as_it_is() {
        // A green square of 2 m that faces +z, 1 m above the ground.
        let mut model = Model::default();
        let material = model.add_material(Material::plain("green", [0.0, 1.0, 0.0]));
        let mut mesh = Mesh::default();
        for (x, y) in [(-1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-1.0, 2.0)] {
            mesh.push(Vertex {
                position: Vec3::new(x, y, 0.0),
                normal: Vec3::Z,
                uv: Vec2::ZERO,
                tangent: Vec3::X,
                shade: 1.0,
            });
        }
        mesh.push_quad([0, 1, 2, 3]);
        let lod = Lod {
            parts: vec![Part { mesh, material }],
            screen_coverage: 0.0,
        };
        let impostor = bake(&mut model, &lod, "square");
        assert_eq!(impostor.triangle_count(), 10);
        let views = model.materials[1].views.expect("views");
        assert_eq!(views.center, Vec3::Y);
        assert!((views.half - Vec2::new(1.0, 2.0_f32.sqrt())).length() < 1e-6);
        // The view from +z is the lower right one; the square is as wide as it, and 1 / √2 as high.
        let [color, normal] = [&model.pictures[0], &model.pictures[1]];
        let (width, height) = (color.width / GRID as usize, color.height() / GRID as usize);
        assert!((width * height).abs_diff(6900) < 500);
        let texel =
            |picture: &Picture, x: usize, y: usize| picture.texels[(4 * height + y) * picture.width + 4 * width + x];
        let covered = (0..width * height)
            .filter(|i| texel(color, i % width, i / width)[3] >= 128)
            .count();
        let share = covered as f32 / (width * height) as f32;
        assert!((share - 0.5_f32.sqrt()).abs() < 0.02, "{share}");
        assert_eq!(texel(color, width / 2, height / 2), [0, 255, 0, 255]);
        let [x, y, z, depth] = normal.nearest(Vec2::splat(0.9)).expect("a texel");
        assert!(x.abs_diff(128) < 9 && y.abs_diff(128) < 9 && z == 255 && depth.abs_diff(128) < 9);
        // From −z one looks at its back, which is not there.
        assert!(color.texels[..width].iter().all(|texel| texel[3] == 0));
    }
}
