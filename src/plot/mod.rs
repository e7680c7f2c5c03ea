//! Figures: curves, bars and maps of directions as pixels, without a display and without fonts of the system.
//!
//! A plot is a value ([`Curves`], [`Bars`], [`HeatMap`]); drawing it gives [`Pixels`]. The same input gives the same pixels
//! on every machine. [`figures`] are the papers' plots of error and storage, from the formulas.

mod axis;
mod bars;
mod canvas;
mod curves;
pub mod figures;
mod heat_map;
mod key;
mod sheet;

pub use axis::{Axis, Scale};
pub use bars::{Bars, Row};
pub use canvas::{Pixels, PlotError};
pub use curves::{Curve, Curves};
pub use heat_map::HeatMap;
pub use sheet::Sheet;
