//! Cells of large fields: every place is drawn once, near ones finer, and as many whatever the field.

use bevy_math::{DVec2, DVec3};
use proptest::prelude::*;
use umbrage::maths::lod::cells::{Cell, CellBorders, CellGrid, OpenCells};

const BORDERS: CellBorders = CellBorders {
    single: 130.0,
    blocks: 220.0,
    lead: 0.08,
};

fn grid(leaves: u32) -> CellGrid {
    CellGrid {
        corner: DVec2::splat(-20.0 * f64::from(leaves)),
        leaf_side: 40.0,
        leaves,
    }
}

fn distance(grid: CellGrid, eye: DVec3) -> impl Fn(Cell) -> f64 {
    move |cell| {
        let center = grid.center(cell);
        eye.distance(DVec3::new(center.x, 0.0, center.y))
    }
}

/// How often each leaf of the field is drawn.
fn coverage(cells: &OpenCells) -> Vec<u32> {
    let leaves = cells.grid().leaves;
    let mut drawn = vec![0; (leaves * leaves) as usize];
    let mut mark = |cell: Cell| {
        for z in cell.z * cell.leaves()..((cell.z + 1) * cell.leaves()).min(leaves) {
            for x in cell.x * cell.leaves()..((cell.x + 1) * cell.leaves()).min(leaves) {
                drawn[(z * leaves + x) as usize] += 1;
            }
        }
    };
    for cell in cells.iter() {
        if cell.level == 0 {
            mark(cell);
        }
        cells.closed_children(cell).for_each(&mut mark);
    }
    drawn
}

/// Blocks and open leaves.
fn counts(cells: &OpenCells) -> (usize, usize) {
    let blocks = cells.iter().map(|cell| cells.closed_children(cell).count()).sum();
    (blocks, cells.iter().filter(|cell| cell.level == 0).count())
}

#[test]
fn the_tree_holds_the_field() {
    for leaves in [1, 2, 3, 13, 40, 125] {
        let grid = grid(leaves);
        let root = grid.root();
        assert!(
            root.leaves() >= leaves && (leaves == 1 || root.leaves() < 2 * leaves),
            "{leaves}"
        );
        assert!(grid.contains(root));
        let last = Cell {
            level: 0,
            x: leaves - 1,
            z: leaves - 1,
        };
        assert!(grid.contains(last) && !grid.contains(Cell { x: leaves, ..last }));
        assert_eq!(grid.center(last), DVec2::splat(20.0 * f64::from(leaves) - 20.0));
        for child in grid.children(root) {
            assert_eq!(child.parent(), root);
        }
        assert_eq!(grid.children(last).count(), 0, "leaves have no children");
    }
}

proptest! {
    /// No gap, nothing twice, whatever way the eye took.
    #[test]
    fn every_place_is_drawn_once(
        leaves in 1_u32..40,
        way in prop::collection::vec((-900.0..900.0, 0.0..200.0, -900.0..900.0), 1..6),
        budget in 1_usize..4,
    ) {
        let grid = grid(leaves);
        let mut cells = OpenCells::new(grid);
        for (x, y, z) in way {
            let distance = distance(grid, DVec3::new(x, y, z));
            for _ in 0..30 {
                let changes = cells.changes(&BORDERS, &distance);
                for cell in changes.close.into_iter().take(budget) {
                    cells.close(cell);
                }
                for cell in changes.open.into_iter().take(budget) {
                    cells.open(cell);
                }
                prop_assert!(coverage(&cells).iter().all(|times| *times == 1));
            }
        }
    }

    /// What is open is what distances say: nearer cells are, farther ones are not, and in between what was before.
    #[test]
    fn cells_settle_to_what_distances_say(
        leaves in 2_u32..60,
        way in prop::collection::vec((-1500.0..1500.0, -1500.0..1500.0), 1..4),
    ) {
        let grid = grid(leaves);
        let mut cells = OpenCells::new(grid);
        for (x, z) in way {
            let distance = distance(grid, DVec3::new(x, 1.7, z));
            cells.settle(&BORDERS, &distance);
            prop_assert!(cells.changes(&BORDERS, &distance).is_empty());
            for cell in cells.iter().filter(|cell| *cell != grid.root()) {
                prop_assert!(cells.is_open(cell.parent()));
                prop_assert!(distance(cell) <= BORDERS.closes_at(cell.level));
                for child in cells.closed_children(cell) {
                    prop_assert!(distance(child) >= BORDERS.opens_at(child.level));
                }
            }
        }
    }
}

