//! [`Sheet`]: pictures of one size side by side, each below its label.

use bevy_math::UVec2;
use plotters::{
    prelude::Text,
    style::{IntoFont, IntoTextStyle},
};

use super::canvas::{FONT, Pixels, PlotError, TEXT_PX, draw, drawing};

/// The smallest letters in pixels, however long the label.
const SMALLEST_TEXT_PX: u32 = 8;

/// Pixels between pictures.
const GAP: u32 = 4;

/// Pictures in rows, in reading order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sheet {
    /// Pictures per row.
    pub columns: u32,
    /// Labels and pictures.
    pub cells: Vec<(String, Pixels)>,
}

impl Sheet {
    /// Draws the sheet, as large as its pictures.
    ///
    /// # Errors
    /// There is no picture, their sizes differ, or the drawing library refuses.
    pub fn draw(&self) -> Result<Pixels, PlotError> {
        let Some((_, first)) = self.cells.first() else {
            return Err(PlotError::Empty("sheet".to_owned()));
        };
        if self.cells.iter().any(|(_, pixels)| pixels.size != first.size) {
            return Err(PlotError::Drawing("its pictures differ in size".to_owned()));
        }
        let columns = self.columns.clamp(1, self.cells.len() as u32);
        let rows = (self.cells.len() as u32).div_ceil(columns);
        let text_px = self.text_px(first.size.x);
        let label_height = text_px + GAP;
        let cell = first.size + UVec2::new(GAP, GAP + label_height);
        let place = |index: usize| UVec2::new(index as u32 % columns, index as u32 / columns) * cell;
        let mut sheet = draw(cell * UVec2::new(columns, rows), |area| {
            let style = (FONT, text_px).into_font().into_text_style(area);
            for (index, (label, _)) in self.cells.iter().enumerate() {
                let place = (place(index) + UVec2::new(0, GAP / 2)).as_ivec2();
                area.draw(&Text::new(label.as_str(), (place.x, place.y), style.clone()))
                    .map_err(drawing)?;
            }
            Ok(())
        })?;
        for (index, (_, pixels)) in self.cells.iter().enumerate() {
            copy(&mut sheet, place(index) + UVec2::new(0, label_height), pixels);
        }
        Ok(sheet)
    }

    /// Letters small enough for the longest label: about half as wide as high.
    fn text_px(&self, width: u32) -> u32 {
        let longest = self.cells.iter().map(|(label, _)| label.chars().count()).max();
        (2 * width / longest.unwrap_or(1).max(1) as u32).clamp(SMALLEST_TEXT_PX, TEXT_PX)
    }
}

/// Copies a picture into a larger one.
fn copy(target: &mut Pixels, place: UVec2, source: &Pixels) {
    let row_bytes = source.size.x as usize * 3;
    let stride = target.size.x as usize * 3;
    let first = place.y as usize * stride + place.x as usize * 3;
    for (row, bytes) in source.bytes.chunks_exact(row_bytes).enumerate() {
        let begin = first + row * stride;
        target.bytes[begin..begin + row_bytes].copy_from_slice(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(size: UVec2, level: u8) -> Pixels {
        Pixels {
            size,
            bytes: vec![level; (size.x * size.y * 3) as usize],
        }
    }

    #[test]
    fn pictures_stand_in_reading_order_below_their_labels() {
        let size = UVec2::new(100, 60);
        let levels = [10, 90, 170, 250, 130];
        let cells = levels.map(|level| (format!("level {level}"), picture(size, level)));
        let sheet = Sheet {
            columns: 2,
            cells: cells.to_vec(),
        }
        .draw()
        .expect("drawn");
        assert_eq!(sheet.size, UVec2::new(2 * 104, 3 * (60 + 4 + 17 + 4)));
        for (index, level) in levels.into_iter().enumerate() {
            let middle = UVec2::new(index as u32 % 2, index as u32 / 2) * UVec2::new(104, 85) + UVec2::new(50, 51);
            let at = (middle.y * sheet.size.x + middle.x) as usize * 3;
            assert_eq!(sheet.bytes[at..at + 3], [level; 3], "picture {index}");
        }
        let label = &sheet.bytes[..sheet.size.x as usize * 17 * 3];
        assert!(label.iter().any(|byte| *byte < 100), "the first row has labels");
    }

    #[test]
    fn labels_shrink_and_nonsense_is_refused() {
        let of = |cells: Vec<(String, Pixels)>| Sheet { columns: 3, cells };
        let small = UVec2::new(200, 160);
        assert_eq!(of(vec![("x".repeat(40), picture(small, 0))]).text_px(200), 10);
        assert!(of(Vec::new()).draw().is_err());
        let differ = vec![
            (String::new(), picture(small, 0)),
            (String::new(), picture(small * 2, 0)),
        ];
        assert!(of(differ).draw().is_err());
    }
}
