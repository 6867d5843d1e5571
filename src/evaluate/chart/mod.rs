//! Charts of sweeps, stress tests and chosen views, as SVG and PNG.
//!
//! ```text
//! points ─ pareto, stress, views ─▶ svg (shapes, text, axes) ─ resvg ─▶ PNG
//! ```
//!
//! Text is set in a typeface that the program brings along: no machine needs fonts.

pub(crate) mod axis;
mod color;
mod error_picture;
mod labels;
mod pareto;
mod stress;
mod svg;
mod together;
mod views;

pub(crate) use error_picture::error_picture;
pub(crate) use pareto::pareto;
pub(crate) use stress::stress;
pub(crate) use svg::Chart;
pub(crate) use together::{TogetherPoint, together};
pub(crate) use views::views;
