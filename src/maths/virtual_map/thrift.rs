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
    grid::NeedCell,
};

/// Deepest grid for which the best plan is sought: 256 cells per axis. 0.25 ms for 32, 1 ms for 64, 80 ms for 256.
pub(super) const MAX_DEPTH: u32 = 8;

#[derive(Clone, Copy)]
enum Choice {
    Empty,
    Leaf,
    Across,
    Down,
}

#[derive(Clone, Copy)]
struct Best {
    need: NeedCell,
    cost: u64,
    choice: Choice,
}

/// Leaves of the cheapest plan, left before right and upper before lower.
pub(super) fn cheapest(traversal: &Traversal, tile_cost: u32) -> Vec<FittedTile> {
    let depth = traversal.grid.depth();
    // Nodes by p_y, then p_x: `nodes[p_y][p_x]` holds 2^p_y rows of 2^p_x.
    let mut nodes: Vec<Vec<Vec<Best>>> = vec![vec![Vec::new(); depth as usize + 1]; depth as usize + 1];
    for down in (0..=depth).rev() {
        for across in (0..=depth).rev() {
            let splits = [across, down];
            let count = 1_u32 << (across + down);
            let level = (0..count).map(|index| {
                let place = [index & ((1 << across) - 1), index >> across];
                best(traversal, &nodes, Node::new(place, splits), tile_cost)
            });
            let level = level.collect();
            nodes[down as usize][across as usize] = level;
        }
    }
    let mut leaves = Vec::new();
    let mut stack = vec![Node::new([0, 0], [0, 0])];
    while let Some(node) = stack.pop() {
        let found = get(&nodes, &node);
        match found.choice {
            Choice::Empty => {}
            Choice::Leaf => leaves.push(traversal.leaf(&node, &found.need)),
            Choice::Across => stack.extend(node.halves(0).into_iter().rev()),
            Choice::Down => stack.extend(node.halves(1).into_iter().rev()),
        }
    }
    leaves
}

fn get(nodes: &[Vec<Vec<Best>>], node: &Node) -> Best {
    let level = &nodes[node.splits.y as usize][node.splits.x as usize];
    level[((node.place.y << node.splits.x) + node.place.x) as usize]
}

fn best(traversal: &Traversal, nodes: &[Vec<Vec<Best>>], node: Node, tile_cost: u32) -> Best {
    let depth = traversal.grid.depth();
    let halves = |axis: usize| (node.splits[axis] < depth).then(|| node.halves(axis).map(|half| get(nodes, &half)));
    let [across, down] = [halves(0), halves(1)];
    let need = match across.as_ref().or(down.as_ref()) {
        Some([first, second]) => first.need.merged(second.need),
        None => traversal.need(&node),
    };
    if need.pixels == 0 {
        return Best {
            need,
            cost: 0,
            choice: Choice::Empty,
        };
    }
    let mut found = Best {
        need,
        cost: u64::MAX,
        choice: Choice::Leaf,
    };
    if traversal.parts(&node, &need) == UVec2::ZERO {
        found.cost = traversal.leaf(&node, &need).window.texels() + u64::from(tile_cost);
    }
    for (halves, choice) in [(across, Choice::Across), (down, Choice::Down)] {
        let cost = halves.map_or(u64::MAX, |halves| halves[0].cost.saturating_add(halves[1].cost));
        if cost < found.cost {
            (found.cost, found.choice) = (cost, choice);
        }
    }
    found
}
