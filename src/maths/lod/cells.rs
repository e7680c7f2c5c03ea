//! Cells of a field of very many things, so that a frame costs what is seen and not what there is.
//!
//! A field is a square in a plane, cut like a quadtree. A cell is *open* or *closed*. What is drawn of a closed cell is one
//! block that stands for all of its things; what is drawn of an open one is its four children, or, of an open leaf, its
//! things one by one. Every closed cell whose parent is open is drawn, and every open leaf: together each place of the field
//! once.
//!
//! ```text
//! distance   0 ── leaves open ── single ──── blocks ─────── 2 blocks ───── 4 blocks ──► metres from the cell's middle
//! drawn          single things │ blocks of leaves │ blocks of 2 × 2 │ blocks of 4 × 4
//! ```
//!
//! Blocks of all sizes hold about as much, and borders double where sides do: a ring of one size has at most
//! 3 π (border ÷ side)² cells, whatever the size, so that what is drawn grows with the logarithm of the field's side only.
//!
//! A block and its children may fade into each other at the border of their cell ([`CellBorders::border`]): the cell opens
//! a little before ([`CellBorders::opens_at`]) and closes a little after it ([`CellBorders::closes_at`]). A cell may change
//! only while its parent's children are drawn alone; the borders leave room for that ([`CellBorders::leave_room`]).

use std::collections::BTreeSet;

use bevy_math::DVec2;

/// A square of the quadtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// 0: a leaf; sides double with every level.
    pub level: u32,
    /// Place among the cells of its level along x, from the field's corner.
    pub x: u32,
    /// The same along z.
    pub z: u32,
}

impl Cell {
    /// The cell around it.
    #[must_use]
    pub fn parent(self) -> Self {
        Self {
            level: self.level + 1,
            x: self.x / 2,
            z: self.z / 2,
        }
    }

    /// The quarters of a cell that is no leaf.
    #[must_use]
    pub fn children(self) -> [Self; 4] {
        let level = self.level.saturating_sub(1);
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, z)| Self {
            level,
            x: 2 * self.x + x,
            z: 2 * self.z + z,
        })
    }

    /// Leaves along a side.
    #[must_use]
    pub fn leaves(self) -> u32 {
        1 << self.level
    }
}

/// Where the cells of a field are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellGrid {
    /// The smallest (x, z), metres.
    pub corner: DVec2,
    /// Side of a leaf, metres.
    pub leaf_side: f64,
    /// Leaves along a side of the field, at least 1; the quadtree may be larger.
    pub leaves: u32,
}

impl CellGrid {
    /// The cell around everything.
    #[must_use]
    pub fn root(&self) -> Cell {
        Cell {
            level: self.leaves.max(1).next_power_of_two().trailing_zeros(),
            x: 0,
            z: 0,
        }
    }

    /// Whether a cell lies in the field, at least with its first corner.
    #[must_use]
    pub fn contains(&self, cell: Cell) -> bool {
        let inside = |place: u32| u64::from(place) << cell.level < u64::from(self.leaves.max(1));
        inside(cell.x) && inside(cell.z)
    }

    /// The quarters of a cell that lie in the field; none of a leaf.
    pub fn children(&self, cell: Cell) -> impl Iterator<Item = Cell> + use<> {
        let grid = *self;
        let quarters = (cell.level > 0).then(|| cell.children());
        quarters
            .into_iter()
            .flatten()
            .filter(move |child| grid.contains(*child))
    }

    /// Side of a cell, metres.
    #[must_use]
    pub fn side(&self, cell: Cell) -> f64 {
        self.leaf_side * f64::from(cell.leaves())
    }

    /// Middle of a cell (x, z), metres.
    #[must_use]
    pub fn center(&self, cell: Cell) -> DVec2 {
        let place = DVec2::new(cell.x.into(), cell.z.into()) + 0.5;
        self.corner + place * self.side(cell)
    }
}

/// Distances of middles of cells, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellBorders {
    /// Leaves that are nearer show their things one by one.
    pub single: f64,
    /// The border of cells of level 1; that of level k is 2^(k − 1) times as far.
    pub blocks: f64,
    /// How much before its border a cell opens, as a share of it; it closes as much after. Of leaves, which change at once,
    /// only the latter.
    pub lead: f64,
}

impl CellBorders {
    /// Nearer than this a cell's children are drawn, or a leaf's things.
    #[must_use]
    pub fn border(&self, level: u32) -> f64 {
        match level.checked_sub(1) {
            None => self.single,
            Some(doubled) => self.blocks * f64::from(1_u32 << doubled.min(31)),
        }
    }

