//! A camera from a header.

use std::path::Path;

use glam::DAffine3;

use crate::error::Error;

/// A camera from a header.
pub(super) struct HeaderCamera {
    /// x right, y down, z forward.
    pub world_from_camera: DAffine3,
    /// fx, fy, cx, cy in pixels, the first pixel's center at 0.5.
    pub lens: [f64; 4],
}

/// The error of a header that lacks something.
pub(super) fn lacks(path: &Path, what: &str) -> Error {
    Error::invalid(
        path.display(),
        format!("there is no {what} in the header; render it again, or write a transforms.json"),
    )
}