#[test]
fn an_eye_that_sways_changes_nothing() {
    let grid = grid(40);
    let mut cells = OpenCells::new(grid);
    cells.settle(&BORDERS, distance(grid, DVec3::new(3.0, 1.7, 5.0)));
    let before = cells.clone();
    // Leaves hold for 8 % of 130 m, and larger cells for more.
    let mut changes = 0;
    for step in 0..20 {
        let sway = if step % 2 == 0 { 4.0 } else { 0.0 };
        let mut next = cells.clone();
        next.settle(&BORDERS, distance(grid, DVec3::new(3.0 + sway, 1.7, 5.0)));
        changes += usize::from(next != cells);
        cells = next;
    }
    assert!(changes <= 1, "{changes} changes");
    assert!(before.iter().all(|cell| cells.is_open(cell)), "nothing closed");
}

/// The number of cells grows with the logarithm of the field's side.
#[test]
fn what_is_drawn_hardly_grows_with_the_field() {
    let drawn = |leaves: u32| {
        let grid = grid(leaves);
        let mut cells = OpenCells::new(grid);
        cells.settle(&BORDERS, distance(grid, DVec3::new(1.0, 1.7, 2.0)));
        counts(&cells)
    };
    // 10⁴, 10⁵ and 10⁶ trees of 64 in a leaf.
    let [small, middle, large] = [13, 40, 125].map(drawn);
    for (_, leaves) in [small, middle, large] {
        // π 130² ÷ 40², more or less with the eye's place in its leaf.
        assert!((29..=38).contains(&leaves), "{leaves} open leaves");
    }
    // 500 m of trees end before the larger rings; ten times as many as in 1.6 km are one and a half times as many blocks.
    assert!(small.0 < 110 && middle.0 < 280, "{small:?} {middle:?}");
    assert!(2 * large.0 < 3 * middle.0, "{middle:?} {large:?}");
}

/// Cells are closed before their parents give way, with room for a crossing at 20 m/s.
#[test]
fn borders_leave_room_for_crossings() {
    for leaves in [2, 13, 125, 1000] {
        for factor in [0.5, 1.0, 1.5] {
            let room = BORDERS.leave_room(&grid(leaves), factor);
            assert!(room > 0.4 * 20.0 * factor, "{leaves} leaves, factor {factor}: {room} m");
        }
    }
    assert!(
        CellBorders {
            blocks: 150.0,
            ..BORDERS
        }
        .leave_room(&grid(13), 1.0)
            < 0.0
    );
}

#[test]
fn the_nearest_opens_first_and_the_farthest_closes_first() {
    let grid = grid(40);
    let mut cells = OpenCells::new(grid);
    let eye = distance(grid, DVec3::new(-500.0, 1.7, 100.0));
    cells.settle(&BORDERS, &eye);
    let away = distance(grid, DVec3::new(500.0, 1.7, 100.0));
    let changes = cells.changes(&BORDERS, &away);
    assert!(changes.close.len() > 20, "{changes:?}");
    assert!(changes.close.is_sorted_by(|a, b| away(*a) >= away(*b)));
    assert!(changes.open.is_sorted_by(|a, b| away(*a) <= away(*b)));
    let has_open_child = |cell: &Cell| grid.children(*cell).any(|child| cells.is_open(child));
    assert!(!changes.close.iter().any(has_open_child), "inner cells first");
}