    /// Closed cells that are nearer open.
    #[must_use]
    pub fn opens_at(&self, level: u32) -> f64 {
        let lead = if level == 0 { 0.0 } else { self.lead };
        self.border(level) * (1.0 + lead)
    }

    /// Open cells that are farther close.
    #[must_use]
    pub fn closes_at(&self, level: u32) -> f64 {
        self.border(level) * (1.0 + self.lead * if level == 0 { 1.0 } else { 2.0 })
    }

    /// The smallest room in metres, over all levels, between the distance at which a cell has closed for certain and the one
    /// at which its parent's children begin to give way to the parent's block; distances are multiplied with `factor`. Where
    /// it is positive, and larger than what an eye travels during a crossing, cells never wait for each other.
    #[must_use]
    pub fn leave_room(&self, grid: &CellGrid, factor: f64) -> f64 {
        let rooms = (0..grid.root().level).map(|level| {
            let cell = Cell { level, x: 0, z: 0 };
            // The parent's middle may be nearer by half a diagonal of the child.
            let half_diagonal = grid.side(cell) * std::f64::consts::FRAC_1_SQRT_2;
            self.border(level + 1) - self.closes_at(level) - factor * half_diagonal
        });
        rooms.fold(f64::INFINITY, f64::min)
    }
}

/// What may change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellChanges {
    /// Cells to open, nearest first.
    pub open: Vec<Cell>,
    /// Cells to close, farthest first.
    pub close: Vec<Cell>,
}

impl CellChanges {
    /// Whether nothing is to be done.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.open.is_empty() && self.close.is_empty()
    }
}

/// The open cells of a field. The root is always open; the parents of open cells are open.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenCells {
    grid: CellGrid,
    open: BTreeSet<Cell>,
}

impl OpenCells {
    /// Only the root.
    #[must_use]
    pub fn new(grid: CellGrid) -> Self {
        Self {
            open: [grid.root()].into(),
            grid,
        }
    }

    /// Where they are.
    #[must_use]
    pub fn grid(&self) -> &CellGrid {
        &self.grid
    }

    /// Whether a cell is open.
    #[must_use]
    pub fn is_open(&self, cell: Cell) -> bool {
        self.open.contains(&cell)
    }

    /// All open cells, by level and place.
    pub fn iter(&self) -> impl Iterator<Item = Cell> {
        self.open.iter().copied()
    }

    /// The children of an open cell that are drawn as blocks.
    pub fn closed_children(&self, cell: Cell) -> impl Iterator<Item = Cell> {
        self.grid.children(cell).filter(|child| !self.is_open(*child))
    }

    /// Marks a cell as open; its parent must be.
    pub fn open(&mut self, cell: Cell) {
        debug_assert!(self.is_open(cell.parent()), "{cell:?} opens in a closed cell");
        self.open.insert(cell);
    }

    /// Marks a cell as closed; its children must be, and it is not the root.
    pub fn close(&mut self, cell: Cell) {
        debug_assert!(
            self.grid.children(cell).all(|child| !self.is_open(child)),
            "{cell:?} closes around open cells"
        );
        self.open.remove(&cell);
    }

    /// What the distances of cells' middles from the eye ask for next: of cells in cells only one per call, the outer one
    /// where they open, the inner one where they close.
    #[must_use]
    pub fn changes(&self, borders: &CellBorders, distance: impl Fn(Cell) -> f64) -> CellChanges {
        let (mut open, mut close) = (Vec::new(), Vec::new());
        for cell in self.iter() {
            for child in self.closed_children(cell) {
                let away = distance(child);
                if away < borders.opens_at(child.level) {
                    open.push((away, child));
                }
            }
            let is_innermost = || self.grid.children(cell).all(|child| !self.is_open(child));
            if cell != self.grid.root() && is_innermost() {
                let away = distance(cell);
                if away > borders.closes_at(cell.level) {
                    close.push((-away, cell));
                }
            }
        }
        let sorted = |mut cells: Vec<(f64, Cell)>| {
            cells.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            cells.into_iter().map(|(_, cell)| cell).collect()
        };
        CellChanges {
            open: sorted(open),
            close: sorted(close),
        }
    }

    /// Makes all changes that distances ask for, at once.
    pub fn settle(&mut self, borders: &CellBorders, distance: impl Fn(Cell) -> f64) {
        loop {
            let changes = self.changes(borders, &distance);
            if changes.is_empty() {
                return;
            }
            changes.close.into_iter().for_each(|cell| self.close(cell));
            changes.open.into_iter().for_each(|cell| self.open(cell));
        }
    }
}
