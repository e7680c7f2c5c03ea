//! Where things are in the picture of all façades.
//!
//! Strips run over the whole width and repeat to the right: [`STRIP_LENGTH`] metres a turn, in four cells of one bay
//! each. Cells hold one thing each. Below lie the far views of bays, painted from the bays themselves.

use bevy_math::Vec2;

/// Columns of the picture.
pub const WIDTH: usize = 1024;
/// Rows of the picture.
pub const HEIGHT: usize = 1536;
/// What a strip shows over the whole width, in metres.
pub const STRIP_LENGTH: f32 = 12.8;
/// Bays per turn of a wall's strip.
pub const BAYS_PER_TURN: usize = 4;
/// Columns and rows of a far view.
pub const VIEW: usize = 64;
/// Room for far views.
pub const VIEWS: usize = 64;
/// First row of the far views.
pub const VIEWS_TOP: usize = 1280;
/// Texels that coordinates keep away from the borders of cells, so that filters do not mix neighbours.
const INSET: f32 = 0.75;

/// A strip over the whole width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// First row.
    pub top: usize,
    /// Rows.
    pub rows: usize,
    /// Height of what it shows, in metres.
    pub metres: f32,
}

/// A rectangle that shows one thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// First column.
    pub left: usize,
    /// First row.
    pub top: usize,
    /// Columns.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
}

const fn strip(top: usize, rows: usize, metres: f32) -> Strip {
    Strip { top, rows, metres }
}

/// Smooth plaster, four bays.
pub const PLASTER: Strip = strip(0, 128, 3.2);
/// Courses of ashlar, four bays.
pub const ASHLAR: Strip = strip(128, 128, 4.3);
/// Brickwork, four bays.
pub const BRICK: Strip = strip(256, 160, 3.2);
/// Cast panels, four bays.
pub const CONCRETE: Strip = strip(416, 128, 3.2);
/// Clay tiles: the lower border is the eaves.
pub const TILES: Strip = strip(544, 128, 5.0);
/// Light stone of sills, cornices and copings.
pub const STONE: Strip = strip(672, 32, 0.8);
/// Gravel of flat roofs.
pub const GRAVEL: Strip = strip(704, 32, 3.2);
/// Zinc with standing seams.
pub const ZINC: Strip = strip(736, 32, 3.2);
/// Dark paint of railings.
pub const IRON: Strip = strip(768, 16, 0.4);
/// Painted wood of shutters.
pub const WOOD: Strip = strip(784, 16, 0.4);
/// Striped cloth, red.
pub const CLOTH_RED: Strip = strip(800, 16, 1.2);
/// Striped cloth, green.
pub const CLOTH_GREEN: Strip = strip(816, 16, 1.2);

/// A window: 0..=3 casements, 4 and 5 french doors, 6 and 7 wide modern ones, 8 and 9 offices.
pub const fn window(kind: usize) -> Cell {
    Cell {
        left: (kind % WINDOWS) * 102,
        top: 832,
        columns: 102,
        rows: 160,
    }
}
/// Kinds of windows.
pub const WINDOWS: usize = 10;

/// A shop front.
pub const fn shop(kind: usize) -> Cell {
    Cell {
        left: (kind % SHOPS) * 256,
        top: 992,
        columns: 256,
        rows: 192,
    }
}
/// Kinds of shop fronts.
pub const SHOPS: usize = 4;

/// A front door.
pub const fn door(kind: usize) -> Cell {
    Cell {
        left: (kind % DOORS) * 64,
        top: 1184,
        columns: 64,
        rows: 96,
    }
}
/// Kinds of front doors.
pub const DOORS: usize = 3;

/// A shop sign.
pub const fn sign(kind: usize) -> Cell {
    Cell {
        left: 192 + (kind % 4) * 208,
        top: 1184 + (kind / 4 % 2) * 48,
        columns: 208,
        rows: 48,
    }
}
/// Kinds of signs.
pub const SIGNS: usize = 8;

/// The far view of a bay.
pub const fn view(index: usize) -> Cell {
    Cell {
        left: (index % 16) * VIEW,
        top: VIEWS_TOP + (index / 16 % 4) * VIEW,
        columns: VIEW,
        rows: VIEW,
    }
}

impl Strip {
    /// Texture coordinates `along` metres from the strip's start and at a share `up` (0..=1) of its height.
    pub fn at(&self, along: f32, up: f32) -> Vec2 {
        let rows = self.rows as f32 - 2.0 * INSET;
        let y = (self.top + self.rows) as f32 - INSET - up * rows;
        Vec2::new(along / STRIP_LENGTH, y / HEIGHT as f32)
    }
}

impl Cell {
    /// Texture coordinates at a share (0..=1) of the cell: x right, y *up*.
    pub fn at(&self, share: Vec2) -> Vec2 {
        let size = Vec2::new(self.columns as f32, self.rows as f32) - 2.0 * INSET;
        let x = self.left as f32 + INSET + share.x * size.x;
        let y = (self.top + self.rows) as f32 - INSET - share.y * size.y;
        Vec2::new(x / WIDTH as f32, y / HEIGHT as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_lies_on_anything_else() {
        let strips = [
            PLASTER,
            ASHLAR,
            BRICK,
            CONCRETE,
            TILES,
            STONE,
            GRAVEL,
            ZINC,
            IRON,
            WOOD,
            CLOTH_RED,
            CLOTH_GREEN,
        ];
        let whole = |strip: Strip| Cell {
            left: 0,
            top: strip.top,
            columns: WIDTH,
            rows: strip.rows,
        };
        let cells: Vec<Cell> = strips
            .into_iter()
            .map(whole)
            .chain((0..WINDOWS).map(window))
            .chain((0..SHOPS).map(shop))
            .chain((0..DOORS).map(door))
            .chain((0..SIGNS).map(sign))
            .chain((0..VIEWS).map(view))
            .collect();
        for (i, a) in cells.iter().enumerate() {
            assert!(a.left + a.columns <= WIDTH && a.top + a.rows <= HEIGHT, "{a:?}");
            for b in &cells[i + 1..] {
                let beside = a.left + a.columns <= b.left || b.left + b.columns <= a.left;
                let above = a.top + a.rows <= b.top || b.top + b.rows <= a.top;
                assert!(beside || above, "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn coordinates_stay_in_their_cell() {
        let cell = shop(1);
        let low = cell.at(Vec2::ZERO) * Vec2::new(1024.0, 1536.0);
        let high = cell.at(Vec2::ONE) * Vec2::new(1024.0, 1536.0);
        assert_eq!(low, Vec2::new(256.75, 1183.25), "the lower left corner");
        assert_eq!(high, Vec2::new(511.25, 992.75), "the upper right corner");
        let turn = PLASTER.at(12.8, 1.0) - PLASTER.at(0.0, 1.0);
        assert_eq!(turn, Vec2::X);
    }
}
