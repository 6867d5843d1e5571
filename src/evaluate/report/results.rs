//! What a page is made from.

use crate::evaluate::stress::{BreakingPoint, StressPoint};
use crate::evaluate::sweep::Point;
use crate::evaluate::tune::ChosenViews;

/// What was measured on one capture.
#[derive(Debug, Default)]
pub(crate) struct CaptureResults {
    /// Name of the capture.
    pub(crate) name: String,
    /// The truth in words, of the sweep or of the stress test.
    pub(crate) truth: String,
    /// The commands that measured it.
    pub(crate) commands: Vec<String>,
    /// Versions of the program that measured it.
    pub(crate) versions: Vec<String>,
    /// Of the sweep; empty without one.
    pub(crate) points: Vec<Point>,
    /// Of the stress test; empty without one.
    pub(crate) stress: Vec<StressPoint>,
    /// Of the stress test.
    pub(crate) failures: Vec<BreakingPoint>,
    /// The fewest views that show everything, where they were chosen.
    pub(crate) views: Option<ChosenViews>,
    /// The worst views of the sweep's default.
    pub(crate) worst: Vec<Figure>,
    /// At the breaking points of the stress test.
    pub(crate) breaking: Vec<Figure>,
}

/// A picture with what it shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Figure {
    pub(crate) caption: String,
    pub(crate) png: Vec<u8>,
}
