//! A small rasteriser: parallel projection, depth test, alpha test. No light: it gives what the surfaces are.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    mesh::{Lod, Model, Part, Vertex},
    portable::linear_light,
};

/// Where one looks from: a parallel projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// What is in the middle of the picture, in metres.
    pub center: Vec3,
    /// To the right in the picture, a unit vector.
    pub right: Vec3,
    /// Upward in the picture, a unit vector.
    pub up: Vec3,
    /// Metres from the middle to the right and upper border.
    pub half: Vec2,
}

impl Sight {
    /// From a direction (a unit vector towards the viewer), upright.
    pub fn from_direction(center: Vec3, toward: Vec3, half: Vec2) -> Self {
        let right = if toward.y.abs() > 0.9999 {
            Vec3::X
        } else {
            Vec3::Y.cross(toward).normalize()
        };
        Self {
            center,
            right,
            up: toward.cross(right),
            half,
        }
    }

    /// Towards the viewer, a unit vector.
    pub fn toward(&self) -> Vec3 {
        self.right.cross(self.up)
    }

    /// Right, up and towards the viewer: metres from the middle of the picture.
    pub fn place(&self, p: Vec3) -> Vec3 {
        let from = p - self.center;
        Vec3::new(from.dot(self.right), from.dot(self.up), from.dot(self.toward()))
    }
}

/// The nearest surface in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear base colour, shade included.
    pub color: Vec3,
    /// Unit vector on the viewer's side of the surface.
    pub normal: Vec3,
    /// Metres towards the viewer from the middle of the picture.
    pub height: f32,
    /// Share of light that shines through.
    pub transmission: f32,
}

/// Surfaces in pixels, row 0 on top.
#[derive(Clone, Debug)]
pub struct Raster {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row.
    pub pixels: Vec<Option<Surface>>,
}

