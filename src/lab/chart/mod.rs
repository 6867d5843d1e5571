//! Charts of sweeps, stress tests and chosen views, and figures of pictures, as SVG, PNG and PDF.
//!
//! ```text
//! points ─ series, axis ─┬─ pareto, stress, views ─▶ svg (shapes, text) ─┬─ resvg ─▶ PNG
//!                        └─ the window     picture ─ figure ─▶ ▲           └─ pdf ─▶ PDF
//! ```
//!
//! Text is set in a typeface that the program brings along: no machine needs fonts.

mod axis;
mod caption;
mod color_bar;
mod error_picture;
mod figure;
mod pareto;
mod pdf;
mod side_names;
mod stress;
mod svg;
mod together;
mod type_metrics;
mod views;

pub use axis::{ChartSeries, Marker, Scale, series};
pub use caption::Caption;
pub use color_bar::ColorBar;
pub use error_picture::error_picture;
pub use figure::{FIGURE_COLUMNS, Figure, LegendEntry, ScaleBar};
pub use pareto::{ChartQuantity, pareto, tradeoff};
pub use side_names::SideNames;
pub use stress::stress;
pub use svg::{Chart, INCH_MM};
pub(crate) use together::{TogetherPoint, together};
pub use views::views;
