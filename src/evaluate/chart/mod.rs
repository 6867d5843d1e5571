//! Charts of sweeps and stress tests, as SVG and PNG.
//!
//! ```text
//! points ─ pareto, stress ─▶ svg (shapes, text, axes) ─ resvg ─▶ PNG
//! ```
//!
//! Text is set in a typeface that the program brings along: no machine needs fonts.

pub(crate) mod axis;
mod pareto;
mod stress;
mod svg;

pub use pareto::pareto;
pub use stress::stress;

use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use crate::error::{Error, Result};

/// A chart, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chart {
    svg: String,
}

const FAMILY: &str = "Ubuntu";

impl Chart {
    /// The chart as a scalable picture; its text wants the typeface Ubuntu.
    #[must_use]
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The chart as PNG.
    ///
    /// # Errors
    /// `Unsupported` where the picture cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>> {
        let fail = |what: String| Error::unsupported("chart", what);
        let mut options = usvg::Options { font_family: FAMILY.to_owned(), ..usvg::Options::default() };
        let fonts = Arc::make_mut(&mut options.fontdb);
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        let tree = usvg::Tree::from_str(&self.svg, &options).map_err(|error| fail(error.to_string()))?;
        let size = tree.size().to_int_size();
        let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height())
            .ok_or_else(|| fail("is too large to be drawn".to_owned()))?;
        resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixels.as_mut());
        pixels.encode_png().map_err(|error| fail(error.to_string()))
    }
}
