//! Impostors: many views of a model in one picture.
//!
//! Views stand on a hemi-octahedron, so that a shader finds the nearest ones without a search: a direction towards the
//! viewer d with d.y ≥ 0 is divided by |x| + |y| + |z|, and (x + z, z − x) of it runs over the square −1..=1. Each view
//! is a parallel projection onto a square of twice the radius: colour with alpha; normals relative to the view (x right,
//! y up, z towards the viewer) with depth in alpha.
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
/// Texels per side of a view.
const VIEW_TEXELS: usize = 96;
/// Rasterised points per texel and axis.
const OVERSAMPLING: usize = 4;
/// Steps of channels in the file.
const COLOR_LEVELS: u32 = 40;
const NORMAL_LEVELS: u32 = 24;
const DEPTH_LEVELS: u32 = 32;
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
    let center = (low + high) * 0.5;
    let radius = (high - low).length() * 0.5;
    let side = VIEW_TEXELS * GRID as usize;
    let empty = Texel {
        color: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: -1.0,
        coverage: 0.0,
    };
    let mut texels = vec![empty; side * side];
    for row in 0..GRID {
        for column in 0..GRID {
            let view = view(model, lod, direction(column, row), center, radius);
            for (i, texel) in view.into_iter().enumerate() {
                let x = column as usize * VIEW_TEXELS + i % VIEW_TEXELS;
                let y = row as usize * VIEW_TEXELS + i / VIEW_TEXELS;
                texels[y * side + x] = texel;
            }
        }
    }
    let [color, normal] = pictures(&texels, side, name);
    let (base_picture, normal_picture) = (model.add_picture(color), model.add_picture(normal));
    let material = model.add_material(Material {
        base_picture: Some(base_picture),
        normal_picture: Some(normal_picture),
        cutoff: Some(CUTOFF),
        views: Some(Views {
            grid: GRID,
            center,
            radius,
        }),
        ..Material::plain(&format!("{name}_impostor"), [1.0; 3])
    });
    Lod {
        parts: vec![Part {
            mesh: cards(center, radius),
            material,
        }],
        screen_coverage: 0.0,
    }
}

/// One view, with alpha that keeps its coverage under the test.
fn view(model: &Model, lod: &Lod, toward: Vec3, center: Vec3, radius: f32) -> Vec<Texel> {
    let points = VIEW_TEXELS * OVERSAMPLING;
    let sight = Sight::from_direction(center, toward, Vec2::splat(radius));
    let mut raster = Raster::new(points, points);
    raster.draw(model, lod, &sight);
    let mut texels: Vec<Texel> = (0..VIEW_TEXELS * VIEW_TEXELS)
        .map(|i| average(&raster, &sight, i % VIEW_TEXELS, i / VIEW_TEXELS, radius))
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

fn average(raster: &Raster, sight: &Sight, x: usize, y: usize, radius: f32) -> Texel {
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
        depth: if count > 0.0 { height * share / radius } else { -1.0 },
        coverage: count / (OVERSAMPLING * OVERSAMPLING) as f32,
    }
}

/// Colour with alpha, and normals with depth.
fn pictures(texels: &[Texel], side: usize, name: &str) -> [Picture; 2] {
    let mut colors: Vec<(Vec3, f32)> = texels.iter().map(|texel| (texel.color, texel.coverage)).collect();
    spread_colors(&mut colors, side);
    let mut normals: Vec<(Vec3, f32)> = texels.iter().map(|texel| (texel.normal, texel.coverage)).collect();
    spread_colors(&mut normals, side);
    let color = Picture::from_fn(&format!("{name}_views"), side, side, Channels::Rgba, |x, y| {
        let (color, alpha) = colors[y * side + x];
        let [r, g, b] = color
            .to_array()
            .map(|c| quantised(f32::from(srgb_code(c)) / 255.0, COLOR_LEVELS));
        [r, g, b, quantised(alpha, 16)]
    });
    let normal = Picture::from_fn(&format!("{name}_view_normals"), side, side, Channels::Rgba, |x, y| {
        let i = y * side + x;
        let [r, g, b] = normals[i].0.to_array().map(|c| quantised(0.5 + 0.5 * c, NORMAL_LEVELS));
        [r, g, b, quantised(0.5 + 0.5 * texels[i].depth, DEPTH_LEVELS)]
    });
    [color, normal]
}

/// Four upright cards through the centre, each with the view from its side, and a level one seen from above.
fn cards(center: Vec3, radius: f32) -> Mesh {
    let last = GRID - 1;
    let views = [(last, 0), (last, last), (0, last), (0, 0), (last / 2, last / 2)];
    let mut mesh = Mesh {
        tangents: true,
        ..Mesh::default()
    };
    for (column, row) in views {
        let sight = Sight::from_direction(center, direction(column, row), Vec2::splat(radius));
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let u = (column as f32 + 0.5 + 0.5 * x) / GRID as f32;
            let v = (row as f32 + 0.5 - 0.5 * y) / GRID as f32;
            mesh.push(Vertex {
                position: center + (sight.right * x + sight.up * y) * radius,
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
        assert!((views.radius - 2.0_f32.sqrt()).abs() < 1e-6);
        // The view from +z is the lower right one; the square covers half of its area.
        let [color, normal] = [&model.pictures[0], &model.pictures[1]];
        let last = (GRID as usize - 1) * VIEW_TEXELS;
        let texel = |picture: &Picture, x: usize, y: usize| picture.texels[(last + y) * picture.width + last + x];
        let covered = (0..VIEW_TEXELS * VIEW_TEXELS)
            .filter(|i| texel(color, i % VIEW_TEXELS, i / VIEW_TEXELS)[3] >= 128)
            .count();
        let share = covered as f32 / (VIEW_TEXELS * VIEW_TEXELS) as f32;
        assert!((share - 0.5).abs() < 0.02, "{share}");
        assert_eq!(texel(color, 48, 48), [0, 255, 0, 255]);
        let [x, y, z, depth] = texel(normal, 48, 48);
        assert!(x.abs_diff(128) < 8 && y.abs_diff(128) < 8 && z == 255 && depth.abs_diff(128) < 6);
        // From −z one looks at its back, which is not there.
        assert!(color.texels[..VIEW_TEXELS].iter().all(|texel| texel[3] == 0));
    }
}
