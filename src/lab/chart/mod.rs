//! Charts of sweeps, stress tests and chosen views, as SVG and PNG.
//!
//! ```text
//! points ─ pareto, stress, views ─▶ svg (shapes, text, axes) ─ resvg ─▶ PNG
//! ```
//!
//! Text is set in a typeface that the program brings along: no machine needs fonts.

pub mod axis;
mod color;
mod error_picture;
mod labels;
mod pareto;
mod stress;
mod svg;
mod together;
mod views;

pub use error_picture::error_picture;
pub use pareto::pareto;
pub use stress::stress;
pub use svg::Chart;
pub(crate) use together::{TogetherPoint, together};
pub use views::views;
