//! Titles, keys and notes, each in its own strip of a figure, so that none covers data.

use plotters::{
    prelude::{BLACK, Color, PathElement, Rectangle, Text, TextStyle},
    style::text_anchor::{HPos, Pos, VPos},
    style::{IntoFont, IntoTextStyle},
};

use super::canvas::{Area, FONT, PlotError, TEXT_PX, TITLE_PX, color, drawing};

/// What stands for a series beside its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    /// A piece of the curve.
    Line,
    /// A piece of the bar.
    Box,
}

/// Pixels of a mark, and between it, its name and the next entry.
const MARK: i32 = 26;
const GAP: i32 = 8;
const BETWEEN: i32 = 24;

/// Pixels from the edges of a figure.
const MARGIN: i32 = 14;

/// Height of a line of text in pixels.
fn line_height(text_px: u32) -> i32 {
    (text_px * 4 / 3) as i32
}

/// Draws title and key on top and returns what is left below them. A key of one nameless series is left out.
pub(super) fn head<'a>(area: &Area<'a>, title: &str, mark: Mark, names: &[String]) -> Result<Area<'a>, PlotError> {
    let rest = titled(area, title, TITLE_PX)?;
    if names.iter().all(String::is_empty) {
        return Ok(rest);
    }
    let style = text_style(&rest, TEXT_PX, HPos::Left);
    let width = rest.dim_in_pixel().0 as i32 - 2 * MARGIN;
    let (mut x, mut line) = (0, 0);
    let mut places = Vec::new();
    for name in names {
        let own = MARK + GAP + text_width(&rest, name, &style)?;
        if x > 0 && x + own > width {
            (x, line) = (0, line + 1);
        }
        places.push((x + MARGIN, line));
        x += own + BETWEEN;
    }
    let height = line_height(TEXT_PX);
    let (strip, below) = rest.split_vertically((line + 1) * height + GAP);
    for (index, (name, (x, line))) in names.iter().zip(places).enumerate() {
        let y = line * height + height / 2;
        let style = style.clone();
        let color = color(index);
        match mark {
            Mark::Line => strip.draw(&PathElement::new([(x, y), (x + MARK, y)], color.stroke_width(3))),
            Mark::Box => strip.draw(&Rectangle::new([(x, y - 6), (x + MARK, y + 6)], color.filled())),
        }
        .map_err(drawing)?;
        let text = Text::new(name.clone(), (x + MARK + GAP, y), style);
        strip.draw(&text).map_err(drawing)?;
    }
    Ok(below)
}

/// Draws a title in the middle of the top and returns what is left below it.
pub(super) fn titled<'a>(area: &Area<'a>, title: &str, text_px: u32) -> Result<Area<'a>, PlotError> {
    let (strip, below) = area.split_vertically(line_height(text_px) + MARGIN);
    let middle = (area.dim_in_pixel().0 / 2) as i32;
    let place = (middle, (line_height(text_px) + MARGIN) / 2);
    let text = Text::new(title.to_owned(), place, text_style(area, text_px, HPos::Center));
    strip.draw(&text).map_err(drawing)?;
    Ok(below)
}

/// Draws lines of text at the bottom, broken between words where they are too long, and returns what is left above them.
pub(super) fn noted<'a>(area: &Area<'a>, notes: &[String]) -> Result<Area<'a>, PlotError> {
    let style = text_style(area, NOTE_PX, HPos::Left);
    let width = area.dim_in_pixel().0 as i32 - 2 * MARGIN;
    let mut lines: Vec<String> = Vec::new();
    for note in notes {
        let mut line = String::new();
        for word in note.split_whitespace() {
            let longer = if line.is_empty() {
                word.to_owned()
            } else {
                format!("{line} {word}")
            };
            if !line.is_empty() && text_width(area, &longer, &style)? > width {
                lines.push(std::mem::replace(&mut line, word.to_owned()));
            } else {
                line = longer;
            }
        }
        lines.push(line);
    }
    let height = line_height(NOTE_PX);
    let (_, size) = area.dim_in_pixel();
    let own = lines.len() as i32 * height + MARGIN;
    let (above, strip) = area.split_vertically(size as i32 - own);
    for (index, line) in lines.into_iter().enumerate() {
        let place = (MARGIN, index as i32 * height + height / 2);
        strip.draw(&Text::new(line, place, style.clone())).map_err(drawing)?;
    }
    Ok(above)
}

/// Points of notes, in pixels.
const NOTE_PX: u32 = 15;

fn text_style<'a>(area: &Area, text_px: u32, at: HPos) -> TextStyle<'a> {
    let style = (FONT, text_px).into_font().into_text_style(area);
    style.color(&BLACK).pos(Pos::new(at, VPos::Center))
}

fn text_width(area: &Area, text: &str, style: &TextStyle) -> Result<i32, PlotError> {
    let (width, _) = area.estimate_text_size(text, style).map_err(drawing)?;
    Ok(width as i32)
}
