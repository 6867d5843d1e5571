//! How poses and depth of the open capture are read, and how they would fit better.

use std::sync::Arc;

use egui::TextureHandle;

use overlook_engine::capture::conventions::{Alternative, Finding};

/// Two readings as pictures: what one camera recorded, and what the others show of it as read and under the other reading.
pub(crate) struct ReadingPictures<T> {
    /// Name of the camera.
    pub camera: String,
    pub pictures: [T; 3],
    /// Shares of points that agree and that contradict under each reading.
    pub votes: [[f64; 2]; 2],
}

pub(crate) type ReadingImages = ReadingPictures<Arc<egui::ColorImage>>;

/// The check of how the open capture is read: its finding, and the dialog that compares two readings.
#[derive(Default)]
pub(crate) struct ReadingCheck {
    /// The finding from the agreement between its views; `None` before it was made.
    pub finding: Option<Arc<Finding>>,
    /// Whether the dialog is open that compares two readings.
    pub is_open: bool,
    pub shown: Option<ReadingPictures<TextureHandle>>,
    /// Why the comparison cannot be shown.
    pub trouble: Option<String>,
}

impl ReadingCheck {
    /// The reading that fits far better than the capture's own, if any.
    pub(crate) fn alternative(&self) -> Option<&Alternative> {
        self.finding.as_ref()?.alternative()
    }

    /// The keys of a manifest by which the capture opens under the other reading, one a line.
    pub(crate) fn keys(&self) -> String {
        let lines = self.alternative().into_iter().flat_map(|other| &other.keys);
        lines.map(|(key, value)| format!("\"{key}\": {value},")).collect::<Vec<_>>().join("\n")
    }
}