impl Raster {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            pixels: vec![None; width * height],
        }
    }

    /// Draws all parts of a level of detail.
    pub fn draw(&mut self, model: &Model, lod: &Lod, sight: &Sight) {
        let light: Vec<f32> = (0..=255).map(linear_light).collect();
        for part in &lod.parts {
            self.draw_part(model, part, sight, &light);
        }
    }

    fn draw_part(&mut self, model: &Model, part: &Part, sight: &Sight, light: &[f32]) {
        let Some(material) = model.materials.get(part.material) else {
            return;
        };
        let picture_of = |picture: Option<usize>| picture.and_then(|i| model.pictures.get(i));
        let base = picture_of(material.base_picture);
        let normals = picture_of(material.normal_picture).filter(|_| part.mesh.tangents);
        let toward = sight.toward();
        for corners in part.mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| part.mesh.vertices[corners[i] as usize]);
            self.draw_triangle([a, b, c], sight, |weights| {
                let blend3 =
                    |pick: fn(&Vertex) -> Vec3| pick(&a) * weights.x + pick(&b) * weights.y + pick(&c) * weights.z;
                let front = (b.position - a.position).cross(c.position - a.position).dot(toward) > 0.0;
                if !front && !material.double_sided {
                    return None;
                }
                let uv = a.uv * weights.x + b.uv * weights.y + c.uv * weights.z;
                let texel = base.and_then(|picture| picture.nearest(uv)).unwrap_or([255; 4]);
                if material
                    .cutoff
                    .is_some_and(|cutoff| f32::from(texel[3]) < cutoff * 255.0)
                {
                    return None;
                }
                let mut normal = blend3(|v| v.normal).normalize_or(Vec3::Y);
                if let Some(texel) = normals.and_then(|picture| picture.nearest(uv)) {
                    let tangent = blend3(|v| v.tangent).normalize_or(Vec3::X);
                    let [x, y, z] = [0, 1, 2].map(|i| f32::from(texel[i]) / 127.5 - 1.0);
                    normal = (tangent * x + normal.cross(tangent) * y + normal * z).normalize_or(normal);
                }
                let shade = if part.mesh.shades {
                    a.shade * weights.x + b.shade * weights.y + c.shade * weights.z
                } else {
                    1.0
                };
                let [red, green, blue] = [0, 1, 2].map(|i| light[usize::from(texel[i])]);
                Some(Surface {
                    color: Vec3::new(red, green, blue) * Vec3::from(material.base_color) * shade,
                    normal: if front { normal } else { -normal },
                    height: 0.0,
                    transmission: material.leaf.map_or(0.0, |leaf| leaf.transmission),
                })
            });
        }
    }

    /// Visits the pixels whose middle is inside a triangle; `surface` gets the corners' weights there.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the picture"
    )]
    fn draw_triangle(&mut self, corners: [Vertex; 3], sight: &Sight, surface: impl Fn(Vec3) -> Option<Surface>) {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let places = corners.map(|vertex| sight.place(vertex.position));
        let [a, b, c] =
            places.map(|p| Vec2::new(0.5 + 0.5 * p.x / sight.half.x, 0.5 - 0.5 * p.y / sight.half.y) * size);
        let area = (b - a).perp_dot(c - a);
        if area.abs() < 1e-9 {
            return;
        }
        let low = a.min(b).min(c).clamp(Vec2::ZERO, size);
        let high = a.max(b).max(c).clamp(Vec2::ZERO, size);
        for y in low.y as usize..(high.y.ceil() as usize).min(self.height) {
            for x in low.x as usize..(high.x.ceil() as usize).min(self.width) {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let weights = Vec3::new(
                    (b - p).perp_dot(c - p),
                    (c - p).perp_dot(a - p),
                    (a - p).perp_dot(b - p),
                ) / area;
                if weights.min_element() < 0.0 {
                    continue;
                }
                let height = weights.dot(Vec3::new(places[0].z, places[1].z, places[2].z));
                let pixel = &mut self.pixels[y * self.width + x];
                if pixel.is_some_and(|there| there.height >= height) {
                    continue;
                }
                if let Some(found) = surface(weights) {
                    *pixel = Some(Surface { height, ..found });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge::mesh::{Material, Mesh};

    /// A square of 2 m facing +z at a height, in its own colour.
    fn square(z: f32, material: usize) -> Part {
        let mut mesh = Mesh::default();
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.push(Vertex {
                position: Vec3::new(x, y, z),
                normal: Vec3::Z,
                uv: Vec2::ZERO,
                tangent: Vec3::X,
                shade: 1.0,
            });
        }
        mesh.push_quad([0, 1, 2, 3]);
        Part { mesh, material }
    }

    fn draw(double_sided: bool, toward: Vec3) -> Raster {
        let mut model = Model::default();
        for color in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            model.add_material(Material {
                double_sided,
                ..Material::plain("plain", color)
            });
        }
        let lod = Lod {
            parts: vec![square(0.5, 0), square(-0.5, 1)],
            screen_coverage: 0.0,
        };
        let mut raster = Raster::new(8, 8);
        raster.draw(
            &model,
            &lod,
            &Sight::from_direction(Vec3::ZERO, toward, Vec2::splat(2.0)),
        );
        raster
    }

    #[test]
    fn the_nearer_square_is_seen_where_it_is() {
        let raster = draw(false, Vec3::Z);
        let seen: Vec<usize> = (0..64).filter(|i| raster.pixels[*i].is_some()).collect();
        assert_eq!(seen.len(), 16, "2 m of 4 m in both directions");
        assert_eq!((seen[0], seen[15]), (18, 45));
        let middle = raster.pixels[27].expect("a surface");
        assert_eq!((middle.color, middle.normal, middle.height), (Vec3::X, Vec3::Z, 0.5));
    }

    #[test]
    fn from_behind_only_double_sided_ones_are_seen() {
        assert!(draw(false, Vec3::NEG_Z).pixels.iter().all(Option::is_none));
        let middle = draw(true, Vec3::NEG_Z).pixels[27].expect("a surface");
        assert_eq!(
            (middle.color, middle.normal, middle.height),
            (Vec3::Y, Vec3::NEG_Z, 0.5)
        );
    }
}
