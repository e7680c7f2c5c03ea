//! Figures: curves and bars as pixels, without a display and without fonts of the system.
//!
//! A figure is a value ([`Curves`], [`Bars`]); drawing it gives [`Pixels`]. The same input gives the same pixels on every
//! machine.

mod bars;
mod canvas;
mod curves;

pub use bars::{Bars, Row};
pub use canvas::{Pixels, PlotError};
pub use curves::{Axis, Curve, Curves, Scale};
