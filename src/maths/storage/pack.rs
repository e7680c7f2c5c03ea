//! Packing of rectangles into a square atlas: skyline, lowest place first.

use bevy_math::{UVec2, UVec4};

/// How the rectangles fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PackingState {
    /// All as large as asked for.
    Whole,
    /// All made smaller by one factor.
    Shrunk,
    /// Not even with sides of one multiple: no cells.
    TooMany,
}

/// Places of rectangles in a square.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packing {
    /// x, y, width and height in texels, in the order of the sizes. They neither overlap nor stick out.
    pub cells: Vec<UVec4>,
    /// How they fit.
    pub state: PackingState,
}

/// Packs rectangles into a square of `side` texels. The same sizes always get the same places.
///
/// The highest come first, the wider of equal ones before, then in the given order; each lies as low as possible and of
/// those places leftmost. If one finds no place, all are shrunk evenly, by a 32nd at a time, their sides rounded down to
/// `multiple` (at least one), until all do.
pub fn pack(sizes: &[UVec2], side: u32, multiple: u32) -> Packing {
    let multiple = multiple.max(1);
    let mut shrunk = sizes.to_vec();
    let mut state = PackingState::Whole;
    for step in 1.. {
        if let Some(cells) = place(&shrunk, side) {
            return Packing { cells, state };
        }
        if shrunk.iter().all(|size| size.max_element() <= multiple) {
            break;
        }
        state = PackingState::Shrunk;
        let scale = SHRINK.powi(step);
        let scaled = |value: u32| ((f64::from(value) * scale) as u32 / multiple * multiple).max(multiple.min(value));
        shrunk = sizes
            .iter()
            .map(|size| UVec2::new(scaled(size.x), scaled(size.y)))
            .collect();
    }
    Packing {
        cells: Vec::new(),
        state: PackingState::TooMany,
    }
}

const SHRINK: f64 = 31.0 / 32.0;

/// A level stretch of the skyline: everything below `y` is taken or lost.
#[derive(Clone, Copy)]
struct Level {
    x: u32,
    y: u32,
    width: u32,
}

fn place(sizes: &[UVec2], side: u32) -> Option<Vec<UVec4>> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|index| std::cmp::Reverse((sizes[*index].y, sizes[*index].x)));
    let mut skyline = vec![Level {
        x: 0,
        y: 0,
        width: side,
    }];
    let mut cells = vec![UVec4::ZERO; sizes.len()];
    for index in order {
        let size = sizes[index];
        let places = (0..skyline.len()).filter_map(|first| {
            let (x, y) = (skyline[first].x, rest(&skyline[first..], size.x)?);
            (size.y <= side && y <= side - size.y).then_some((y, x))
        });
        let (y, x) = places.min()?;
        cells[index] = UVec4::new(x, y, size.x, size.y);
        raise(&mut skyline, cells[index]);
    }
    Some(cells)
}

/// The height at which a rectangle of this width rests on the first levels; `None` if it sticks out to the right.
fn rest(levels: &[Level], width: u32) -> Option<u32> {
    let mut covered = 0;
    let mut height = 0;
    for level in levels {
        if covered >= width && covered > 0 {
            break;
        }
        height = height.max(level.y);
        covered += level.width;
    }
    (covered >= width).then_some(height)
}

/// Puts a rectangle on the skyline.
fn raise(skyline: &mut Vec<Level>, cell: UVec4) {
    let (start, end) = (cell.x, cell.x + cell.z);
    let mut raised: Vec<Level> = Vec::with_capacity(skyline.len() + 2);
    let top = Level {
        x: start,
        y: cell.y + cell.w,
        width: cell.z,
    };
    raised.extend(skyline.iter().filter(|level| level.x < start).map(|level| Level {
        width: level.width.min(start - level.x),
        ..*level
    }));
    raised.extend((cell.z > 0).then_some(top));
    raised.extend(skyline.iter().filter(|level| level.x + level.width > end).map(|level| {
        let x = level.x.max(end);
        Level {
            x,
            width: level.x + level.width - x,
            ..*level
        }
    }));
    *skyline = raised;
}
