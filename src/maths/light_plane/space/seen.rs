//! [`SeenPicture`]: what a camera sees, block by block of its pixels, and how it lies on a film.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2, UVec4, Vec2, Vec4Swizzles};

use super::{BaseFilm, BlockCorner, FilmBlock, FilmSample, SampleGrid};

/// Rounding errors between a depth and its offset from a plane, relative to the depth.
const ROUNDINGS: f64 = 4.0 * f32::EPSILON as f64;

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
    /// The plane through that pixel, and how far the others are off it.
    pub plane: BlockPlane,
}

/// A plane over the picture, and how far the pixels of a block are off it. NDC depth of a plane is affine over the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockPlane {
    /// NDC depth at the middle of the chosen pixel.
    pub depth_ndc: f32,
    /// Change of NDC depth per pixel, to the right and down.
    pub slope: Vec2,
    /// Least and greatest NDC depth of a pixel less that of the plane there.
    pub offsets: [f32; 2],
}

impl BlockPlane {
    /// NDC depth of the plane at a place in pixels, of which the chosen pixel has its middle at another.
    fn depth_at(&self, place: DVec2, middle: DVec2) -> f64 {
        f64::from(self.depth_ndc) + self.slope.as_dvec2().dot(place - middle)
    }
}

impl SeenBlock {
    /// NDC depths at the corners of the block's pixels (top left, top right, bottom right, bottom left) between which all
    /// its surfaces lie: nearest and farthest. `None` where those of all pixels are closer to each other.
    fn layer_ndc(&self, pixels: UVec4) -> Option<[[f64; 2]; 4]> {
        let [nearest, farthest] = self.depths_ndc.map(f64::from);
        // Depths, slopes and offsets are rounded to single precision.
        let rounding = ROUNDINGS * nearest;
        let lowest = f64::from(self.plane.offsets[0]) - rounding;
        let highest = f64::from(self.plane.offsets[1]) + rounding;
        let middle = self.pixel.as_dvec2() + 0.5;
        let layer = [pixels.xy(), pixels.zy(), pixels.zw(), pixels.xw()].map(|place| {
            let depth = self.plane.depth_at(place.as_dvec2(), middle);
            [depth + highest, depth + lowest]
        });
        // Corners are half a pixel beyond the pixels. Where they are much nearer or farther than all of them, the surface
        // ends inside the block and its plane goes on, perhaps to the horizon.
        let slack = f64::from(self.plane.slope.abs().element_sum()) + rounding;
        let range = farthest - slack..=nearest + slack;
        let is_thinner = highest - lowest < nearest - farthest
            && layer
                .iter()
                .flatten()
                .all(|depth| *depth > 0.0 && range.contains(depth));
        is_thinner.then_some(layer)
    }
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
    /// The plane through that pixel: each of its slopes is the smaller one to both neighbours in the block.
    pub plane: BlockPlane,
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
                    plane: BlockPlane::default(),
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
    let (_, mut block) = reduced?;
    let depth_of = |pixel: UVec2| {
        let is_inside = pixel.cmpge(pixels.xy()).all() && pixel.cmplt(pixels.zw()).all();
        let depth = if is_inside {
            depths[(pixel.y * size.x + pixel.x) as usize]
        } else {
            0.0
        };
        (depth > 0.0).then_some(depth)
    };
    let depth_ndc = depths[(block.pixel.y * size.x + block.pixel.x) as usize];
    let slope = |axis: UVec2| {
        let before = depth_of(block.pixel.wrapping_sub(axis)).map(|before| depth_ndc - before);
        let after = depth_of(block.pixel + axis).map(|after| after - depth_ndc);
        match (before, after) {
            (Some(before), Some(after)) if after.abs() < before.abs() => after,
            (before, after) => before.or(after).unwrap_or(0.0),
        }
    };
    let slope = Vec2::new(slope(UVec2::X), slope(UVec2::Y));
    let mut offsets = [f32::INFINITY, f32::NEG_INFINITY];
    for y in pixels.y..pixels.w {
        for x in pixels.x..pixels.z {
            if let Some(depth) = depth_of(UVec2::new(x, y)) {
                let step = UVec2::new(x, y).as_vec2() - block.pixel.as_vec2();
                let offset = depth - (depth_ndc + slope.dot(step));
                offsets = [offsets[0].min(offset), offsets[1].max(offset)];
            }
        }
    }
    block.plane = BlockPlane {
        depth_ndc,
        slope,
        offsets,
    };
    Some(block)
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
        let row = clip_from_world.row(3);
        let columns = self.grid.x.max(1);
        (0..).zip(&self.blocks).filter_map(move |(index, block): (u32, _)| {
            let block = block.as_ref()?;
            let pixels = block_pixels(self.size, self.grid, UVec2::new(index % columns, index / columns));
            let ndc = |x: u32, y: u32| {
                let share = DVec2::new(f64::from(x), f64::from(y)) / self.size.as_dvec2();
                DVec2::new(2.0 * share.x - 1.0, 1.0 - 2.0 * share.y)
            };
            let at = |corner: DVec2, depth: f64| {
                let point = world_from_clip * DVec4::new(corner.x, corner.y, depth, 1.0);
                point.truncate() / point.w
            };
            let corners = [
                ndc(pixels.x, pixels.y),
                ndc(pixels.z, pixels.y),
                ndc(pixels.z, pixels.w),
                ndc(pixels.x, pixels.w),
            ];
            let place_at = |corner: usize, depth_ndc: f64| {
                let world = at(corners[corner], depth_ndc);
                let place = base.film(world).filter(|place| place.is_finite())?;
                let depth = row.dot(world.extend(1.0));
                Some(BlockCorner { place, depth })
            };
            let depths_ndc = block.depths_ndc.map(f64::from);
            let depths = depths_ndc.map(|depth| row.dot(at(corners[0], depth).extend(1.0)));
            let layer = block.layer_ndc(pixels).unwrap_or([depths_ndc; 4]);
            let mut ends = [[BlockCorner::default(); 2]; 4];
            for (corner, ends) in ends.iter_mut().enumerate() {
                for (end, depth_ndc) in ends.iter_mut().zip(layer[corner]) {
                    *end = place_at(corner, depth_ndc)?;
                }
            }
            Some((
                block,
                FilmBlock {
                    sample: None,
                    corners: ends,
                    depths,
                    cut: FilmBlock::UNCUT,
                },
            ))
        })
    }
}
