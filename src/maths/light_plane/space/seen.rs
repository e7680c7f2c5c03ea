//! [`SeenPicture`]: what a camera sees, block by block of its pixels, and how it lies on a film.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2, UVec4};

use super::{BaseFilm, FilmSample, SampleGrid};

/// A block of pixels in which some see a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenBlock {
    /// Where the surface is in the pixel of the block that is nearest to its middle and sees one; in the world.
    pub position: DVec3,
    /// Of the surface there, towards the camera.
    pub normal: DVec3,
    /// Depth of the nearest and of the farthest pixel, NDC: reverse z, so the first is not the smaller.
    pub depths_ndc: [f32; 2],
    /// That pixel.
    pub pixel: UVec2,
    /// Pixels that see a surface.
    pub pixels: u32,
}

/// What a camera sees: a grid of blocks over its picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenPicture {
    /// The camera's matrix.
    pub clip_from_world: DMat4,
    /// Pixels across and down.
    pub size: UVec2,
    /// Blocks across and down.
    pub grid: UVec2,
    /// Row by row from the top left; `None`: only sky, or no pixel at all in pictures smaller than the grid.
    pub blocks: Vec<Option<SeenBlock>>,
}

/// A block on the base film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmBlock {
    /// Stands for the block's pixels; `None` where the surface says nothing about films ([`Unsampled`](super::Unsampled)).
    pub sample: Option<FilmSample>,
    /// The rays through the block's corners, at its nearest and its farthest depth. All its pixels lie between them.
    pub rays: [[DVec2; 2]; 4],
    /// View depths of the nearest and of the farthest pixel: w of the camera's matrix.
    pub depths: [f64; 2],
}

/// First pixel and the one beyond the last of a block: x, y, x, y. The blocks of a picture neither overlap nor leave a
/// pixel out, whatever its size.
pub fn block_pixels(size: UVec2, grid: UVec2, block: UVec2) -> UVec4 {
    let border = |index: UVec2| index * size / grid;
    let (first, end) = (border(block), border(block + 1));
    UVec4::new(first.x, first.y, end.x, end.y)
}

/// What the depths of a block come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockDepths {
    /// Nearest and farthest depth, NDC.
    pub depths_ndc: [f32; 2],
    /// The pixel that sees a surface nearest to the block's middle; of several the first, row by row.
    pub pixel: UVec2,
    /// Pixels that see a surface.
    pub pixels: u32,
}

/// The depths of a block: step by step what `shaders/light_plane/see_blocks.wgsl` does. `depths` of all pixels row by row,
/// NDC, 0 for the sky. `None` without surfaces.
///
/// Distances are counted in half pixels, so that they are whole numbers.
pub fn reduce_block(depths: &[f32], size: UVec2, grid: UVec2, block: UVec2) -> Option<BlockDepths> {
    let pixels = block_pixels(size, grid, block);
    let mut reduced: Option<(u32, BlockDepths)> = None;
    for y in pixels.y..pixels.w {
        for x in pixels.x..pixels.z {
            let depth = depths[(y * size.x + x) as usize];
            if depth <= 0.0 {
                continue;
            }
            let off =
                (2 * UVec2::new(x, y) + 1).as_ivec2() - UVec2::new(pixels.x + pixels.z, pixels.y + pixels.w).as_ivec2();
            let distance = off.length_squared() as u32;
            let (least, known) = reduced.get_or_insert((
                u32::MAX,
                BlockDepths {
                    depths_ndc: [depth; 2],
                    pixel: UVec2::ZERO,
                    pixels: 0,
                },
            ));
            let [near, far] = known.depths_ndc;
            known.depths_ndc = [near.max(depth), far.min(depth)];
            known.pixels += 1;
            if distance < *least {
                *least = distance;
                known.pixel = UVec2::new(x, y);
            }
        }
    }
    reduced.map(|(_, reduced)| reduced)
}

