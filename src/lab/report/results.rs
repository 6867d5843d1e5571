//! What a page is made from.

use crate::stress::{BreakingPoint, StressPoint};
use crate::sweep::Point;
use crate::tune::ChosenViews;

/// What was measured on one capture.
#[derive(Debug, Default)]
pub struct CaptureResults {
    /// Name of the capture.
    pub name: String,
    /// The truth in words, of the sweep or of the stress test.
    pub truth: String,
    /// The commands that measured it.
    pub commands: Vec<String>,
    /// Versions of the program that measured it.
    pub versions: Vec<String>,
    /// Points of the sweep; empty without one.
    pub points: Vec<Point>,
    /// Points of the stress test; empty without one.
    pub stress: Vec<StressPoint>,
    /// Breaking points of the stress test.
    pub failures: Vec<BreakingPoint>,
    /// The fewest views that show everything, where they were chosen.
    pub views: Option<ChosenViews>,
    /// The worst views of the sweep's default.
    pub worst: Vec<CaptionedPicture>,
    /// At the breaking points of the stress test.
    pub breaking: Vec<CaptionedPicture>,
}

/// A picture with what it shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptionedPicture {
    /// What it shows, in a sentence.
    pub caption: String,
    /// The picture as a file in PNG.
    pub png: Vec<u8>,
}
