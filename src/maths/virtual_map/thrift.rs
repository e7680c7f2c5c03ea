//! The cheapest tiles for a grid of needs.
//!
//! The thesis splits a tile only where its need exceeds the largest texture. That draws few tiles, but many texels: a
//! tile of s_max over 1/8 of the map pays its finest pixel's resolution everywhere. And it is not monotone in ξ: of two
//! needs, one fine in u and one in v, a split makes two slivers and none makes a full square, so a lower quality can
//! cost more.
//!
//! With a price C per tile, in texels, the best plan is a recursion over the same nodes (p_x, p_y, place):
//!
//! ```text
//! cost(node) = 0 without pixels
//!            = min( w h + C                        where the need fits, or may not be split any more
//!                   cost(left) + cost(right)
//!                   cost(upper) + cost(lower) )
//! ```
//!
//! Quad splits are two steps of it. There are (2n − 1)² nodes, each visited once. Any plan for ξ is a plan for ξ + 1
//! with textures no larger, so the least cost cannot rise with ξ.

use bevy_math::UVec2;

use super::{
    fitted::{FittedTile, Node, Traversal},
    mapping::MAX_LEVEL,
};

/// Levels of need: 0 to [`MAX_LEVEL`].
const LEVELS: usize = MAX_LEVEL as usize + 1;

/// Deepest grid for which the best plan is sought: 256 cells per axis. 0.03 ms for 32, 0.1 ms for 64, 1.7 ms for 256.
pub(super) const MAX_DEPTH: u32 = 8;

#[derive(Clone, Copy)]
enum Choice {
    Leaf,
    Across,
    Down,
}

/// The cheapest plan of a node.
#[derive(Clone, Copy)]
struct Best {
    /// 0 without pixels; a leaf costs at least a texel.
    cost: u64,
    levels: [u8; 2],
    choice: Choice,
}

/// Leaves of the cheapest plan, left before right and upper before lower.
pub(super) fn cheapest(traversal: &Traversal, tile_cost: u32) -> Vec<FittedTile> {
    let depth = traversal.grid.depth();
    // Nodes by p_y, then p_x: `nodes[p_y][p_x]` holds 2^p_y rows of 2^p_x.
    let mut nodes: Vec<Vec<Vec<Best>>> = vec![vec![Vec::new(); depth as usize + 1]; depth as usize + 1];
    for down in (0..=depth).rev() {
        for across in (0..=depth).rev() {
            nodes[down as usize][across as usize] = level(traversal, &nodes, UVec2::new(across, down), tile_cost);
        }
    }
    let mut leaves = Vec::new();
    let mut stack = vec![Node::new([0, 0], [0, 0])];
    while let Some(node) = stack.pop() {
        let found = nodes[node.splits.y as usize][node.splits.x as usize]
            [((node.place.y << node.splits.x) + node.place.x) as usize];
        match found.choice {
            _ if found.cost == 0 => {}
            Choice::Leaf => leaves.push(traversal.leaf(&node, &traversal.need(&node))),
            Choice::Across => stack.extend(node.halves(0).into_iter().rev()),
            Choice::Down => stack.extend(node.halves(1).into_iter().rev()),
        }
    }
    leaves
}

/// All nodes that are split so often, from those that are split once more.
fn level(traversal: &Traversal, nodes: &[Vec<Vec<Best>>], splits: UVec2, tile_cost: u32) -> Vec<Best> {
    let depth = traversal.grid.depth();
    let of = |across: u32, down: u32| {
        let finer = nodes.get(down as usize).and_then(|row| row.get(across as usize));
        finer.map_or(&[][..], Vec::as_slice)
    };
    let (halves_across, halves_down) = (of(splits.x + 1, splits.y), of(splits.x, splits.y + 1));
    // By level of need: texels along the side of a texture; `None` where the node must be split.
    let sides = [0, 1].map(|axis| {
        let side = |level: usize| traversal.texture_side(splits, level as u8, axis);
        std::array::from_fn::<_, LEVELS, _>(side)
    });
    let side_of = |axis: usize, levels: [u8; 2]| sides[axis][usize::from(levels[axis].min(MAX_LEVEL))];
    let leaf_cost = |levels: [u8; 2]| {
        let texels = side_of(0, levels)? * side_of(1, levels)?;
        Some(texels + u64::from(tile_cost))
    };
    let best = |index: usize| {
        let (x, y) = (index & ((1 << splits.x) - 1), index >> splits.x);
        let across = halves_across.get(2 * index..2 * index + 2);
        let upper = (y << (splits.x + 1)) + x;
        let down = halves_down.get(upper).zip(halves_down.get(upper + (1 << splits.x)));
        let halves = [
            across.map(|halves| (halves[0], halves[1])),
            down.map(|(upper, lower)| (*upper, *lower)),
        ];
        let levels = match halves[0].or(halves[1]) {
            Some((first, second)) if first.cost + second.cost == 0 => None,
            Some((first, second)) => Some([0, 1].map(|axis| first.levels[axis].max(second.levels[axis]))),
            None => {
                let cell = traversal.grid.levels[depth as usize][index];
                (cell.pixels > 0).then_some(cell.levels)
            }
        };
        let Some(levels) = levels else {
            return Best {
                cost: 0,
                levels: [0; 2],
                choice: Choice::Leaf,
            };
        };
        let mut found = Best {
            cost: leaf_cost(levels).unwrap_or(u64::MAX),
            levels,
            choice: Choice::Leaf,
        };
        for (halves, choice) in halves.into_iter().zip([Choice::Across, Choice::Down]) {
            let cost = halves.map_or(u64::MAX, |(first, second)| first.cost + second.cost);
            if cost < found.cost {
                (found.cost, found.choice) = (cost, choice);
            }
        }
        found
    };
    (0..1 << (splits.x + splits.y)).map(best).collect()
}