impl SeenPicture {
    /// All blocks with surfaces on a base film. Blocks that reach beside or behind a light at a point are left out.
    pub fn on_film<'a>(&'a self, base: &'a BaseFilm) -> impl Iterator<Item = FilmBlock> + 'a {
        let grid = SampleGrid {
            clip_from_world: self.clip_from_world,
            picture_size: self.size,
            samples: self.grid,
        };
        self.seen_from(base, self.clip_from_world).map(move |(block, place)| {
            let sample = FilmSample::new(base, &grid, block.position, block.normal).ok();
            let depth = self.clip_from_world.row(3).dot(block.position.extend(1.0));
            FilmBlock {
                sample: sample.map(|sample| FilmSample {
                    pixels: f64::from(block.pixels),
                    depths: [depth; 2],
                    ..sample
                }),
                ..place
            }
        })
    }

    /// The same blocks, at the same depths, where another camera has them in its picture, without samples: what a camera
    /// that has moved since may see, if what comes into the picture is about as far away as what was at its border.
    pub fn moved_on_film<'a>(
        &'a self,
        base: &'a BaseFilm,
        clip_from_world: DMat4,
    ) -> impl Iterator<Item = FilmBlock> + 'a {
        self.seen_from(base, clip_from_world).map(|(_, place)| place)
    }

    fn seen_from<'a>(
        &'a self,
        base: &'a BaseFilm,
        clip_from_world: DMat4,
    ) -> impl Iterator<Item = (&'a SeenBlock, FilmBlock)> + 'a {
        let world_from_clip = clip_from_world.inverse();
        let columns = self.grid.x.max(1);
        (0..).zip(&self.blocks).filter_map(move |(index, block): (u32, _)| {
            let block = block.as_ref()?;
            let pixels = block_pixels(self.size, self.grid, UVec2::new(index % columns, index / columns));
            let ndc = |x: u32, y: u32| {
                let share = DVec2::new(f64::from(x), f64::from(y)) / self.size.as_dvec2();
                DVec2::new(2.0 * share.x - 1.0, 1.0 - 2.0 * share.y)
            };
            let at = |corner: DVec2, depth: f32| {
                let point = world_from_clip * DVec4::new(corner.x, corner.y, f64::from(depth), 1.0);
                point.truncate() / point.w
            };
            let corners = [
                ndc(pixels.x, pixels.y),
                ndc(pixels.z, pixels.y),
                ndc(pixels.z, pixels.w),
                ndc(pixels.x, pixels.w),
            ];
            let mut rays = [[DVec2::ZERO; 2]; 4];
            for (ray, corner) in rays.iter_mut().zip(corners) {
                for (place, depth) in ray.iter_mut().zip(block.depths_ndc) {
                    *place = base.film(at(corner, depth)).filter(|place| place.is_finite())?;
                }
            }
            let row = clip_from_world.row(3);
            let depths = block.depths_ndc.map(|depth| row.dot(at(corners[0], depth).extend(1.0)));
            Some((
                block,
                FilmBlock {
                    sample: None,
                    rays,
                    depths,
                },
            ))
        })
    }
}

impl FilmBlock {
    /// The part of the block between two view depths; `None` if there is none. Film coordinates of the sun are linear along
    /// the rays. The sample stays with the part that has its depth, of two neighbours with the farther one.
    pub fn between(&self, near: f64, far: f64) -> Option<Self> {
        let [first, last] = self.depths;
        if first >= far || last < near {
            return None;
        }
        let share = |depth: f64| {
            let share = (depth - first) / (last - first);
            if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
        };
        let ends = [first.max(near), last.min(far)];
        let rays = self
            .rays
            .map(|[nearest, farthest]| ends.map(|depth| nearest.lerp(farthest, share(depth))));
        let sample = self.sample.filter(|sample| (near..far).contains(&sample.depths[0]));
        Some(Self {
            sample,
            rays,
            depths: ends,
        })
    }

    /// Points whose hull holds all pixels of the block.
    pub fn points(&self) -> [DVec2; 8] {
        let [a, b, c, d] = self.rays;
        [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]]
    }
}
