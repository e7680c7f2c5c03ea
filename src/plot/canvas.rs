//! What figures are drawn on: [`Pixels`], a font and colors.

use std::{io::Cursor, sync::OnceLock};

use bevy_math::UVec2;
use image::{ColorType, ImageFormat};
use plotters::{
    coord::Shift,
    prelude::{BitMapBackend, DrawingArea, FontStyle, IntoDrawingArea, RGBColor, WHITE},
    style::register_font,
};
use thiserror::Error;

/// The font of all text.
pub(super) const FONT: &str = "Fira Sans";

/// Points of ordinary text and of titles, in pixels.
pub(super) const TEXT_PX: u32 = 17;
/// Titles.
pub(super) const TITLE_PX: u32 = 22;

/// Series in the order in which they are given: blue, orange, green, red, purple, brown, pink, grey, olive, cyan. They
/// differ in lightness too.
const COLORS: [[u8; 3]; 10] = [
    [31, 119, 180],
    [255, 127, 14],
    [44, 160, 44],
    [200, 30, 40],
    [120, 80, 170],
    [140, 86, 75],
    [227, 119, 194],
    [110, 110, 110],
    [165, 165, 30],
    [23, 170, 190],
];

/// Why a figure cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PlotError {
    /// The size has no room for axes.
    #[error("a figure of {0} pixels is too small: at least {SMALLEST} x {SMALLEST}")]
    TooSmall(UVec2),
    /// There is nothing in it.
    #[error("the figure `{0}` has no finite value")]
    Empty(String),
    /// The drawing library refused.
    #[error("a figure cannot be drawn: {0}")]
    Drawing(String),
}

/// Sides of the smallest figure, in pixels.
const SMALLEST: u32 = 160;

/// A picture: red, green and blue of every pixel, 8-bit sRGB, row 0 on top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Across and down.
    pub size: UVec2,
    /// Three bytes per pixel.
    pub bytes: Vec<u8>,
}

impl Pixels {
    /// The picture as a PNG file.
    ///
    /// # Errors
    /// The pixels do not fill the size.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        let mut png = Cursor::new(Vec::new());
        let (width, height) = (self.size.x, self.size.y);
        image::write_buffer_with_format(&mut png, &self.bytes, width, height, ColorType::Rgb8, ImageFormat::Png)
            .map_err(drawing)?;
        Ok(png.into_inner())
    }
}

/// A part of a figure.
pub(super) type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Draws on white pixels.
pub(super) fn draw(size: UVec2, figure: impl FnOnce(&Area) -> Result<(), PlotError>) -> Result<Pixels, PlotError> {
    if size.min_element() < SMALLEST {
        return Err(PlotError::TooSmall(size));
    }
    load_font()?;
    let mut bytes = vec![255; size.x as usize * size.y as usize * 3];
    {
        let area = BitMapBackend::with_buffer(&mut bytes, (size.x, size.y)).into_drawing_area();
        area.fill(&WHITE).map_err(drawing)?;
        figure(&area)?;
        area.present().map_err(drawing)?;
    }
    Ok(Pixels { size, bytes })
}

/// The color of a series.
pub(super) fn color(index: usize) -> RGBColor {
    let [red, green, blue] = COLORS[index % COLORS.len()];
    RGBColor(red, green, blue)
}

/// An error of the drawing library.
pub(super) fn drawing(error: impl ToString) -> PlotError {
    PlotError::Drawing(error.to_string())
}

/// Once per process.
fn load_font() -> Result<(), PlotError> {
    static LOADED: OnceLock<bool> = OnceLock::new();
    let bytes = include_bytes!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/fonts/FiraSans-Regular.ttf"
    ));
    let is_loaded = LOADED.get_or_init(|| register_font(FONT, FontStyle::Normal, bytes).is_ok());
    is_loaded
        .then_some(())
        .ok_or_else(|| PlotError::Drawing("its font cannot be read".to_owned()))
}
