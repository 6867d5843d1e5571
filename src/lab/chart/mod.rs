//! Charts of sweeps, stress tests and chosen views, as SVG and PNG.
//!
//! ```text
//! points ─ series, axis ─┬─ pareto, stress, views ─▶ svg (shapes, text) ─ resvg ─▶ PNG
//!                        └─ the window
//! ```
//!
//! Text is set in a typeface that the program brings along: no machine needs fonts.

mod axis;
mod color;
mod error_picture;
mod labels;
mod pareto;
mod series;
mod stress;
mod svg;
mod together;
mod views;

pub use axis::Scale;
pub use error_picture::error_picture;
pub use pareto::pareto;
pub use series::{ChartSeries, Marker, series};
pub use stress::stress;
pub use svg::Chart;
pub(crate) use together::{TogetherPoint, together};
pub use views::views;
